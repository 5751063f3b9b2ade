//! Shadows: which lights have them, and maps of depth as each of these lights sees the scene, side by side in one image.
//!
//! A spot light of at most 60 degrees to a side has one map, any other light at a place one for each side of a cube that it shines on, a
//! directional light up to four ("cascades"), each four times as deep as the one before (F. Zhang et al., "Parallel-Split Shadow Maps for
//! Large-scale Virtual Environments", 2006, with logarithmic splits). A map is drawn only where light can reach something that is seen.

mod casters;
mod maps;
mod select;

use super::effects::Effect;
use super::{Geometry, Limits, Plan, Request, ShadowUpdate, Technique};
use crate::error::{Error, Result};
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;
use crate::scene::{LightKind, Scene};
use crate::shared;

pub use casters::CasterDraw;
pub use maps::Map;
pub(super) use select::{Selection, select};

/// Columns and rows of a map where nothing is said.
pub const DEFAULT_SIZE: u32 = 1024;
/// Texels that the edge of a shadow is spread over where nothing is said.
pub const DEFAULT_FILTER: u32 = 2;
/// Most that may be asked for.
pub const MOST_FILTER: u32 = 8;
/// Largest map.
pub const MOST_SIZE: u32 = 8192;
/// Of the image of all maps, unless there is only one.
const MOST_BYTES: u64 = 1 << 30;
/// Smallest map: two margins of the widest filter leave it something.
pub const LEAST_SIZE: u32 = 64;

/// A light with a shadow.
#[derive(Debug, Clone)]
pub struct ShadowedLight {
    /// Index into [`Lighting::lights`].
    pub light: usize,
    /// First of [`Shadows::maps`].
    pub first_map: usize,
    /// 1, 6 for a cube, as many as cascades.
    pub map_count: usize,
    /// Rows from view space to the axes of the cube; zeros where there is none.
    cube_rows: [[f32; 4]; 3],
}

/// Everything about the shadows of a picture.
#[derive(Debug, Clone)]
pub struct Shadows {
    /// Directional ones first, in the order of the light table.
    pub lights: Vec<ShadowedLight>,
    /// By light.
    pub maps: Vec<Map>,
    /// Columns and rows of each map.
    pub size: u32,
    /// Texels that the edge of a shadow is spread over; 0: it follows the map's texels.
    pub filter: u32,
    /// Columns and rows of the image of all maps.
    pub atlas: [u32; 2],
    /// When maps are drawn.
    pub update: ShadowUpdate,
    /// Bits `KIND_*` of lights that have shadows.
    pub kinds: u32,
    /// Metres that a position may be off its surface: everywhere, and at a distance of 1 m.
    slack: [f32; 2],
    /// Lights may move: room for all maps that each can have, whatever they show now.
    reserved: Option<u32>,
    directional: u32,
    first_local: u32,
    why: String,
}

/// What shadows are planned from.
pub(super) struct Inputs<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub geometry: &'a Geometry,
    pub request: &'a Request,
    pub limits: &'a Limits,
    /// Metres from the eye beyond which nothing is drawn.
    pub extent: f64,
}

