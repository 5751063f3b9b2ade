//! Shadows: which lights have them, and maps of depth as each of these lights sees the scene, side by side in one image.
//!
//! A spot light of at most 60 degrees to a side has one map, any other light at a place one for each side of a cube that it shines on, a
//! directional light up to four ("cascades"), each four times as deep as the one before (F. Zhang et al., "Parallel-Split Shadow Maps for
//! Large-scale Virtual Environments", 2006, with logarithmic splits). A map is drawn only where light can reach something that is seen.

mod casters;
mod maps;
mod select;

use super::effects::Effect;
use super::{Geometry, Limits, Plan, Request, ShadowUpdate};
use crate::error::{Error, Result};
use crate::scene::lighting::Lighting;
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
    directional: u32,
    first_local: u32,
    why: String,
}

impl Shadows {
    /// Maps for the lights that `selection` chose; `None` where there are none, or nothing stands in the way of their light.
    ///
    /// # Errors
    /// More maps than the largest image holds in the smallest size.
    pub(super) fn new(
        scene: &Scene,
        (lighting, selection): (&Lighting, &Selection),
        (view, geometry): (&View, &Geometry),
        (request, limits): (&Request, &Limits),
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        if selection.chosen == 0 || geometry.draws.is_empty() {
            return Ok(None);
        }
        let world = maps::World::new(scene, view);
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
            directional: 0,
            first_local: lighting.lights.iter().filter(|l| l.kind == LightKind::Directional).count() as u32,
            why: selection.why.clone(),
        };
        let boxes = casters::Boxes::new(scene, geometry);
        // Which of them there are does not hang on their size, but for a texel: they are made once more if they have to shrink.
        planned.add_maps(lighting, &world, margin, &boxes);
        if planned.drawn() == 0 {
            return Ok(None);
        }
        let size = fitting(planned.drawn(), request.shadow_size, limits)?;
        if size != planned.size {
            if request.strict {
                return Err(Error::new(format!(
                    "--shadow-size {}: {} maps do not fit into this device's largest image",
                    planned.size,
                    planned.drawn()
                )));
            }
            notes.push(format!(
                "shadow maps have {size} columns and rows instead of {}: {} of them have to fit into one image",
                planned.size,
                planned.drawn()
            ));
            planned.size = size;
            planned.add_maps(lighting, &world, margin, &boxes);
        }
        planned.place(limits);
        Ok(Some(planned))
    }

    /// Maps of all lights that have shadows. Where nothing stands in the way of what is seen there is none.
    fn add_maps(&mut self, lighting: &Lighting, world: &maps::World, margin: f64, boxes: &casters::Boxes) {
        (self.lights, self.maps, self.kinds, self.directional) = (Vec::new(), Vec::new(), 0, 0);
        let shadowed = |directional: bool| {
            let of_kind = move |kind| (kind == LightKind::Directional) == directional;
            lighting.lights.iter().enumerate().filter(move |(_, l)| l.shadow && of_kind(l.kind))
        };
        for (index, light) in shadowed(true).chain(shadowed(false)) {
            let first_map = self.maps.len();
            let (mut made, cube_rows) = maps::of_light(light, world, self.size, margin);
            for map in made.iter_mut().filter(|map| map.area[2] > 0) {
                map.draws = boxes.seen_by(map, &world.world_to_view, light);
                if map.draws.is_empty() {
                    map.area = [0; 4];
                }
            }
            self.maps.extend(made);
            self.kinds |= super::lights::kind_of(light);
            self.directional += u32::from(light.kind == LightKind::Directional);
            self.lights.push(ShadowedLight {
                light: index,
                first_map,
                map_count: self.maps.len() - first_map,
                cube_rows,
            });
        }
    }

    /// Maps that have a place in the image.
    pub fn drawn(&self) -> usize {
        self.maps.iter().filter(|map| map.area[2] > 0).count()
    }

    /// Gives each map that is drawn its place.
    fn place(&mut self, limits: &Limits) {
        let (count, most) = (self.drawn() as u32, (limits.max_image_dimension / self.size).max(1));
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

    /// Bytes of the image and of what shading is told.
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.atlas.map(u64::from);
        width * height * super::DEPTH_BYTES + self.texels().len() as u64 * 16
    }

    /// Iterations that a sample's loops may go round in the shadows of all lights.
    fn iterations(&self) -> u32 {
        let row = self.filter + 1;
        let filter = if self.filter == 0 { 0 } else { row * (row + 1) };
        // Four runs of the table begin and end, each with groups of their own.
        let runs = 4 * 4;
        self.lights.iter().map(|light| light.map_count.saturating_sub(1).min(3) as u32 + filter).sum::<u32>() + runs
    }

    /// The limits that are left to loops over lights.
    ///
    /// # Errors
    /// Shadows that take more than half of a driver's iterations.
    pub(super) fn leave(&self, limits: &Limits) -> Result<Limits> {
        let most = limits.max_loop_iterations;
        if most != u32::MAX && self.iterations() > most / 2 {
            return Err(Error::new(format!(
                "a sample may look at the shadows of {} lights in up to {} iterations, this driver leaves its loops after {most}",
                self.lights.len(),
                self.iterations()
            )));
        }
        let left = if most == u32::MAX { most } else { most - self.iterations() };
        Ok(Limits { max_loop_iterations: left, ..limits.clone() })
    }
}

/// Metres that a position may be off its surface: everywhere, and at a distance of 1 m. A rasteriser snaps corners to parts of a pixel, and with
/// them the plane whose depth it stores; a position that is made from that depth is off by as much, and f32 adds a few ulp.
fn position_slack(view: &View, farthest: f64, limits: &Limits) -> [f32; 2] {
    let snapped = super::tiles::pixel_size(view) * 2f64.sqrt() * (-f64::from(limits.sub_pixel_bits)).exp2();
    let rounded = farthest * f64::from(f32::EPSILON) * 4.0;
    if view.lens.is_perspective() { [rounded as f32, snapped as f32] } else { [(rounded + snapped) as f32, 0.0] }
}

/// The size that was asked for, halved until so many maps fit.
fn fitting(maps: usize, asked: u32, limits: &Limits) -> Result<u32> {
    let mut size = asked;
    while u64::from(limits.max_image_dimension / size).pow(2) < maps as u64 {
        size /= 2;
        if size < LEAST_SIZE {
            return Err(Error::new(format!(
                "{maps} shadow maps do not fit into this device's largest image; --shadows N chooses fewer lights"
            )));
        }
    }
    Ok(size)
}

/// The effect with its decision.
pub(super) fn effect(plan: &Plan, selection: &Selection) -> Effect {
    let (runs, why, bytes) = match &plan.shadows {
        _ if plan.shows_surfaces() => (false, "this view shows surfaces without light".into(), 0),
        None if selection.chosen > 0 => {
            (false, format!("{}: nothing stands in the way of their light", selection.why), 0)
        }
        None => (false, selection.why.clone(), 0),
        Some(shadows) => {
            let when = match shadows.update {
                ShadowUpdate::Once => "drawn once, for nothing moves",
                ShadowUpdate::Frame => "drawn in every frame",
            };
            let seen = shadows.drawn();
            let why = format!(
                "{}: {seen} of {} maps hold something that is seen or stands in its light; {} x {} texels, edges over {}; {when}",
                shadows.why,
                shadows.maps.len(),
                shadows.size,
                shadows.size,
                shadows.filter
            );
            (true, why, shadows.bytes())
        }
    };
    Effect::new("shadows", runs, why, bytes)
}

#[cfg(test)]
mod tests;
