//! How each light sees the scene: matrices from view space to its maps, all in f64.

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::casters::{CasterDraw, corners, is_outside};
use crate::scene::lighting::ResolvedLight;
use crate::scene::view::{Lens, View};
use crate::scene::{Bounds, LightKind, Scene};

/// Most maps of a directional light.
const CASCADES: u32 = 4;
/// How many times as deep as the one before each of them is.
const CASCADE_RATIO: f64 = 4.0;
/// A spot light that is wider to a side has the maps of a cube; at 60 degrees the texels at the edge are four times those in the middle.
const WIDEST_MAP: f64 = std::f64::consts::FRAC_PI_3;
/// The narrowest cone that is drawn: what it lights is smaller than a texel of anything.
const NARROWEST_MAP: f64 = 1e-4;
/// Distance before which nothing is drawn, in distances to the farthest thing that the light reaches. Reversed depth keeps its relative precision
/// up to there.
const NEAR: f64 = 1e-6;
/// What the size of maps hangs on is rounded to a power of 2^(1/STEPS): those of a moving camera keep their size.
const STEPS: f64 = 4.0;

/// One map of a light.
#[derive(Debug, Clone)]
pub struct Map {
    /// View to clip space, y down, depth reversed.
    pub view_to_map: DMat4,
    /// First column and row in the image, columns and rows; no columns where light of this map reaches nothing that is seen.
    pub area: [u32; 4],
    /// Metres that a texel spans, at a distance of 1 m from a light that has a place.
    pub texel_metres: f64,
    /// What stands in the light.
    pub draws: Vec<CasterDraw>,
}

impl Map {
    /// `SHADOW_MAP_TEXELS` of src/shared.rs.
    pub(super) fn texels(&self) -> [[f32; 4]; 5] {
        let [x, y, size, _] = self.area.map(f64::from);
        let row = |index: usize| self.view_to_map.row(index);
        let half = 0.5 * size;
        let rounded = |row: DVec4| row.as_vec4().to_array();
        [
            rounded(row(0) * half + row(3) * (half + x)),
            rounded(row(1) * half + row(3) * (half + y)),
            rounded(row(2)),
            rounded(row(3)),
            [x as f32, y as f32, size as f32, self.texel_metres as f32],
        ]
    }
}

/// Texels at each edge of a map that what is seen stays clear of: as far as a filter of so many texels reaches, a texel for snapping, and as much
/// as the filter's reach for what positions are moved by.
pub(super) fn margin(filter: u32) -> f64 {
    f64::from(filter + 1) + 2.0
}

/// What the maps of all lights are made for.
pub(super) struct World {
    /// Box of the scene, world space.
    bounds: Bounds,
    pub world_to_view: DMat4,
    view_to_world: DMat4,
    lens: Lens,
    near: f64,
    /// Metres to the farthest thing that can be seen.
    pub farthest: f64,
    /// Corners in view space of all that can be seen.
    seen: [DVec3; 8],
    /// Light matters wherever it falls, seen or not: it is reflected from there.
    everywhere: bool,
}

impl World {
    /// `extent` is the distance in metres from the eye beyond which nothing is drawn.
    pub fn new(scene: &Scene, view: &View, extent: f64, everywhere: bool) -> Self {
        let bounds = scene.bounds();
        let ahead = corners(bounds.min, bounds.max).map(|p| -view.world_to_view.transform_point3(p).z);
        let nearest = ahead.into_iter().fold(f64::INFINITY, f64::min);
        let farthest = view.zfar.map_or(extent, |far| far.min(extent)).max(view.znear + 1e-6);
        Self {
            bounds,
            world_to_view: view.world_to_view,
            view_to_world: view.world_to_view.inverse(),
            lens: view.lens,
            near: nearest.max(view.znear),
            farthest,
            seen: slice(&view.lens, view.znear, farthest),
            everywhere,
        }
    }

    /// Nothing of the hull of what can be seen is in the clip volume.
    pub fn sees_nothing_of(&self, view_to_map: &DMat4) -> bool {
        !self.everywhere && is_outside(view_to_map, &self.seen)
    }

    /// Metres from a place to the farthest corner of the scene.
    fn farthest_from(&self, place: DVec3) -> f64 {
        corners(self.bounds.min, self.bounds.max).iter().map(|p| p.distance(place)).fold(0.0, f64::max)
    }