impl Shadows {
    /// Maps for the lights that `selection` chose; `None` where there are none, where nothing stands in the way of their light, or where rays or
    /// surfaces are drawn instead. Lights that need no map have no shadow afterwards.
    ///
    /// # Errors
    /// Numbers that no map has; more maps than the largest image holds in the smallest size, or than a texel buffer tells of.
    pub(super) fn new(
        inputs: &Inputs,
        lighting: &mut Lighting,
        selection: &Selection,
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let Inputs { request, limits, view, .. } = *inputs;
        check_numbers(request)?;
        let surfaces = request.debug_view.is_some_and(super::DebugView::of_surfaces);
        let drawn = request.technique != Technique::Reference && !surfaces && !inputs.geometry.draws.is_empty();
        if selection.chosen == 0 || !drawn {
            return Ok(None);
        }
        let world = maps::World::new(inputs.scene, view, inputs.extent, request.gi != super::Gi::Off);
        let margin = maps::margin(request.shadow_filter);
        let mut planned = Self {
            lights: Vec::new(),
            maps: Vec::new(),
            size: request.shadow_size,
            filter: request.shadow_filter,
            update: request.shadow_update,
            atlas: [0; 2],
            kinds: 0,
            slack: position_slack(view, world.farthest, limits),
            reserved: request.lights_move.then(|| shadowed(lighting).map(|(_, light)| maps::most_maps(light)).sum()),
            directional: 0,
            first_local: lighting.lights.iter().filter(|l| l.kind == LightKind::Directional).count() as u32,
            why: selection.why.clone(),
        };
        let boxes = casters::Boxes::new(inputs.scene, inputs.geometry);
        planned.add_maps(lighting, &world, margin, &boxes);
        // Margins of smaller maps are wider, so that there may be more to draw: until as many as there are fit.
        while !fits(planned.places(), planned.size, limits) {
            planned.size /= 2;
            if planned.size < LEAST_SIZE {
                let count = planned.places();
                return Err(Error::new(format!(
                    "{count} shadow maps do not fit into this device's largest image; --shadows N chooses fewer lights"
                )));
            }
            planned.add_maps(lighting, &world, margin, &boxes);
        }
        if planned.size != request.shadow_size {
            let (asked, size, count) = (request.shadow_size, planned.size, planned.places());
            if request.strict {
                return Err(Error::new(format!(
                    "--shadow-size {asked}: {count} maps do not fit into this device's largest image, or into 1 GiB"
                )));
            }
            notes.push(format!(
                "shadow maps have {size} columns and rows instead of {asked}: {count} of them have to fit into one image of at most 1 GiB"
            ));
        }
        if planned.reserved.is_none() {
            planned.leave_out_idle(lighting);
        } else {
            planned.count(lighting);
        }
        planned.place(limits);
        let texels = planned.most_texels();
        match (planned.places(), texels > limits.max_texel_elements) {
            (0, _) => Ok(None),
            (_, false) => Ok(Some(planned)),
            (_, true) => Err(Error::new(format!(
                "{} lights with shadows take {texels} texels to tell of, this device's texel buffers have {}",
                planned.lights.len(),
                limits.max_texel_elements
            ))),
        }
    }

    /// Maps of all lights that have shadows. Where nothing stands in the way of what is seen there is none.
    fn add_maps(&mut self, lighting: &Lighting, world: &maps::World, margin: f64, boxes: &casters::Boxes) {
        (self.lights, self.maps, self.kinds, self.directional) = (Vec::new(), Vec::new(), 0, 0);
        for (index, light) in shadowed(lighting) {
            let first_map = self.maps.len();
            let (mut made, cube_rows) = maps::of_light(light, world, self.size, margin);
            for map in made.iter_mut().filter(|map| map.area[2] > 0) {
                if light.intensity.max_element() > 0.0 {
                    map.draws = boxes.seen_by(map, &world.world_to_view, light);
                }
                if map.draws.is_empty() {
                    map.area = [0; 4];
                }
            }
            let map_count = made.len();
            self.maps.extend(made);
            self.lights.push(ShadowedLight { light: index, first_map, map_count, cube_rows });
        }
    }

    /// Takes lights without any map out of those that have shadows, and puts the others in front again.
    fn leave_out_idle(&mut self, lighting: &mut Lighting) {
        let has_map = |light: &ShadowedLight| {
            self.maps[light.first_map..light.first_map + light.map_count].iter().any(|map| map.area[2] > 0)
        };
        let (kept, idle): (Vec<_>, Vec<_>) = self.lights.drain(..).partition(has_map);
        idle.iter().for_each(|light| lighting.lights[light.light].shadow = false);
        lighting.lights.sort_by_key(|light| !light.shadow);
        let mut maps = Vec::new();
        for (light, (index, _)) in kept.into_iter().zip(shadowed(lighting)) {
            let first_map = maps.len();
            maps.extend_from_slice(&self.maps[light.first_map..light.first_map + light.map_count]);
            self.lights.push(ShadowedLight { light: index, first_map, ..light });
        }
        self.maps = maps;
        self.count(lighting);
    }

