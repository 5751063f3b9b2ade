//! The exact volume of a cell, in f64, and how many lights' spheres meet it: against that lists are held, whatever samples there are.
//!
//! A volume is what lies between the planes through two columns' and two rows' edges, two distances and, where it is cut, the sides of a
//! box: a convex polyhedron. The point of it that is closest to another one lies on a face, an edge or a corner, so it is the foot of a
//! perpendicular to a plane, to the line in which two meet, or the point in which three meet. Those feet that lie in the polyhedron are
//! points of it, and the closest one is among them: the least distance to one of them is exact. Each foot is found by steps within the
//! planes that it lies in, so it stays in them to a few roundings however small their angle is.
//!
//! At the closest point some plane that it lies in has the other point outside: feet of other planes need not be looked at.

use glam::DVec3;
use rayon::prelude::*;

use super::light_pairs::Lists;
use crate::scene::LightKind;
use crate::scene::lighting::ResolvedLight;
use crate::scene::view::{Lens, View};

/// Part of its largest coordinate by which a foot may lie outside of a plane and count as in it.
const TOLERANCE: f64 = 1e-12;

/// Sine below which planes, or a line and a plane, count as parallel.
const PARALLEL: f64 = 1e-9;

/// Metres from which on a far plane is no plane.
const UNBOUNDED: f64 = 1e17;

/// Metres that stand for those in the box round a volume.
const FARTHEST: f64 = 1e30;

/// Inside where `normal . p <= offset`; the normal has length 1.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Signed distance; positive outside.
    fn excess(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// A convex piece of view space.
#[derive(Debug, Clone)]
pub struct Volume {
    planes: Vec<Plane>,
    low: DVec3,
    high: DVec3,
}

impl Volume {
    /// What the view sees between two edges of columns, two edges of rows and two distances along the view axis. Edge k is the left one
    /// of column k or the upper one of row k. A far distance of 1e17 m or more bounds nothing.
    pub fn piece(view: &View, columns: [u32; 2], rows: [u32; 2], [near, far]: [f64; 2]) -> Self {
        let [low, high] = extent(view, columns, rows, [near, far.min(FARTHEST)]);
        let [across, up] = image_edges(view, columns, rows);
        let mut planes = sides(&view.lens, across, DVec3::X).to_vec();
        planes.extend(sides(&view.lens, up, DVec3::Y));
        planes.push(Plane { normal: DVec3::Z, offset: -near });
        if far < UNBOUNDED {
            planes.push(Plane { normal: DVec3::NEG_Z, offset: far });
        }
        Self { planes, low, high }
    }

    /// The part between two values of x and two of y, metres.
    pub fn within(mut self, across: [f64; 2], up: [f64; 2]) -> Self {
        for ([low, high], axis) in [(across, DVec3::X), (up, DVec3::Y)] {
            self.planes.push(Plane { normal: -axis, offset: -low });
            self.planes.push(Plane { normal: axis, offset: high });
        }
        self.low = self.low.max(DVec3::new(across[0], up[0], self.low.z));
        self.high = self.high.min(DVec3::new(across[1], up[1], self.high.z));
        self
    }

    /// The point of the volume that is closest to `point`; `None` where the volume is empty.
    pub fn closest(&self, point: DVec3) -> Option<DVec3> {
        let mut outside: Vec<usize> = (0..self.planes.len()).filter(|&i| self.planes[i].excess(point) > 0.0).collect();
        outside.sort_by(|&a, &b| self.planes[b].excess(point).total_cmp(&self.planes[a].excess(point)));
        let Some(&farthest) = outside.first() else { return Some(point) };
        // No point of the volume is closer than the farthest plane.
        let foot = point - self.planes[farthest].normal * self.planes[farthest].excess(point);
        if self.holds(foot) {
            return Some(foot);
        }
        let feet = outside.iter().flat_map(|&index| self.feet(index, point));
        feet.min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
    }

    /// A sphere has more than its surface in common with the volume.
    pub fn touches(&self, center: DVec3, radius: f64) -> bool {
        let beside = center.max(self.low).min(self.high).distance_squared(center) >= radius * radius;
        !beside
            && self.planes.iter().all(|plane| plane.excess(center) < radius)
            && self.closest(center).is_some_and(|point| point.distance_squared(center) < radius * radius)
    }

    /// Feet on one plane, its edges and its corners that lie in the volume.
    fn feet(&self, index: usize, point: DVec3) -> Vec<DVec3> {
        let face = self.planes[index];
        let on_face = point - face.normal * face.excess(point);
        let mut feet = vec![on_face];
        for (i, second) in self.planes.iter().enumerate().filter(|&(i, _)| i != index) {
            let line = face.normal.cross(second.normal);
            let sine_squared = line.length_squared();
            if sine_squared < PARALLEL * PARALLEL {
                continue;
            }
            // Within the face, across the line, by a vector whose length is the sine.
            let on_line = on_face - line.cross(face.normal) * (second.excess(on_face) / sine_squared);
            feet.push(on_line);
            for (_, third) in self.planes.iter().enumerate().filter(|&(j, _)| j > i && j != index) {
                let slope = line.dot(third.normal);
                if slope * slope > PARALLEL * PARALLEL * sine_squared {
                    feet.push(on_line - line * (third.excess(on_line) / slope));
                }
            }
        }
        feet.retain(|&foot| self.holds(foot));
        feet
    }

    fn holds(&self, point: DVec3) -> bool {
        let size = point.abs().max_element();
        self.planes.iter().all(|plane| plane.excess(point) <= TOLERANCE * (size + plane.offset.abs()))
    }
}

/// The box round what [`Volume::piece`] makes of the same edges and distances: its lowest and its highest corner.
pub fn extent(view: &View, columns: [u32; 2], rows: [u32; 2], [near, far]: [f64; 2]) -> [DVec3; 2] {
    let [across, up] = image_edges(view, columns, rows).map(|[low, high]| match view.lens {
        Lens::Perspective(_) => [(low * near).min(low * far), (high * near).max(high * far)],
        Lens::Orthographic(_) => [low, high],
    });
    [DVec3::new(across[0], up[0], -far), DVec3::new(across[1], up[1], -near)]
}

/// Tangents, or metres, of both edges along x and along y, ascending.
fn image_edges(view: &View, columns: [u32; 2], rows: [u32; 2]) -> [[f64; 2]; 2] {
    // Centres of pixels lie at whole numbers.
    let corner = |end: usize| view.image_point(f64::from(columns[end]) - 0.5, f64::from(rows[end]) - 0.5);
    let (first, last) = (corner(0), corner(1));
    [[first.x.min(last.x), first.x.max(last.x)], [first.y.min(last.y), first.y.max(last.y)]]
}

/// Planes on both sides of what lies between two image edges of one axis.
fn sides(lens: &Lens, [low, high]: [f64; 2], axis: DVec3) -> [Plane; 2] {
    let side = |t: f64, sign: f64| match lens {
        Lens::Perspective(_) => Plane { normal: (axis + DVec3::Z * t) * (sign / t.hypot(1.0)), offset: 0.0 },
        Lens::Orthographic(_) => Plane { normal: axis * sign, offset: sign * t },
    };
    [side(low, -1.0), side(high, 1.0)]
}

/// What [`count`] finds, over the cells that have a volume.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct VolumeCounts {
    /// Entries of their lists.
    pub listed: u64,
    /// Pairs in which the light's sphere meets the cell's volume.
    pub touching: u64,
    /// Those of them that are not listed.
    pub unlisted: u64,
}

