//! Light lists as a device makes them, read back: judged by the f64 oracle, counted, and spread over the picture's pixels.
//!
//! Whatever makes lists, what is left are [`Cells`]: which cell each pixel reads, where each cell's list begins, and ids. A technique
//! without lists is one cell that lists every light.

use std::ops::Range;

use glam::DVec3;
use serde::Serialize;

use crate::error::Result;
use crate::graph::checker::Violation;
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::projection::{self, PixelRect};
use crate::plan::{CullTest, DebugView, Plan, Tiles};
use crate::reference::depth_reduce::TileBounds;
use crate::reference::light_pairs::{Lists, Oracle, PairCounts};
use crate::renderer::Renderer;
use crate::scene::lighting::ResolvedLight;
use crate::scene::view::View;
use crate::scene::{LightKind, Scene};

/// Lists of cells, and which cell each pixel reads.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells {
    /// Cell of each pixel, row-major.
    pub cell_of_sample: Vec<u32>,
    /// cells + 1 offsets into `lights`.
    pub offsets: Vec<u32>,
    /// Light ids, ascending within each cell.
    pub lights: Vec<u32>,
    /// Ids that there was room for.
    pub capacity: usize,
}

impl Cells {
    /// One cell that every pixel reads: what a technique without lists loops over.
    pub fn whole_picture(pixels: usize, lights: Range<u32>) -> Self {
        let lights: Vec<u32> = lights.collect();
        let offsets = vec![0, lights.len() as u32];
        Self { cell_of_sample: vec![0; pixels], offsets, capacity: lights.len(), lights }
    }

    fn of_tiles(tiles: &Tiles, picture: &Picture) -> Self {
        // A tile has an offset for each run of its bin; its list begins at the first.
        let runs = tiles.grid.list_chunks.max(1) as usize;
        let offsets: Vec<u32> = words(picture, "list_offsets").into_iter().step_by(runs).collect();
        let mut lights = words(picture, "list_lights");
        let capacity = lights.len();
        lights.truncate(offsets.last().map_or(0, |&end| end as usize));
        let pixels = tiles.grid.width * tiles.grid.height;
        Self { cell_of_sample: (0..pixels).map(|pixel| tile_of(tiles, pixel)).collect(), offsets, lights, capacity }
    }

    /// Entries of each cell's list.
    fn lengths(&self) -> impl Iterator<Item = u32> {
        self.offsets.windows(2).map(|ends| ends[1].saturating_sub(ends[0]))
    }

    /// Pairs of cell and light.
    pub fn light_pairs(&self) -> u64 {
        self.lengths().map(u64::from).sum()
    }

    /// Entries of the longest list.
    pub fn longest_list(&self) -> u32 {
        self.lengths().max().unwrap_or(0)
    }

    /// Lists that end beyond what was allocated for them.
    pub fn overflowed(&self) -> u64 {
        self.offsets.iter().skip(1).filter(|&&end| end as usize > self.capacity).count() as u64
    }

    /// Judges the lists by the f64 oracle. `lights` in the order of ids; `depth` as stored, one value a pixel of the view.
    pub fn judge(&self, lights: &[ResolvedLight], view: &View, depth: &[f32]) -> PairCounts {
        let lists = Lists { cell_of_sample: &self.cell_of_sample, offsets: &self.offsets, lights: &self.lights };
        Oracle::new(lights, view).count(depth, &lists)
    }

    /// Entries of the list that each pixel reads; NaN where it reads none.
    fn list_lengths(&self) -> Vec<f32> {
        let lengths: Vec<u32> = self.lengths().collect();
        let of = |&cell: &u32| lengths.get(cell as usize).map_or(f32::NAN, |&length| length as f32);
        self.cell_of_sample.iter().map(of).collect()
    }
}

/// What list making left, and the depths that it was made from.
#[derive(Debug, Clone, Default)]
pub struct Made {
    /// As stored, one value a pixel.
    pub depth: Vec<f32>,
    /// Texels of tile bounds as stored; empty where nothing is known of depths.
    pub bounds: Vec<[u32; 4]>,
    /// The lists.
    pub cells: Cells,
    /// What the checker found in the recorded frames: empty is the proof.
    pub violations: Vec<Violation>,
}