    /// Which kinds of lights have shadows.
    fn count(&mut self, lighting: &Lighting) {
        for (_, resolved) in shadowed(lighting) {
            self.kinds |= super::lights::kind_of(resolved);
            self.directional += u32::from(resolved.kind == LightKind::Directional);
        }
    }

    /// Lights may move: places and pipelines are there for all that may then be drawn.
    pub fn holds_places(&self) -> bool {
        self.reserved.is_some()
    }

    /// Places for maps in the image.
    fn places(&self) -> usize {
        self.reserved.map_or_else(|| self.drawn(), |reserved| reserved as usize)
    }

    /// Maps that have a place in the image.
    pub fn drawn(&self) -> usize {
        self.maps.iter().filter(|map| map.area[2] > 0).count()
    }

    /// Gives each map that is drawn its place.
    fn place(&mut self, limits: &Limits) {
        let (count, most) = (self.places() as u32, (limits.max_image_dimension / self.size).max(1));
        let columns = (f64::from(count).sqrt().ceil() as u32).clamp(1, most);
        let drawn = self.maps.iter_mut().filter(|map| map.area[2] > 0);
        for (place, map) in drawn.enumerate() {
            let place = place as u32;
            map.area[0] = place % columns * self.size;
            map.area[1] = place / columns * self.size;
        }
        self.atlas = [columns.min(count.max(1)) * self.size, count.div_ceil(columns).max(1) * self.size];
    }

    /// What shading is told (`SHADOW_*_TEXELS` of src/shared.rs).
    pub fn texels(&self) -> Vec<[f32; 4]> {
        let local = self.lights.len() as u32 - self.directional;
        let mut texels = vec![[self.directional as f32, self.first_local as f32, local as f32, 0.0]];
        let first = shared::SHADOW_HEAD_TEXELS as usize + self.lights.len() * shared::SHADOW_LIGHT_TEXELS as usize;
        for light in &self.lights {
            let at = first + light.first_map * shared::SHADOW_MAP_TEXELS as usize;
            texels.push([at as f32, light.map_count as f32, self.slack[0], self.slack[1]]);
            texels.extend(light.cube_rows);
        }
        texels.extend(self.maps.iter().flat_map(Map::texels));
        texels
    }

    /// How many of these there may be.
    pub fn most_texels(&self) -> u64 {
        let missing = self.reserved.map_or(0, |reserved| reserved as usize - self.maps.len());
        self.texels().len() as u64 + missing as u64 * u64::from(shared::SHADOW_MAP_TEXELS)
    }

    /// Bytes of the image of all maps.
    pub fn image_bytes(&self) -> u64 {
        let [width, height] = self.atlas.map(u64::from);
        width * height * super::DEPTH_BYTES
    }

    /// Bytes of what shading is told.
    pub fn texel_bytes(&self) -> u64 {
        self.most_texels() * 16
    }

    /// Iterations that the loops of a sample may go round in the shadows of all lights, the one in which each loop ends counted.
    fn iterations(&self) -> u64 {
        let side = u64::from(self.filter) + 1;
        let filter = if self.filter == 0 { 0 } else { side * (side + 1) + side + 1 };
        // Four runs of the table begin and end, each with groups of their own.
        let runs = 4 * 4;
        let cascades = |light: &ShadowedLight| if self.reserved.is_some() { 5 } else { light.map_count.min(5) as u64 };
        self.lights.iter().map(|light| cascades(light) + filter).sum::<u64>() + runs
    }

    /// The limits that are left to loops over lights where an invocation shades up to `each` samples.
    ///
    /// # Errors
    /// Shadows that take more than half of a driver's iterations.
    pub(super) fn leave(&self, each: u32, limits: &Limits) -> Result<Limits> {
        let (most, taken) = (limits.max_loop_iterations, self.iterations() * u64::from(each));
        if most == u32::MAX {
            return Ok(limits.clone());
        }
        if taken > u64::from(most / 2) {
            return Err(Error::new(format!(
                "an invocation may look at the shadows of {} lights in up to {taken} iterations, this driver leaves its loops after {most}",
                self.lights.len()
            )));
        }
        Ok(Limits { max_loop_iterations: most - taken as u32, ..limits.clone() })
    }
}