impl VolumeCounts {
    /// Listed over touching pairs: infinite where nothing touches, 1 where nothing is listed either.
    pub fn waste(&self) -> f64 {
        match (self.listed, self.touching) {
            (0, 0) => 1.0,
            (listed, touching) => listed as f64 / touching as f64,
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            listed: self.listed + other.listed,
            touching: self.touching + other.touching,
            unlisted: self.unlisted + other.unlisted,
        }
    }
}

/// Counts pairs of cell and light. `cells[c]` is what cell c consists of: nothing where no list is expected of it. Spot lights count as
/// the spheres of their range, as they do in lists; `lights` in the order of ids.
pub fn count(cells: &[Vec<Volume>], lists: &Lists, lights: &[ResolvedLight], view: &View) -> VolumeCounts {
    let placed = lights.iter().zip(0u32..).filter(|(light, _)| light.kind != LightKind::Directional);
    let sphere =
        |(light, id): (&ResolvedLight, u32)| (view.world_to_view.transform_point3(light.position), light.range, id);
    let spheres: Vec<(DVec3, f64, u32)> = placed.map(sphere).collect();
    let of_cell = |(cell, volumes): (usize, &Vec<Volume>)| {
        if volumes.is_empty() {
            return VolumeCounts::default();
        }
        let list = lists.of(cell as u32);
        let meets = |center: DVec3, radius: f64| volumes.iter().any(|volume| volume.touches(center, radius));
        let touching: Vec<u32> = spheres.iter().filter(|s| meets(s.0, s.1)).map(|s| s.2).collect();
        let unlisted = touching.iter().filter(|id| list.binary_search(id).is_err()).count();
        VolumeCounts { listed: list.len() as u64, touching: touching.len() as u64, unlisted: unlisted as u64 }
    };
    cells.par_iter().enumerate().map(of_cell).reduce(VolumeCounts::default, VolumeCounts::with)
}

#[cfg(test)]
mod tests;