/// Makes the lists of a plan on the device and reads them back.
///
/// # Errors
/// Out of memory, a lost device, or a pipeline that the driver refuses.
pub fn make(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Made> {
    let mut prepared = renderer.prepare_frame(scene, plan, passes::list_frame(plan))?;
    // The second frame meets what the first one left.
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    let cells = match &plan.tiles {
        Some(tiles) => Cells::of_tiles(tiles, &picture),
        None => Cells::whole_picture(plan.pixels() as usize, directional(plan)..plan.lights.count),
    };
    let bounds = words(&picture, "tile_bounds").chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect();
    let depth = picture.layer("depth").unwrap_or(&[]).to_vec();
    Ok(Made { depth, bounds, cells, violations })
}

impl Made {
    /// Judges the lists by the f64 oracle.
    pub fn judge(&self, plan: &Plan) -> PairCounts {
        let lights: Vec<_> = plan.lighting.in_table_order().cloned().collect();
        self.cells.judge(&lights, &plan.view, &self.depth)
    }

    /// The numbers that a debug view shows, one a pixel and NaN where there is none, and what they are called. `None` for a view of
    /// something else, and for one of tiles where the plan has none.
    pub fn numbers(&self, view: DebugView, plan: &Plan, counts: &PairCounts) -> Option<(&'static str, Vec<f32>)> {
        let at = |numbers: &[u32], pixel: usize| numbers.get(pixel).map_or(f32::NAN, |&n| n as f32);
        Some(match view {
            DebugView::TileMin => ("tile_min", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.near)),
            DebugView::TileMax => ("tile_max", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.far)),
            DebugView::TileMask => {
                ("tile_slots", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.mask.count_ones() as f32))
            }
            DebugView::TileLights => ("list_length", self.cells.list_lengths()),
            DebugView::Lights => ("lights", self.of_samples(|pixel| at(&counts.lights_of_sample, pixel))),
            DebugView::Missed => ("missed", self.of_samples(|pixel| at(&counts.missed_of_sample, pixel))),
            DebugView::Waste => {
                let of = |pixel| waste(at(&counts.listed_of_sample, pixel), at(&counts.lights_of_sample, pixel));
                ("waste", self.of_samples(of))
            }
            _ => return None,
        })
    }

    /// A number of each pixel's tile; none in tiles of nothing but sky.
    fn of_tiles(&self, tiles: &Tiles, number: impl Fn(TileBounds) -> f32) -> Vec<f32> {
        let numbers: Vec<f32> = self
            .bounds
            .iter()
            .map(|&words| TileBounds::from_words(words))
            .map(|bounds| if bounds.near <= bounds.far { number(bounds) } else { f32::NAN })
            .collect();
        let of = |pixel| numbers.get(tile_of(tiles, pixel) as usize).copied().unwrap_or(f32::NAN);
        (0..tiles.grid.width * tiles.grid.height).map(of).collect()
    }

    /// A number of each pixel that shows a surface.
    fn of_samples(&self, number: impl Fn(usize) -> f32) -> Vec<f32> {
        let of = |(pixel, depth): (usize, &f32)| if *depth > 0.0 { number(pixel) } else { f32::NAN };
        self.depth.iter().enumerate().map(of).collect()
    }
}

/// Listed over reaching lights: 1 where there is neither, infinite where there are only listed ones.
fn waste(listed: f32, reaching: f32) -> f32 {
    if listed == 0.0 && reaching == 0.0 { 1.0 } else { listed / reaching }
}

/// What lists cost and hold, in numbers. Pairs of light and sample are over the pixels that show a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Counters {
    /// Entries of all lists.
    pub light_pairs: u64,
    /// Pairs in which the light reaches the sample, in f64.
    pub exact_pairs: u64,
    /// Exact pairs whose light is not in the list of the sample's cell.
    pub missed_pairs: u64,
    /// Listed over reached pairs of light and cell, over the cells that own a sample; infinite where nothing is reached.
    pub waste_cells: f64,
    /// Listed over exact pairs of light and sample; infinite where nothing is reached.
    pub waste_samples: f64,
    /// Directional lights and the list's length, summed over samples.
    pub light_evaluations: u64,
    /// Lists that end beyond what was allocated for them.
    pub lists_overflowed: u64,
    /// Entries of the longest list.
    pub longest_list: u32,
}

impl Counters {
    /// Counters of lists that were judged; every sample adds `directional` lights beside its list.
    pub fn new(cells: &Cells, counts: &PairCounts, directional: u32) -> Self {
        Self {
            light_pairs: cells.light_pairs(),
            exact_pairs: counts.exact_pairs,
            missed_pairs: counts.missed_pairs,
            waste_cells: counts.waste_cells(),
            waste_samples: counts.waste_samples(),
            light_evaluations: counts.samples * u64::from(directional) + counts.listed_pairs,
            lists_overflowed: cells.overflowed(),
            longest_list: cells.longest_list(),
        }
    }
}

/// Lights that stand in no list because they reach everything; their ids come first.
pub fn directional(plan: &Plan) -> u32 {
    plan.lighting.lights.iter().filter(|light| light.kind == LightKind::Directional).count() as u32
}

/// Each light's bounding rectangle in the picture, by the test that the plan's tiles use, else by tangents, and the light's
/// intensity. Lights outside the picture have none.
pub fn rectangles(plan: &Plan) -> Vec<(PixelRect, DVec3)> {
    let textbook = plan.tiles.as_ref().is_some_and(|tiles| tiles.cull == CullTest::BoundsTextbook);
    let rectangle = |light: &ResolvedLight| {
        let center = plan.view.world_to_view.transform_point3(light.position);
        projection::distance_range(center, light.range, &plan.view)?;
        let rect = if textbook {
            projection::textbook_rectangle(center.as_vec3(), light.range as f32, &plan.view)
        } else {
            projection::tangent_rectangle(center, light.range, &plan.view)
        };
        rect.map(|rect| (rect, light.intensity))
    };
    let placed = plan.lighting.lights.iter().filter(|light| light.kind != LightKind::Directional);
    placed.filter_map(rectangle).collect()
}