    /// Distances at which the cascades of a directional light begin and end: from the nearest thing that can be seen to the farthest.
    fn slices(&self) -> Vec<[f64; 2]> {
        if !self.lens.is_perspective() {
            return vec![[self.near.min(self.farthest), self.farthest]];
        }
        let far = stepped(self.farthest);
        let near = ((self.near.log2() * STEPS).floor() / STEPS).exp2();
        let ends = (0..CASCADES).map(|i| far / CASCADE_RATIO.powi((CASCADES - 1 - i) as i32));
        let ends: Vec<f64> = ends.filter(|end| *end > near).collect();
        let begins = std::iter::once(near).chain(ends.iter().copied());
        begins.zip(&ends).map(|(begin, end)| [begin, *end]).collect()
    }
}

/// Rounded up to a power of 2^(1/STEPS).
fn stepped(metres: f64) -> f64 {
    ((metres.max(1e-30).log2() * STEPS).ceil() / STEPS).exp2()
}

/// Corners of what is seen between two distances, view space.
fn slice(lens: &Lens, near: f64, far: f64) -> [DVec3; 8] {
    let e = lens.extents();
    let scale = |distance: f64| if lens.is_perspective() { distance } else { 1.0 };
    std::array::from_fn(|i| {
        let distance = if i & 4 == 0 { near } else { far };
        let x = if i & 1 == 0 { e.left } else { e.right };
        let y = if i & 2 == 0 { e.bottom } else { e.top };
        DVec3::new(x * scale(distance), y * scale(distance), -distance)
    })
}

/// A rotation to axes of which the third is `ahead`.
fn looking(ahead: DVec3) -> [DVec3; 3] {
    let up = if ahead.y.abs() > 0.99 { DVec3::X } else { DVec3::Y };
    let right = ahead.cross(up).normalize();
    [right, ahead.cross(right), ahead]
}

/// World to clip space of a square pyramid from `place`, `half` its half width at 1 m; depth is `near` over distance.
fn pyramid(place: DVec3, [right, down, ahead]: [DVec3; 3], half: f64, near: f64) -> DMat4 {
    let row = |axis: DVec3, scale: f64| axis.extend(-axis.dot(place)) * scale;
    let depth = DVec4::new(0.0, 0.0, 0.0, near);
    DMat4::from_cols_array_2d(
        &[row(right, 1.0 / half), row(down, 1.0 / half), depth, row(ahead, 1.0)].map(|r| r.to_array()),
    )
    .transpose()
}

/// Most maps that such a light has, wherever it stands and however it turns.
pub(super) fn most_maps(light: &ResolvedLight) -> u32 {
    match light.kind {
        // And one of everything.
        LightKind::Directional => CASCADES + 1,
        LightKind::Spot { outer, .. } if f64::from(outer) <= WIDEST_MAP => 1,
        _ => 6,
    }
}

/// The maps of a light, and rows to the axes of its cube.
pub(super) fn of_light(light: &ResolvedLight, world: &World, size: u32, margin: f64) -> (Vec<Map>, [[f32; 4]; 3]) {
    let none = [[0.0; 4]; 3];
    match light.kind {
        LightKind::Directional => (cascades(light, world, size, margin), none),
        LightKind::Spot { outer, .. } if f64::from(outer) <= WIDEST_MAP => {
            let half = f64::from(outer).max(NARROWEST_MAP).tan();
            (vec![local_map(light, world, looking(light.direction.normalize()), half, size, margin)], none)
        }
        _ => {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            let sides = axes.into_iter().flat_map(|axis| [axis, -axis]);
            let maps = sides.map(|ahead| {
                let mut map = local_map(light, world, looking(ahead), 1.0, size, margin);
                if !shines_on(light, ahead) {
                    map.area = [0; 4];
                }
                map
            });
            let place = world.world_to_view.transform_point3(light.position);
            let rows = axes.map(|axis| {
                let axis = world.world_to_view.transform_vector3(axis);
                axis.extend(-axis.dot(place)).as_vec4().to_array()
            });
            (maps.collect(), rows)
        }
    }
}

/// Some direction of a cube's side lies in the light's cone. The corners of a side are acos(1 / sqrt 3) from its middle.
fn shines_on(light: &ResolvedLight, ahead: DVec3) -> bool {
    let LightKind::Spot { outer, .. } = light.kind else { return true };
    let apart = light.direction.normalize().dot(ahead).clamp(-1.0, 1.0).acos();
    apart <= f64::from(outer) + (1.0 / 3f64.sqrt()).acos() + 1e-6
}

