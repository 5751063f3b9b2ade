//! Which surfaces stand in the light of a map.

use glam::{DMat4, DVec3, DVec4};

use super::maps::Map;
use crate::plan::Geometry;
use crate::scene::lighting::ResolvedLight;
use crate::scene::{LightKind, Scene};

/// Instances of one of the plan's draws that are drawn into a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CasterDraw {
    /// Index into [`Geometry::draws`].
    pub draw: usize,
    /// First instance.
    pub instance_offset: u32,
    /// Instances.
    pub instance_count: u32,
}

/// Eight corners in view space of each instance of each opaque draw, in their order.
pub struct Boxes {
    corners: Vec<Vec<[DVec3; 8]>>,
    first_instances: Vec<u32>,
}

/// Corners of a box.
pub fn corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, axis: usize| if i & bit != 0 { max[axis] } else { min[axis] };
        DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
    })
}

/// Nothing of the hull of these points can be in the clip volume: all are beyond one of its sides, or behind the light.
pub fn is_outside(to_clip: &DMat4, points: &[DVec3; 8]) -> bool {
    let clip = points.map(|p| *to_clip * p.extend(1.0));
    let all = |beyond: fn(&DVec4) -> bool| clip.iter().all(beyond);
    all(|c| c.x > c.w) || all(|c| c.x < -c.w) || all(|c| c.y > c.w) || all(|c| c.y < -c.w) || all(|c| c.w <= 0.0)
}

impl Boxes {
    pub fn new(scene: &Scene, geometry: &Geometry) -> Self {
        let of_place = |place: usize| {
            let mut bounds = crate::scene::Bounds::EMPTY;
            for position in &scene.meshes[geometry.places[place].mesh].positions {
                bounds.include(DVec3::from_array(position.map(f64::from)));
            }
            corners(bounds.min, bounds.max)
        };
        let mut known: std::collections::BTreeMap<usize, [DVec3; 8]> = std::collections::BTreeMap::new();
        let mut all = Vec::with_capacity(geometry.draws.len());
        for draw in &geometry.draws {
            let local = *known.entry(draw.place).or_insert_with(|| of_place(draw.place));
            let (first, count) = (draw.instance_offset as usize, draw.instance_count as usize);
            let placed = geometry.instances[first..first + count].iter().map(|instance| {
                let column = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
                let axes =
                    [instance.object_to_view_x, instance.object_to_view_y, instance.object_to_view_z].map(column);
                let origin = column(instance.object_to_view_w);
                local.map(|p| axes[0] * p.x + axes[1] * p.y + axes[2] * p.z + origin)
            });
            all.push(placed.collect());
        }
        Self { corners: all, first_instances: geometry.draws.iter().map(|draw| draw.instance_offset).collect() }
    }

    /// Runs of instances that may stand in the map's light.
    pub fn seen_by(&self, map: &Map, world_to_view: &DMat4, light: &ResolvedLight) -> Vec<CasterDraw> {
        let place = world_to_view.transform_point3(light.position);
        let out_of_range = |corners: &[DVec3; 8]| {
            let (min, max) = corners.iter().fold((corners[0], corners[0]), |(a, b), p| (a.min(*p), b.max(*p)));
            place.clamp(min, max).distance(place) > light.range
        };
        let local = light.kind != LightKind::Directional;
        let clear = |corners: &[DVec3; 8]| is_outside(&map.view_to_map, corners) || (local && out_of_range(corners));
        let mut draws: Vec<CasterDraw> = Vec::new();
        for (draw, (boxes, first)) in self.corners.iter().zip(&self.first_instances).enumerate() {
            for (index, _) in boxes.iter().enumerate().filter(|(_, corners)| !clear(corners)) {
                let at = first + index as u32;
                match draws.last_mut() {
                    Some(run) if run.draw == draw && run.instance_offset + run.instance_count == at => {
                        run.instance_count += 1
                    }
                    _ => draws.push(CasterDraw { draw, instance_offset: at, instance_count: 1 }),
                }
            }
        }
        draws
    }
}
