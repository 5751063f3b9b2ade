//! P1 to P7 without a device: a million lights, adversarial and random by turns, through the twins of tile culling and of assignment to
//! clusters, over depths that are made up. The f64 oracle finds what they miss.

use std::time::Instant;

use glam::DVec3;

use super::culling::{MAKERS, cameras, log_range};
use super::fixtures::{looking, point, scene, wall};
use crate::checks::Row;
use crate::error::{Error, Result};
use crate::math::random::Random;
use crate::plan::{Clusters, Limits, Plan, Request, Technique, Tiles};
use crate::reference::cluster_index::{self, ClusterBox};
use crate::reference::depth_reduce::{self, TileBounds};
use crate::reference::light_pairs::{Lists, Oracle};
use crate::reference::tile_cull;
use crate::reference::{cluster_assign, cluster_keys};
use crate::renderer::Renderer;
use crate::scene::view::{Lens, View};
use crate::scene::{Camera, Light};
use crate::shared;

/// Of each lens.
const LIGHTS: usize = 1_000_000;

/// Lights at a time: lists of large ones for every slice of every tile take some 100 MB then.
const BATCH: usize = 50_000;

/// Pixels: each is compared with every light that reaches it.
const SIZE: [u32; 2] = [48, 32];

/// Pixels along each side of a tile, batch by batch.
const TILES: [u32; 4] = [8, 16, 8, 32];

/// Metres along the view axis up to which there are samples. The farthest one is 37.3 m from the eye; what is rounded is bounded for all
/// within 38.3 m of it, as far as the box of the scene's wall goes.
const FARTHEST: f64 = 25.0;

/// Ways of making lists, in the order of [`judged`].
const WAYS: [&str; 8] = [
    "rectangles, no bounds",
    "planes, min and max",
    "planes and box, no bounds",
    "planes and box, min and max",
    "planes and box, mask",
    "explicit clusters",
    "implicit clusters",
    "every slice of every tile",
];

/// What a way of making lists got wrong, of how much.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    /// Missed pairs, lists out of order, ids of no light.
    wrong: u64,
    /// Pairs in which the light reaches the sample.
    exact: u64,
    /// Entries of all lists.
    listed: u64,
}

/// Anywhere that matters, mostly of a size that part of the picture sees.
fn anywhere(random: &mut Random) -> (DVec3, f64) {
    let center = DVec3::new(random.range(-15.0, 15.0), random.range(-10.0, 10.0), random.range(-28.0, 3.0));
    (center, log_range(random, 0.05, 8.0))
}

/// Every other light is adversarial, of each kind in turn.
fn lights(camera: &Camera, view: &View, count: usize, seed: u64) -> Vec<Light> {
    let mut random = Random::new(seed);
    let light = |index: usize| {
        let (center, range) = match index % 2 {
            0 => anywhere(&mut random),
            _ => MAKERS[index / 2 % MAKERS.len()](&mut random, view),
        };
        let position = camera.camera_to_world.transform_point3(center);
        Light { range: Some(range as f32), ..point(position, 1e-3) }
    };
    (0..count).map(light).collect()
}

/// What is stored for a distance along the view axis.
fn stored(view: &View, distance: f64) -> f32 {
    let near = view.znear;
    let depth = match (view.lens, view.zfar) {
        (Lens::Perspective(_), None) => near / distance,
        (Lens::Perspective(_), Some(far)) => (near * far / distance - near) / (far - near),
        (Lens::Orthographic(_), far) => {
            let far = far.unwrap_or(near + 1.0);
            (far - distance) / (far - near)
        }
    };
    depth.clamp(1e-9, 1.0) as f32
}

