//! Light lists: techniques that use them against forward bit for bit, the device's lists against their CPU twin, and both against
//! the f64 oracle.

use super::Row;
use crate::error::{Error, Result};
use crate::lists::{self, Made};
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::{CullTest, DepthBounds, Plan, Request, Technique};
use crate::reference::depth_reduce::{self, TileBounds};
use crate::reference::tile_cull::{self, Lists};
use crate::renderer::{Prepared, Renderer};
use crate::scene::{Scene, builtin, scatter};

/// Not a multiple of any tile size: the last column and row are cut.
const SIZE: (u32, u32) = (150, 85);

/// Every built-in scene.
const SCENES: [&str; 5] = ["cornell", "corridor", "atrium", "terrain", "furnace"];

fn scene(name: &str, lights: usize) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
    Ok(scene)
}

fn request(technique: Technique) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, ..crate::checks::forward() }
}

pub(in crate::checks) fn radiance(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Vec<u32>> {
    radiance_of(renderer, scene, &Plan::new(scene, request, &renderer.limits())?)
}

/// The bits of a planned picture.
pub(in crate::checks) fn radiance_of(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<u32>> {
    bits_of_frame(renderer.prepare(scene, plan)?)
}

/// The bits of a picture that is ready to be drawn.
pub(in crate::checks) fn bits_of_frame(mut prepared: Prepared) -> Result<Vec<u32>> {
    prepared.draw(1)?;
    let (picture, violations) = prepared.finish()?;
    if let Some(violation) = violations.first() {
        return Err(Error::new(format!("the checker found {violation}")));
    }
    Ok(words(&picture, "radiance"))
}

fn words(picture: &Picture, layer: &str) -> Vec<u32> {
    picture.layer(layer).unwrap_or(&[]).iter().map(|x| x.to_bits()).collect()
}

/// Pixels that differ; all there may be where the pictures cannot be compared.
pub(in crate::checks) fn differing(a: &[u32], b: &[u32]) -> usize {
    if a.len() != b.len() || a.is_empty() {
        return usize::MAX;
    }
    a.chunks(4).zip(b.chunks(4)).filter(|(p, q)| p != q).count()
}

/// Requests that differ in how lists are made: each test with each knowledge of depth, then tile sizes.
fn variants() -> Vec<(String, Request)> {
    let base = request(Technique::TiledForward);
    let mut variants = Vec::new();
    for cull in [CullTest::Bounds, CullTest::Frustum, CullTest::FrustumAabb] {
        for bounds in DepthBounds::ALL {
            let request = Request { cull, depth_bounds: Some(bounds), ..base.clone() };
            variants.push((format!("{} {}", cull.name(), bounds.name()), request));
        }
    }
    for tile in [8, 32, 64] {
        variants.push((format!("tile {tile}"), Request { tile, ..base.clone() }));
    }
    for tile in [8, 16, 64] {
        let request = Request { tile, group_a_tile: Some(true), ..base.clone() };
        variants.push((format!("tile {tile}, depths reduced by groups"), request));
    }
    variants.push(("no pre-pass".into(), Request { prepass: false, ..base }));
    variants
}

/// Tiled forward draws what forward draws: every scene, and every way of making lists on one.
pub fn tiled(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in SCENES {
        let scene = scene(name, 96)?;
        let forward = radiance(renderer, &scene, &request(Technique::Forward))?;
        let tiled = radiance(renderer, &scene, &request(Technique::TiledForward))?;
        rows.push(Row::none(
            format!("tiled-forward = forward, {name}"),
            differing(&forward, &tiled),
            "differing pixels",
        ));
    }
    let scene = scene("atrium", 96)?;
    let forward = radiance(renderer, &scene, &request(Technique::Forward))?;
    for (name, request) in variants() {
        let tiled = radiance(renderer, &scene, &request)?;
        rows.push(Row::none(
            format!("tiled-forward = forward, {name}"),
            differing(&forward, &tiled),
            "differing pixels",
        ));
    }
    Ok(rows)
}

/// What the twin makes of the depth that was read back: bounds, and lists of tiles and of bins from the device's bounds.
fn twin(plan: &Plan, made: &Made) -> (Vec<[u32; 4]>, [Lists; 2]) {
    let Some(tiles) = &plan.tiles else { return (Vec::new(), Default::default()) };
    let slots = (tiles.bounds == DepthBounds::Mask).then_some(tiles.slots);
    let bounds = match tiles.bounds {
        DepthBounds::Off => Vec::new(),
        _ => depth_reduce::run(&tiles.grid, tiles.tile, slots, &made.depth),
    };
    let device_bounds: Vec<_> = made.bounds.iter().map(|&w| TileBounds::from_words(w)).collect();
    let inputs = tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        cull: passes::tile_cull::cull_constant(tiles.cull),
        depth_bounds: passes::depth_reduce::bounds_constant(tiles.bounds),
        slots: tiles.slots,
        bounds: &device_bounds,
    };
    (bounds.iter().map(TileBounds::words).collect(), [tile_cull::run(&inputs), tile_cull::bins(&inputs)])
}

/// Plans a request and makes its lists.
pub(in crate::checks) fn make(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<(Plan, Made)> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let made = lists::make(renderer, scene, &plan)?;
    Ok((plan, made))
}

/// How the device's lists of one request compare.
pub(in crate::checks) struct Verdict {
    /// Buffers that are not the twin's, and barriers that are not proved.
    pub(in crate::checks) wrong: usize,
    /// Pairs that the oracle misses, or that are out of order or of no light.
    pub(in crate::checks) missed: usize,
    /// Pairs of cell and light.
    pub(in crate::checks) pairs: usize,
}

/// Buffers of lists of tiles that are not the twin's.
pub(in crate::checks) fn unlike_twin(plan: &Plan, made: &Made) -> usize {
    let (bounds, [lists, bins]) = twin(plan, made);
    let differ = [
        bounds != made.bounds,
        lists.offsets != made.cells.offsets,
        lists.lights != made.cells.lights,
        bins.offsets != made.bins[0],
        bins.lights != made.bins[1],
    ];
    differ.into_iter().filter(|differ| *differ).count()
}

pub(in crate::checks) fn verdict(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Verdict> {
    let (plan, made) = make(renderer, scene, request)?;
    let counts = made.judge(&plan);
    Ok(Verdict {
        wrong: unlike_twin(&plan, &made) + made.violations.len(),
        missed: (counts.missed_pairs + counts.unordered + counts.foreign + made.cells.overflowed()) as usize,
        pairs: made.cells.lights.len(),
    })
}

/// Lists and bounds equal their twin to the bit, and the oracle misses no light.
pub fn tile_lists(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let scenes = ["atrium", "terrain"].map(|name| (name, scene(name, 1200)));
    for (name, scene) in scenes {
        let scene = scene?;
        for (variant, request) in variants().into_iter().filter(|v| v.1.prepass) {
            let found = verdict(renderer, &scene, &request)?;
            rows.push(Row::none(format!("lists = twin, {name}, {variant}"), found.wrong, "buffers that differ"));
            rows.push(Row::none(format!("lists miss nothing, {name}, {variant}"), found.missed, "pairs"));
        }
    }
    Ok(rows)
}
