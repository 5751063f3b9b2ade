//! Pairs of light and sample, counted in f64: what light lists must hold, and what they hold in vain.
//!
//! A sample is the place at a pixel's centre and at its stored depth, in view space. A light reaches it where the distance is less than
//! the range and, for a spot light, the angle is less than the outer one; occlusion does not count, and normals only where they are
//! given: then a light behind a sample's surface does not reach it. Directional lights reach everything and stand in no list.

use glam::DVec3;
use rayon::prelude::*;

use self::grid::{Cone, Grid, Placed};
use crate::scene::LightKind;
use crate::scene::lighting::ResolvedLight;
use crate::scene::view::{Lens, View};

mod grid;
#[cfg(test)]
mod tests;

/// In [`Lists::cell_of_sample`]: the pixel has no cell.
pub const NO_CELL: u32 = u32::MAX;

/// Lists to judge. What they lack (a pixel's cell, a cell's offsets, ids at an offset) counts as an empty list.
#[derive(Debug, Clone, Copy)]
pub struct Lists<'a> {
    /// Cell of each pixel, row-major; [`NO_CELL`] where the pixel has no cell (sky).
    pub cell_of_sample: &'a [u32],
    /// cells + 1 offsets into `lights`.
    pub offsets: &'a [u32],
    /// Light ids, ascending within each cell.
    pub lights: &'a [u32],
}

impl<'a> Lists<'a> {
    pub(super) fn of(&self, cell: u32) -> &'a [u32] {
        let offset = |index: usize| self.offsets.get(index).map(|offset| *offset as usize);
        match (offset(cell as usize), offset((cell as usize).saturating_add(1))) {
            (Some(from), Some(to)) => self.lights.get(from..to).unwrap_or(&[]),
            _ => &[],
        }
    }
}

/// What [`Oracle::count`] finds. Counts for a sample are one a pixel, row-major, 0 in the sky.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Pixels that show a surface.
    pub samples: u64,
    /// Pairs in which the light reaches the sample.
    pub exact_pairs: u64,
    /// Sum over samples of the length of their cell's list.
    pub listed_pairs: u64,
    /// Exact pairs whose light is not in the list of the sample's cell.
    pub missed_pairs: u64,
    /// Sum of the lengths of the lists of cells that own a sample.
    pub listed_cells: u64,
    /// Pairs of light and cell in which the light reaches at least one sample of the cell.
    pub reached_cells: u64,
    /// Length of the longest list, of cells without a sample too.
    pub longest_list: u32,
    /// Neighbours in a list whose ids do not ascend.
    pub unordered: u64,
    /// Ids in lists that are no point or spot light's.
    pub foreign: u64,
    /// Lights that reach the sample.
    pub lights_of_sample: Vec<u32>,
    /// Those of them that are not in its cell's list.
    pub missed_of_sample: Vec<u32>,
    /// Length of its cell's list.
    pub listed_of_sample: Vec<u32>,
}

impl PairCounts {
    /// Listed over exact pairs of light and sample: 1 where there is neither, infinite where there are only listed ones.
    pub fn waste_samples(&self) -> f64 {
        waste(self.listed_pairs, self.exact_pairs)
    }

    /// Listed over reached pairs of light and cell: 1 where there is neither, infinite where there are only listed ones.
    pub fn waste_cells(&self) -> f64 {
        waste(self.listed_cells, self.reached_cells)
    }
}

fn waste(listed: u64, needed: u64) -> f64 {
    match (listed, needed) {
        (0, 0) => 1.0,
        (_, 0) => f64::INFINITY,
        _ => listed as f64 / needed as f64,
    }
}

/// Knows for every position which lights reach it.
#[derive(Debug)]
pub struct Oracle {
    view: View,
    grid: Grid,
    /// One a light: false for a directional one.
    listable: Vec<bool>,
    /// One a light, view space.
    places: Vec<DVec3>,
    /// One a pixel, view space; empty where surfaces face everything.
    normals: Vec<DVec3>,
}

/// A pixel that shows a surface.
#[derive(Debug, Clone, Copy)]
struct Sample {
    cell: u32,
    pixel: u32,
    exact: u32,
    missed: u32,
    listed: u32,
}

/// For each light the last cell of which something held, plus 1; 0 at first. A cell needs no clearing after another.
struct Marks {
    listed: Vec<u32>,
    reached: Vec<u32>,
}

impl Oracle {
    /// Takes `lights` in the order of the ids in lists. Directional lights have ids too, which no list may hold.
    pub fn new(lights: &[ResolvedLight], view: &View) -> Self {
        let place = |(id, light): (usize, &ResolvedLight)| Placed {
            id: id as u32,
            position: view.world_to_view.transform_point3(light.position),
            range: light.range,
            cone: match light.kind {
                LightKind::Spot { outer, .. } => Some(Cone {
                    axis: view.world_to_view.transform_vector3(light.direction),
                    cos_outer: f64::from(outer).cos(),
                }),
                _ => None,
            },
        };
        let listable: Vec<bool> = lights.iter().map(|light| light.kind != LightKind::Directional).collect();
        let reaching = lights.iter().enumerate().filter(|(id, light)| listable[*id] && light.range > 0.0);
        let places = lights.iter().map(|light| view.world_to_view.transform_point3(light.position)).collect();
        let grid = Grid::new(reaching.map(place).collect());
        Self { view: view.clone(), grid, listable, places, normals: Vec::new() }
    }