/// Blocks of 4x4 pixels of sky, of one distance, of two, and of any between two.
fn depths(view: &View, seed: u64) -> Vec<f32> {
    let mut random = Random::new(seed);
    let nearest = view.znear.max(0.05);
    let across = view.width.div_ceil(4);
    let mut of_block = || {
        let kind = random.next_u64() % 10;
        (kind, log_range(&mut random, nearest, FARTHEST), log_range(&mut random, nearest, FARTHEST))
    };
    let blocks: Vec<(u64, f64, f64)> = (0..across * view.height.div_ceil(4)).map(|_| of_block()).collect();
    let pixel = |index: u32| {
        let (kind, first, last) = blocks[(index / view.width / 4 * across + index % view.width / 4) as usize];
        let between = random.unit_f64();
        match kind {
            0 => 0.0,
            1 | 2 => stored(view, first),
            3..=5 => stored(view, if between < 0.5 { first } else { last }),
            _ => stored(view, first * (last / first).powf(between)),
        }
    };
    (0..view.width * view.height).map(pixel).collect()
}

/// Clusters by assignment from the lists of tiles.
struct Assignment<'a> {
    tiles: &'a Tiles,
    clusters: &'a Clusters,
    keys: Option<&'a [u32]>,
    boxes: Option<&'a [ClusterBox]>,
}

impl Assignment<'_> {
    fn run(&self, tile_lists: &tile_cull::Lists) -> tile_cull::Lists {
        cluster_assign::run(&cluster_assign::Inputs {
            grid: &self.tiles.grid,
            clusters: &self.clusters.grid,
            slices: &self.clusters.slices,
            lights: &self.tiles.lights,
            cones: &self.tiles.cones,
            edges: &self.tiles.edges,
            tile_lists,
            keys: self.keys,
            boxes: self.boxes,
            directions: None,
        })
    }
}

/// Makes the plan's lists in each way and judges them.
fn judged(plan: &Plan, depth: &[f32]) -> Result<[Tally; WAYS.len()]> {
    let parts = plan.tiles.as_ref().zip(plan.clusters.as_ref());
    let (tiles, clusters) = parts.ok_or_else(|| Error::new("this technique has no clusters"))?;
    let (grid, cut) = (&tiles.grid, &clusters.grid);
    let resolved: Vec<_> = plan.lighting.in_table_order().cloned().collect();
    let oracle = Oracle::new(&resolved, &plan.view);
    let tally = |cell_of_sample: &[u32], lists: &tile_cull::Lists| {
        let found = oracle.count(depth, &Lists { cell_of_sample, offsets: &lists.offsets, lights: &lists.lights });
        let wrong = found.missed_pairs + found.unordered + found.foreign;
        Tally { wrong, exact: found.exact_pairs, listed: lists.lights.len() as u64 }
    };
    let of_tiles = |cull: u32, depth_bounds: u32, bounds: &[TileBounds]| {
        let (lights, edges, slots) = (&tiles.lights[..], &tiles.edges[..], tiles.slots);
        let cones = &tiles.cones[..];
        tile_cull::run(&tile_cull::Inputs { grid, lights, cones, edges, cull, depth_bounds, slots, bounds })
    };
    let [min_max, mask] = [None, Some(tiles.slots)].map(|slots| depth_reduce::run(grid, tiles.tile, slots, depth));
    let tile_of = |pixel: u32| pixel / grid.width / tiles.tile * grid.columns + pixel % grid.width / tiles.tile;
    let tile_of_sample: Vec<u32> = (0..grid.width * grid.height).map(tile_of).collect();
    let slice_of = |(&tile, &depth): (&u32, &f32)| tile * cut.slices + cluster_keys::slice(grid, cut, depth);
    let slice_of_sample: Vec<u32> = tile_of_sample.iter().zip(depth).map(slice_of).collect();
    let keys = cluster_keys::run(grid, cut, depth, None);
    let boxes = cluster_index::run(grid, cut, depth, &keys.index, keys.keys.len());
    let unbounded = of_tiles(shared::CULL_PLANES_BOX, shared::BOUNDS_OFF, &[]);
    let bounded = of_tiles(shared::CULL_PLANES_BOX, shared::BOUNDS_MIN_MAX, &min_max);
    let dense = Assignment { tiles, clusters, keys: None, boxes: None };
    let implicit = Assignment { keys: Some(&keys.keys), ..dense };
    let explicit = Assignment { boxes: Some(&boxes), ..implicit };
    Ok([
        tally(&tile_of_sample, &of_tiles(shared::CULL_RECTANGLE, shared::BOUNDS_OFF, &[])),
        tally(&tile_of_sample, &of_tiles(shared::CULL_PLANES, shared::BOUNDS_MIN_MAX, &min_max)),
        tally(&tile_of_sample, &unbounded),
        tally(&tile_of_sample, &bounded),
        tally(&tile_of_sample, &of_tiles(shared::CULL_PLANES_BOX, shared::BOUNDS_MASK, &mask)),
        tally(&keys.index, &explicit.run(&bounded)),
        tally(&keys.index, &implicit.run(&bounded)),
        tally(&slice_of_sample, &dense.run(&unbounded)),
    ])
}