/// A map of what lies between four planes through the light; `half` is the tangent that has to be inside of the margin.
fn local_map(light: &ResolvedLight, world: &World, axes: [DVec3; 3], half: f64, size: u32, margin: f64) -> Map {
    let columns = f64::from(size);
    let padded = half * columns / (columns - 2.0 * margin);
    let near = NEAR * light.range.min(world.farthest_from(light.position)).max(f64::MIN_POSITIVE);
    let of = |half: f64| pyramid(light.position, axes, half, near) * world.view_to_world;
    // What the margin alone sees is in another map.
    let area = if world.sees_nothing_of(&of(half * (1.0 + 1e-6))) { [0; 4] } else { [0, 0, size, size] };
    Map { view_to_map: of(padded), area, texel_metres: 2.0 * padded / columns, draws: Vec::new() }
}

/// Whether the cone of a spot light shines on anything that can be seen, as far as planes tell; true for other lights.
pub(super) fn shines_into_view(light: &ResolvedLight, world: &World) -> bool {
    let LightKind::Spot { outer, .. } = light.kind else { return true };
    if world.everywhere {
        return true;
    }
    let (axis, outer) = (light.direction.normalize(), f64::from(outer));
    if outer <= WIDEST_MAP {
        let half = outer.max(NARROWEST_MAP).tan() * (1.0 + 1e-6);
        let to_map = pyramid(light.position, looking(axis), half, 1.0) * world.view_to_world;
        return !world.sees_nothing_of(&to_map);
    }
    // Beyond that a half space is as good as anything; a wider cone has none.
    let ahead = |p: &DVec3| axis.dot(world.view_to_world.transform_point3(*p) - light.position);
    outer >= std::f64::consts::FRAC_PI_2 || world.seen.iter().any(|p| ahead(p) > 0.0)
}

/// Whether the scene's box reaches into the ball of a light.
pub(super) fn reaches_scene(light: &ResolvedLight, world: &World) -> bool {
    light.position.clamp(world.bounds.min, world.bounds.max).distance(light.position) < light.range
}

/// Maps of what is seen, from the finest to that of everything. Their squares are as wide as the sphere about their part of the view, however the
/// camera turns, and begin at whole texels of a grid that stands still in the world: an edge of a shadow does not crawl.
fn cascades(light: &ResolvedLight, world: &World, size: u32, margin: f64) -> Vec<Map> {
    let [right, down, ahead] = looking(light.direction.normalize());
    let to_plane = |p: DVec3| DVec2::new(right.dot(p), down.dot(p));
    let scene = corners(world.bounds.min, world.bounds.max);
    let (low, high) = scene
        .iter()
        .map(|p| to_plane(*p))
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let depths: Vec<f64> = scene.iter().map(|p| ahead.dot(*p)).collect();
    let (nearest, last) = depths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(*d), b.max(*d)));
    // Something to divide by, and to either side of what touches the box.
    let slack = ((last - nearest).abs() + last.abs().max(nearest.abs()) * 1e-9) * 1e-3 + 1e-9;
    let (nearest, depth) = (nearest - slack, last - nearest + 2.0 * slack);
    let whole = ((high - low).max_element() * 0.5).max(1e-9);
    let mut maps = Vec::new();
    // What is not seen lies in a map of everything, behind those of what is.
    let unseen = world.everywhere.then_some(None);
    for part in world.slices().into_iter().map(Some).chain(unseen) {
        let [begin, end] = part.unwrap_or([world.near.min(world.farthest), world.farthest]);
        let points = slice(&world.lens, begin, end);
        let middle = points.iter().sum::<DVec3>() / 8.0;
        let radius = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        // How deep the view of parallel rays is changes with every step of the camera.
        let radius = if world.lens.is_perspective() { radius } else { stepped(radius) };
        // A map of the whole scene is as good as one of a part that is larger.
        let all = part.is_none() || radius >= whole;
        let (center, half) = if all {
            ((low + high) * 0.5, whole)
        } else {
            (to_plane(world.view_to_world.transform_point3(middle)), radius)
        };
        let columns = f64::from(size);
        let texel = 2.0 * half / (columns - 2.0 * margin);
        let (center, half) = ((center / texel).round() * texel, texel * columns * 0.5);
        let row = |axis: DVec3, offset: f64| (axis / half).extend(-offset / half);
        let rows =
            [row(right, center.x), row(down, center.y), (-ahead / depth).extend((nearest + depth) / depth), DVec4::W];
        let world_to_map = DMat4::from_cols_array_2d(&rows.map(|r| r.to_array())).transpose();
        let view_to_map = world_to_map * world.view_to_world;
        maps.push(Map { view_to_map, area: [0, 0, size, size], texel_metres: texel, draws: Vec::new() });
        if all {
            break;
        }
    }
    maps
}
