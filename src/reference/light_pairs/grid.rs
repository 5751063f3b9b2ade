//! Lights by place: which of them reach a position, without asking each.
//!
//! Ranges are parted into levels that span a factor of two, and the lights of a level stand in a uniform grid a little
//! coarser than its longest range: what reaches a position stands in that position's cell or a neighbour of it. Only
//! cells that hold a light exist, each as a run of a sorted list, so neither distance nor crowding costs memory.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

/// What a cell is longer than the longest range of its level, as a part of it.
const MARGIN: f64 = 1.0 / 1024.0;

/// Smallest cell, as a part of the largest coordinate: 2^-40.
///
/// With it and [`MARGIN`] rounding never parts a light from what it reaches. Their coordinates differ by less than the
/// range, so the exact quotients by the cell's size by less than 1 / (1 + 2^-10) < 1 - 2^-11. A light's quotient is at
/// most 2^40, that of a position it reaches at most 2^40 + 1, so each division is off by at most 2^-13: the rounded
/// quotients still differ by less than 1, and their floors by at most 1.
const SMALLEST_CELL: f64 = 1.0 / (1u64 << 40) as f64;

/// Cell indices past this are taken as this, so that a neighbour's index stays within 64 bits.
const FARTHEST_CELL: f64 = (1u64 << 60) as f64;

/// A point or spot light in view space.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    /// As lists name it.
    pub id: u32,
    /// Metres.
    pub position: DVec3,
    /// Metres, positive, may be infinite.
    pub range: f64,
    /// `None` for a point light.
    pub cone: Option<Cone>,
}

/// Where a spot light shines.
#[derive(Debug, Clone)]
pub(super) struct Cone {
    /// Unit.
    pub axis: DVec3,
    /// Cosine of the outer angle.
    pub cos_outer: f64,
}

impl Placed {
    /// Strictly inside the range and the cone. A spot light's own place counts as beside it, a cosine of 0, as in
    /// `reference::shade`.
    fn reaches(&self, position: DVec3) -> bool {
        let away = position - self.position;
        let distance_squared = away.length_squared();
        distance_squared < self.range * self.range
            && self.cone.as_ref().is_none_or(|cone| {
                let distance = distance_squared.sqrt().max(f64::MIN_POSITIVE);
                // A cosine that rounding lifts above 1 would lie inside a cone of angle 0. `ResolvedLight::cone` is
                // positive from the first cosine above that of the outer angle on.
                (away / distance).dot(cone.axis).min(1.0) > cone.cos_outer
            })
    }
}

/// All lights that stand somewhere.
#[derive(Debug)]
pub(super) struct Grid {
    levels: Vec<Level>,
    /// Of infinite range.
    unbounded: Vec<Placed>,
}

impl Grid {
    pub fn new(lights: Vec<Placed>) -> Self {
        let mut unbounded = Vec::new();
        let mut levels: BTreeMap<i32, Vec<Placed>> = BTreeMap::new();
        for light in lights {
            if light.range.is_infinite() {
                unbounded.push(light);
            } else {
                levels.entry(light.range.log2().ceil() as i32).or_default().push(light);
            }
        }
        Self { levels: levels.into_values().map(Level::new).collect(), unbounded }
    }

    /// Calls `found` once with the id of each light that reaches `position`, in no order.
    pub fn visit(&self, position: DVec3, mut found: impl FnMut(u32)) {
        for light in self.unbounded.iter().filter(|light| light.reaches(position)) {
            found(light.id);
        }
        for level in &self.levels {
            level.visit(position, &mut found);
        }
    }
}

/// Indices along z, y and x: in sorted order a row of cells along x is one run.
type Cell = [i64; 3];

fn cell_of(position: DVec3, size: f64) -> Cell {
    [position.z, position.y, position.x].map(|c| (c / size).floor().clamp(-FARTHEST_CELL, FARTHEST_CELL) as i64)
}

/// Number of `cells` before `cell`.
fn count_before(cells: &[Cell], cell: Cell) -> usize {
    cells.partition_point(|c| *c < cell)
}

/// Lights of about the same range.
#[derive(Debug)]
struct Level {
    /// Metres.
    cell_size: f64,
    /// Cell of each light, ascending.
    cells: Vec<Cell>,
    /// In the order of `cells`.
    lights: Vec<Placed>,
}

impl Level {
    fn new(mut lights: Vec<Placed>) -> Self {
        let longest = lights.iter().map(|light| light.range).fold(0.0, f64::max);
        let farthest = lights.iter().map(|light| light.position.abs().max_element()).fold(0.0, f64::max);
        let cell_size = (longest * (1.0 + MARGIN)).max(farthest * SMALLEST_CELL);
        lights.par_sort_by_cached_key(|light| cell_of(light.position, cell_size));
        let cells = lights.iter().map(|light| cell_of(light.position, cell_size)).collect();
        Self { cell_size, cells, lights }
    }

    fn visit(&self, position: DVec3, found: &mut impl FnMut(u32)) {
        let [z, y, x] = cell_of(position, self.cell_size);
        let from = count_before(&self.cells, [z - 1, i64::MIN, i64::MIN]);
        let to = from + count_before(&self.cells[from..], [z + 2, i64::MIN, i64::MIN]);
        if from == to {
            return;
        }
        let (cells, lights) = (&self.cells[from..to], &self.lights[from..to]);
        for z in z - 1..=z + 1 {
            for y in y - 1..=y + 1 {
                let first = count_before(cells, [z, y, x - 1]);
                let row = cells[first..].iter().take_while(|cell| **cell <= [z, y, x + 1]);
                for (_, light) in row.zip(&lights[first..]).filter(|(_, light)| light.reaches(position)) {
                    found(light.id);
                }
            }
        }
    }
}