    /// The same of surfaces that face one way: `normals` in view space, one a pixel, row-major.
    pub fn facing(self, normals: Vec<DVec3>) -> Self {
        Self { normals, ..self }
    }

    /// Counts over a depth buffer of the view's size, row-major.
    pub fn count(&self, depth: &[f32], lists: &Lists) -> PairCounts {
        let mut samples: Vec<Sample> = (0..depth.len())
            .filter(|pixel| is_surface(depth[*pixel]))
            .map(|pixel| Sample {
                cell: lists.cell_of_sample.get(pixel).copied().unwrap_or(NO_CELL),
                pixel: pixel as u32,
                exact: 0,
                missed: 0,
                listed: 0,
            })
            .collect();
        samples.par_sort_unstable_by_key(|sample| (sample.cell, sample.pixel));
        let marks = || Marks { listed: vec![0; self.listable.len()], reached: vec![0; self.listable.len()] };
        let (listed_cells, reached_cells) = samples
            .par_chunk_by_mut(|a, b| a.cell == b.cell && a.cell != NO_CELL)
            .map_init(marks, |marks, cell| self.count_cell(depth, lists, marks, cell))
            .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        let mut counts = PairCounts {
            samples: samples.len() as u64,
            listed_cells,
            reached_cells,
            lights_of_sample: vec![0; depth.len()],
            missed_of_sample: vec![0; depth.len()],
            listed_of_sample: vec![0; depth.len()],
            ..self.check_form(lists)
        };
        for sample in &samples {
            let pixel = sample.pixel as usize;
            counts.exact_pairs += u64::from(sample.exact);
            counts.missed_pairs += u64::from(sample.missed);
            counts.listed_pairs += u64::from(sample.listed);
            counts.lights_of_sample[pixel] = sample.exact;
            counts.missed_of_sample[pixel] = sample.missed;
            counts.listed_of_sample[pixel] = sample.listed;
        }
        counts
    }

    /// Fills in the samples of one cell, or one sample that has no cell; the lights listed for the cell, and those that
    /// reach a sample of it.
    fn count_cell(&self, depth: &[f32], lists: &Lists, marks: &mut Marks, samples: &mut [Sample]) -> (u64, u64) {
        let Some(cell) = samples.first().map(|sample| sample.cell) else {
            return (0, 0);
        };
        let in_cell = cell != NO_CELL;
        let list = if in_cell { lists.of(cell) } else { &[] };
        let mark = cell.wrapping_add(1);
        for id in list {
            if let Some(listed) = marks.listed.get_mut(*id as usize) {
                *listed = mark;
            }
        }
        let mut reached = 0;
        for sample in samples {
            sample.listed = list.len() as u32;
            let (x, y) = (sample.pixel % self.view.width, sample.pixel / self.view.width);
            let Some(position) = Self::position(&self.view, x, y, depth[sample.pixel as usize]) else {
                continue;
            };
            let normal = self.normals.get(sample.pixel as usize);
            self.grid.visit(position, |id| {
                let id = id as usize;
                if normal.is_some_and(|normal| normal.dot(self.places[id] - position) <= 0.0) {
                    return;
                }
                sample.exact += 1;
                sample.missed += u32::from(!in_cell || marks.listed[id] != mark);
                if in_cell && marks.reached[id] != mark {
                    marks.reached[id] = mark;
                    reached += 1;
                }
            });
        }
        (list.len() as u64, reached)
    }

    /// What can be said of lists without samples.
    fn check_form(&self, lists: &Lists) -> PairCounts {
        let cells = lists.offsets.len().saturating_sub(1) as u32;
        let (longest_list, unordered, foreign) = (0..cells)
            .into_par_iter()
            .map(|cell| {
                let list = lists.of(cell);
                let unordered = list.windows(2).filter(|pair| pair[0] >= pair[1]).count();
                let listable = |id: u32| self.listable.get(id as usize).copied().unwrap_or(false);
                let foreign = list.iter().filter(|id| !listable(**id)).count();
                (list.len() as u32, unordered as u64, foreign as u64)
            })
            .reduce(|| (0, 0, 0), |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
        PairCounts { longest_list, unordered, foreign, ..PairCounts::default() }
    }

    /// Ids of the lights that reach one position in view space, ascending.
    pub fn reaching(&self, position: DVec3) -> Vec<u32> {
        let mut ids = Vec::new();
        self.grid.visit(position, |id| ids.push(id));
        ids.sort_unstable();
        ids
    }

    /// The place in view space, metres, that was stored as `depth` at the centre of pixel (`x`, `y`): the inverse of
    /// [`View::view_to_clip`]. `None` in the sky: 0 is what depth is cleared to, with a far plane too.
    pub fn position(view: &View, x: u32, y: u32, depth: f32) -> Option<DVec3> {
        if !is_surface(depth) {
            return None;
        }
        let depth = f64::from(depth);
        let near = view.znear;
        let p = view.image_point(f64::from(x), f64::from(y));
        Some(match view.lens {
            Lens::Perspective(_) => {
                let distance = match view.zfar.filter(|far| far.is_finite()) {
                    Some(far) => near * far / (near + depth * (far - near)),
                    None => near / depth,
                };
                DVec3::new(p.x, p.y, -1.0) * distance
            }
            Lens::Orthographic(_) => {
                let far = view.zfar.unwrap_or(near + 1.0);
                DVec3::new(p.x, p.y, depth * (far - near) - far)
            }
        })
    }
}

/// Sky, and what no depth buffer should hold, is not.
fn is_surface(depth: f32) -> bool {
    depth > 0.0 && depth.is_finite()
}