/// Lights that have shadows with their index, in the order of the light table.
fn shadowed(lighting: &Lighting) -> impl Iterator<Item = (usize, &ResolvedLight)> {
    let of = |directional: bool| {
        let is_one = move |l: &ResolvedLight| l.shadow && (l.kind == LightKind::Directional) == directional;
        lighting.lights.iter().enumerate().filter(move |(_, l)| is_one(l))
    };
    of(true).chain(of(false))
}

/// What the command line sees to already.
fn check_numbers(request: &Request) -> Result<()> {
    let Request { shadow_size: size, shadow_filter: filter, .. } = *request;
    if !size.is_power_of_two() || !(LEAST_SIZE..=MOST_SIZE).contains(&size) {
        return Err(Error::usage(format!(
            "a shadow map has a power of two from {LEAST_SIZE} to {MOST_SIZE} columns, not {size}"
        )));
    }
    if filter > MOST_FILTER {
        return Err(Error::usage(format!(
            "edges of shadows are spread over at most {MOST_FILTER} texels, not {filter}"
        )));
    }
    Ok(())
}

/// Metres that a position may be off its surface: everywhere, and at a distance of 1 m. A rasteriser snaps corners to parts of a pixel, and with
/// them the plane whose depth it stores; a position that is made from that depth is off by as much, and f32 adds a few ulp.
fn position_slack(view: &View, farthest: f64, limits: &Limits) -> [f32; 2] {
    let snapped = super::tiles::pixel_size(view) * 2f64.sqrt() * (-f64::from(limits.sub_pixel_bits)).exp2();
    let rounded = farthest * f64::from(f32::EPSILON) * 4.0;
    if view.lens.is_perspective() { [rounded as f32, snapped as f32] } else { [(rounded + snapped) as f32, 0.0] }
}

/// So many maps lie beside one another in one image, of at most [`MOST_BYTES`].
fn fits(maps: usize, size: u32, limits: &Limits) -> bool {
    let (maps, side) = (maps as u64, u64::from(limits.max_image_dimension / size));
    // Places of a row that is not full take memory, too: at most one row, and a column.
    let texels = (maps + 2 * maps.isqrt() + 1) * u64::from(size).pow(2);
    maps <= side * side && (maps <= 1 || texels * super::DEPTH_BYTES <= MOST_BYTES)
}

/// Bytes of the maps of one light, at most: what leaving shadows out saves.
fn one_light(plan: &Plan, request: &Request) -> u64 {
    let maps = match plan.lights.kinds {
        0 => 0,
        shared::KIND_DIRECTIONAL => 4,
        _ => 6,
    };
    maps * u64::from(request.shadow_size).pow(2) * super::DEPTH_BYTES
}

/// The effect with its decision.
pub(super) fn effect(plan: &Plan, selection: &Selection, request: &Request) -> Effect {
    let (runs, why, bytes) = match &plan.shadows {
        _ if plan.shows_surfaces() => (false, "this view shows surfaces without light".into(), 0),
        _ if plan.technique == Technique::Reference && selection.chosen > 0 => {
            (true, format!("{}: a ray each", selection.why), 0)
        }
        _ if plan.technique == Technique::Reference => (false, selection.why.clone(), 0),
        None if selection.chosen > 0 => {
            let why = format!("{}: nothing stands in the way of their light", selection.why);
            (false, why, one_light(plan, request))
        }
        None => (false, selection.why.clone(), one_light(plan, request)),
        Some(shadows) => {
            let when = match shadows.update {
                ShadowUpdate::Once if request.lights_move => "when lights have moved",
                ShadowUpdate::Once => "once, for nothing moves",
                ShadowUpdate::Frame => "in every frame",
            };
            let why = format!(
                "{}: {} of {} maps have something to draw, {} x {} texels, edges over {}; drawn {when}",
                shadows.why,
                shadows.drawn(),
                shadows.maps.len(),
                shadows.size,
                shadows.size,
                shadows.filter
            );
            (true, why, shadows.image_bytes() + shadows.texel_bytes())
        }
    };
    Effect::new("shadows", runs, why, bytes)
}

#[cfg(test)]
mod tests;
