//! Shapes that the literature reports, as counts and ratios: scattered lights of one range at 1280x720, tiles of 16 pixels, planes and
//! box, explicit clusters.
//!
//! In the atrium as a person sees it, lights of 1 m: min/max bounds (J. Andersson, "Parallel Graphics in Frostbite", SIGGRAPH 2009) at
//! least halve the pairs of tile and light; the mask of 2.5D culling (T. Harada, SIGGRAPH Asia 2012) cuts the longest list by 1.6 x or
//! more; clusters (O. Olsson, M. Billeter, U. Assarsson, HPG 2012) need at most 0.6 of the light evaluations of tiles with min/max, and
//! 2.5D lies between. With 1,024 lights the length of the longest list varies from seed to seed, and 2.5D cuts it by 1.0 to 1.9 (1.0 where
//! the samples of its tile fill their depths): there the sum over six seeds is asked for. On the terrain from above,
//! lights of 7 m, a tile's samples lie close together and clusters save little: there tiles, which are cheaper to make, win. An evaluation is
//! an entry of the list that a sample reads.

use super::Row;
use super::lists::make;
use crate::error::Result;
use crate::plan::{CameraChoice, ClusterBounds, DepthBounds, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Scene, builtin, scatter};

/// Lights that are scattered.
const COUNTS: [usize; 2] = [1024, 4096];

/// Cameras of the atrium at the height of a person's eye.
const PEOPLE: [&str; 2] = ["court", "gallery"];

/// From as many lights on the longest list hardly varies with the seed.
const MANY: usize = 4096;

/// Seeds of fewer, and what 2.5D cuts off their longest lists together, at least: measured 1.49.
const SEEDS: u64 = 6;
const CUT_OF_FEW: f64 = 1.35;

/// Part of the evaluations of tiles with min/max that clusters need from above, at least.
const FROM_ABOVE: f64 = 0.8;

/// What lists hold.
struct Counted {
    /// Pairs of cell and light.
    pairs: f64,
    longest: f64,
    /// Light evaluations.
    evaluations: f64,
}

fn counted(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Counted> {
    let (_, made) = make(renderer, scene, request)?;
    let cells = &made.cells;
    let lengths: Vec<u32> = cells.offsets.windows(2).map(|ends| ends[1].saturating_sub(ends[0])).collect();
    let drawn = cells.cell_of_sample.iter().zip(&made.depth).filter(|(_, depth)| **depth > 0.0);
    let read: u64 = drawn.filter_map(|(cell, _)| lengths.get(*cell as usize)).map(|&length| u64::from(length)).sum();
    Ok(Counted {
        pairs: cells.light_pairs() as f64,
        longest: f64::from(cells.longest_list()),
        evaluations: read as f64,
    })
}

fn scene(name: &str, lights: usize) -> Result<Scene> {
    seeded(name, lights, 3)
}

fn seeded(name: &str, lights: usize, seed: u64) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights, seed);
    Ok(scene)
}

fn request(camera: &str, range: f64) -> Request {
    let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
    let camera = CameraChoice::Named(camera.into());
    Request { width: 1280, height: 720, technique: Technique::TiledForward, rules, camera, ..crate::checks::forward() }
}

fn tiled(base: &Request, bounds: DepthBounds) -> Request {
    Request { depth_bounds: Some(bounds), ..base.clone() }
}

fn clustered(base: &Request) -> Request {
    let technique = Technique::ClusteredForward;
    Request { technique, cluster_bounds: Some(ClusterBounds::Explicit), ..base.clone() }
}

/// Rows of one view of the atrium.
fn seen_by_a_person(renderer: &Renderer, scene: &Scene, camera: &str) -> Result<Vec<Row>> {
    let base = request(camera, 1.0);
    let [off, min_max, mask] = [DepthBounds::Off, DepthBounds::MinMax, DepthBounds::Mask].map(|b| tiled(&base, b));
    let of = |request: &Request| counted(renderer, scene, request);
    let (off, min_max, mask, clusters) = (of(&off)?, of(&min_max)?, of(&mask)?, of(&clustered(&base))?);
    let place = format!("atrium, {camera}, {} lights", scene.lights.len());
    let halved = off.pairs / min_max.pairs;
    let cut = min_max.longest / mask.longest;
    let [of_mask, of_clusters] = [mask.evaluations, clusters.evaluations].map(|n| n / min_max.evaluations);
    let mut rows = vec![
        Row {
            name: format!("min and max against off, {place}"),
            passed: halved >= 2.0,
            detail: format!("{halved:.3} times fewer pairs than {}, at least 2", off.pairs),
        },
        Row {
            name: format!("clusters against min and max, {place}"),
            passed: of_clusters <= 0.6,
            detail: format!("{of_clusters:.3} of {} light evaluations, at most 0.6", min_max.evaluations),
        },
        Row {
            name: format!("2.5D between clusters and min and max, {place}"),
            passed: (of_clusters..=1.0).contains(&of_mask),
            detail: format!("{of_mask:.3} of the light evaluations, from {of_clusters:.3} to 1"),
        },
    ];
    if scene.lights.len() >= MANY {
        rows.push(Row {
            name: format!("2.5D against min and max, {place}"),
            passed: cut >= 1.6,
            detail: format!("{cut:.3} times shorter than the longest list of {}, at least 1.6", min_max.longest),
        });
    }
    Ok(rows)
}

/// The longest lists of few lights, together over seeds.
fn longest_of_few(renderer: &Renderer, camera: &str) -> Result<Row> {
    let base = request(camera, 1.0);
    let mut sums = [0.0; 2];
    for seed in 1..=SEEDS {
        let scene = seeded("atrium", COUNTS[0], seed)?;
        for (sum, bounds) in sums.iter_mut().zip([DepthBounds::MinMax, DepthBounds::Mask]) {
            *sum += counted(renderer, &scene, &tiled(&base, bounds))?.longest;
        }
    }
    let [min_max, mask] = sums;
    let cut = min_max / mask;
    Ok(Row {
        name: format!("2.5D against min and max, atrium, {}, {} lights of {SEEDS} seeds", camera, COUNTS[0]),
        passed: cut >= CUT_OF_FEW,
        detail: format!("{cut:.3} times shorter than longest lists of {min_max} together, at least {CUT_OF_FEW}"),
    })
}

/// On the terrain from above.
fn seen_from_above(renderer: &Renderer, lights: usize) -> Result<Row> {
    let (scene, base) = (scene("terrain", lights)?, request("top-down", 7.0));
    let tiles = counted(renderer, &scene, &tiled(&base, DepthBounds::MinMax))?;
    let clusters = counted(renderer, &scene, &clustered(&base))?;
    let part = clusters.evaluations / tiles.evaluations;
    Ok(Row {
        name: format!("clusters save little from above, terrain, {lights} lights of 7 m"),
        passed: part >= FROM_ABOVE,
        detail: format!("{part:.3} of {} light evaluations of tiles, at least {FROM_ABOVE}", tiles.evaluations),
    })
}

/// Shapes at each number of lights.
pub fn shapes(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for camera in PEOPLE {
        rows.push(longest_of_few(renderer, camera)?);
    }
    for lights in COUNTS {
        let atrium = scene("atrium", lights)?;
        for camera in PEOPLE {
            rows.extend(seen_by_a_person(renderer, &atrium, camera)?);
        }
        rows.push(seen_from_above(renderer, lights)?);
    }
    Ok(rows)
}