/// Batch `index` of a lens: its plan and its depths.
fn planned(camera: &Camera, count: usize, index: usize) -> Result<(Plan, Vec<f32>)> {
    let (tile, [width, height]) = (TILES[index % TILES.len()], SIZE);
    let request = Request { width, height, tile, technique: Technique::ClusteredForward, ..crate::checks::forward() };
    let view = View::new(camera, width, height)?;
    let scene = scene(wall(20.0), lights(camera, &view, count, 100 + index as u64), camera.clone());
    let plan = Plan::new(&scene, &request, &Limits::UNLIMITED)?;
    let depth = depths(&plan.view, index as u64);
    Ok((plan, depth))
}

/// `count` lights of each lens, `batch` at a time.
fn rows(count: usize, batch: usize) -> Result<Vec<Row>> {
    let empty = scene(wall(20.0), Vec::new(), looking([0.0, 0.0, 10.0], [0.0; 3], 60.0));
    let mut rows = Vec::new();
    for (lens, camera) in cameras(&empty) {
        let start = Instant::now();
        let batches = count.div_ceil(batch);
        let mut tallies = [Tally::default(); WAYS.len()];
        for index in 0..batches {
            let (plan, depth) = planned(&camera, batch.min(count - index * batch), index)?;
            for (sum, found) in tallies.iter_mut().zip(judged(&plan, &depth)?) {
                sum.wrong += found.wrong;
                sum.exact += found.exact;
                sum.listed += found.listed;
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        for (way, tally) in WAYS.iter().zip(tallies) {
            rows.push(Row {
                name: format!("P1-P7 twin, {count} lights, {lens}, {way}"),
                passed: tally.wrong == 0 && tally.exact > 0,
                detail: format!(
                    "{} wrong of {} pairs of light and sample, {} listed; {batches} batches of all ways in {seconds:.1} s",
                    tally.wrong, tally.exact, tally.listed
                ),
            });
        }
    }
    Ok(rows)
}

/// A million lights of each lens.
pub fn twins_deep(_: &Renderer) -> Result<Vec<Row>> {
    rows(LIGHTS, BATCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_thousand_lights_miss_nothing() {
        let rows = rows(10_000, 2_500).expect("plans");
        let failed: Vec<_> = rows.iter().filter(|row| !row.passed).collect();
        assert!(rows.len() == 3 * WAYS.len() && failed.is_empty(), "{failed:#?}");
    }

    #[test]
    fn smaller_lights_are_missed_in_every_way_that_asks_their_radius() {
        let (mut plan, depth) = planned(&looking([0.0, 0.0, 10.0], [0.0; 3], 60.0), 600, 1).expect("a plan");
        for light in plan.tiles.as_mut().expect("tiles").lights.chunks_exact_mut(shared::CULL_TEXELS as usize) {
            light[0][3] *= 0.25;
            light[1][2] *= 0.5;
        }
        let found = judged(&plan, &depth).expect("lists");
        assert_eq!(found[0].wrong, 0, "rectangles are planned");
        assert!(found[1..].iter().all(|tally| tally.wrong > 100), "{found:?}");
    }
}