fn tile_of(tiles: &Tiles, pixel: u32) -> u32 {
    let (x, y) = (pixel % tiles.grid.width, pixel / tiles.grid.width);
    y / tiles.tile * tiles.grid.columns + x / tiles.tile
}

/// Words that came back as the bits of floats.
fn words(picture: &Picture, layer: &str) -> Vec<u32> {
    picture.layer(layer).unwrap_or(&[]).iter().map(|x| x.to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::scene::{Camera, Projection};

    /// Four pixels whose samples of depth 0.5 lie at x = -3, -1, 1, 3 and z = -5; the last one is sky.
    const DEPTH: [f32; 4] = [0.5, 0.5, 0.5, 0.0];

    fn view() -> View {
        let projection = Projection::Orthographic { xmag: 4.0, ymag: 1.0, znear: 0.0, zfar: 10.0 };
        let camera = Camera { name: "row".into(), camera_to_world: DMat4::IDENTITY, projection };
        View::new(&camera, 4, 1).expect("a good camera")
    }

    /// A directional light, then three of which one, one and two reach the three samples.
    fn lights() -> Vec<ResolvedLight> {
        let light = |kind, x, range| ResolvedLight {
            kind,
            position: DVec3::new(x, 0.0, -5.0),
            direction: DVec3::NEG_Z,
            intensity: DVec3::ONE,
            range,
        };
        vec![
            light(LightKind::Directional, 0.0, f64::INFINITY),
            light(LightKind::Point, -3.0, 0.5),
            light(LightKind::Point, 0.0, 1.5),
            light(LightKind::Point, 2.0, 1.5),
        ]
    }

    /// Two cells of two pixels each, and one without any.
    fn cells() -> Cells {
        Cells {
            cell_of_sample: vec![0, 0, 1, 1],
            offsets: vec![0, 3, 5, 6],
            lights: vec![1, 2, 3, 2, 3, 1],
            capacity: 6,
        }
    }

    fn counters(cells: &Cells) -> Counters {
        Counters::new(cells, &cells.judge(&lights(), &view(), &DEPTH), 1)
    }

    #[test]
    fn counters_are_those_counted_by_hand() {
        let expected = Counters {
            light_pairs: 6,
            exact_pairs: 4,
            missed_pairs: 0,
            waste_cells: 1.25,
            waste_samples: 2.0,
            light_evaluations: 3 + 8,
            lists_overflowed: 0,
            longest_list: 3,
        };
        assert_eq!(counters(&cells()), expected);
    }

    #[test]
    fn a_light_that_is_left_out_is_missed_and_one_too_many_is_waste() {
        let fewer = Cells { offsets: vec![0, 3, 4, 5], lights: vec![1, 2, 3, 3, 1], capacity: 5, ..cells() };
        let found = counters(&fewer);
        assert_eq!((found.missed_pairs, found.light_pairs, found.light_evaluations), (1, 5, 3 + 7));
        let more = Cells { offsets: vec![0, 3, 6, 6], lights: vec![1, 2, 3, 1, 2, 3], ..cells() };
        assert_eq!((counters(&more).missed_pairs, counters(&more).waste_samples), (0, 9.0 / 4.0));
    }

    #[test]
    fn lists_beyond_their_memory_are_counted() {
        assert_eq!(counters(&Cells { capacity: 5, ..cells() }).lists_overflowed, 1);
        assert_eq!(counters(&Cells { capacity: 4, ..cells() }).lists_overflowed, 2);
    }

    #[test]
    fn without_lists_one_cell_lists_every_light() {
        let found = counters(&Cells::whole_picture(4, 1..4));
        assert_eq!((found.light_pairs, found.longest_list, found.missed_pairs), (3, 3, 0));
        assert_eq!((found.light_evaluations, found.lists_overflowed), (3 * 4, 0));
        assert_eq!((found.waste_samples, found.waste_cells), (9.0 / 4.0, 1.0));
    }

    #[test]
    fn waste_of_a_pixel_is_one_only_where_nothing_is_listed_in_vain() {
        assert_eq!([waste(0.0, 0.0), waste(3.0, 3.0), waste(3.0, 2.0)], [1.0, 1.0, 1.5]);
        assert_eq!(waste(1.0, 0.0), f32::INFINITY);
    }

    #[test]
    fn list_lengths_are_those_of_the_pixels_cells() {
        assert_eq!(cells().list_lengths(), [3.0, 3.0, 2.0, 2.0]);
        let outside = Cells { cell_of_sample: vec![u32::MAX], ..cells() };
        assert!(outside.list_lengths()[0].is_nan());
    }
}
