//! Light lists: techniques that use them against forward bit for bit, the device's lists against their CPU twin, and both against
//! the f64 oracle.

use super::Row;
use crate::error::{Error, Result};
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::{CullTest, DepthBounds, Plan, Request, Technique};
use crate::reference::depth_reduce::{self, TileBounds};
use crate::reference::light_pairs::{self, Oracle, PairCounts};
use crate::reference::tile_cull::{self, Lists};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
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
    Request { width: SIZE.0, height: SIZE.1, technique, ..Request::default() }
}

pub(in crate::checks) fn radiance(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Vec<u32>> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let mut prepared = renderer.prepare(scene, &plan)?;
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

fn differing(a: &[u32], b: &[u32]) -> usize {
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

/// What the device made of one request.
pub(in crate::checks) struct Made {
    pub(in crate::checks) plan: Plan,
    pub(in crate::checks) depth: Vec<f32>,
    /// As stored; empty where nothing is known of depths.
    pub(in crate::checks) bounds: Vec<[u32; 4]>,
    /// Lists as the twin has them: an offset a tile.
    pub(in crate::checks) lists: Lists,
    violations: usize,
}

pub(in crate::checks) fn make(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Made> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let frame = passes::list_frame(&plan).ok_or_else(|| Error::new("this technique makes no lists"))?;
    let mut prepared = renderer.prepare_frame(scene, &plan, frame)?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    let chunks = plan.tiles.as_ref().map_or(1, |t| t.grid.list_chunks) as usize;
    let offsets: Vec<u32> = words(&picture, "list_offsets").into_iter().step_by(chunks).collect();
    let mut lights = words(&picture, "list_lights");
    lights.truncate(offsets.last().map_or(0, |&o| o as usize));
    let bounds = words(&picture, "tile_bounds").chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect();
    let depth = picture.layer("depth").unwrap_or(&[]).to_vec();
    Ok(Made { plan, depth, bounds, lists: Lists { offsets, lights }, violations: violations.len() })
}

/// What the twin makes of the depth that was read back: bounds, and lists from the device's bounds.
pub(in crate::checks) fn twin(made: &Made) -> (Vec<[u32; 4]>, Lists) {
    let Some(tiles) = &made.plan.tiles else { return (Vec::new(), Lists::default()) };
    let slots = (tiles.bounds == DepthBounds::Mask).then_some(tiles.slots);
    let bounds = match tiles.bounds {
        DepthBounds::Off => Vec::new(),
        _ => depth_reduce::run(&tiles.grid, tiles.tile, slots, &made.depth),
    };
    let device_bounds: Vec<_> = made.bounds.iter().map(|&w| TileBounds::from_words(w)).collect();
    let inputs = tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        edges: &tiles.edges,
        cull: passes::tile_cull::cull_constant(tiles.cull),
        depth_bounds: passes::depth_reduce::bounds_constant(tiles.bounds),
        slots: tiles.slots,
        bounds: &device_bounds,
    };
    (bounds.iter().map(TileBounds::words).collect(), tile_cull::run(&inputs))
}

/// Judges lists by the f64 oracle.
pub(in crate::checks) fn judged(made: &Made) -> PairCounts {
    let Some(tiles) = &made.plan.tiles else { return PairCounts::default() };
    let grid = &tiles.grid;
    let tile_of = |pixel: u32| {
        let (x, y) = (pixel % grid.width, pixel / grid.width);
        y / tiles.tile * grid.columns + x / tiles.tile
    };
    let cells: Vec<u32> = (0..grid.width * grid.height).map(tile_of).collect();
    let lists = light_pairs::Lists { cell_of_sample: &cells, offsets: &made.lists.offsets, lights: &made.lists.lights };
    let lights: Vec<_> = made.plan.lighting.in_table_order().cloned().collect();
    Oracle::new(&lights, &made.plan.view).count(&made.depth, &lists)
}

/// Lists and bounds equal their twin to the bit, and the oracle misses no light.
pub fn tile_lists(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let scenes = ["atrium", "terrain"].map(|name| (name, scene(name, 1200)));
    for (name, scene) in scenes {
        let scene = scene?;
        for (variant, request) in variants().into_iter().filter(|v| v.1.prepass) {
            let made = make(renderer, &scene, &request)?;
            let (bounds, lists) = twin(&made);
            let wrong = usize::from(bounds != made.bounds) + usize::from(lists != made.lists) + made.violations;
            rows.push(Row::none(format!("lists = twin, {name}, {variant}"), wrong, "buffers that differ"));
            let counts = judged(&made);
            let wrong = counts.missed_pairs + counts.unordered + counts.foreign;
            rows.push(Row::none(format!("lists miss nothing, {name}, {variant}"), wrong as usize, "pairs"));
        }
    }
    Ok(rows)
}

/// T3: each optimisation keeps what it gains, as waste on a fixed scene. A mask that quietly stops working fails here.
pub fn tile_waste(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = scene("atrium", 4096)?;
    let rules = LightRules { range: RangeRule::Fixed(1.0), ..LightRules::default() };
    let base = Request { width: 320, height: 180, rules, ..request(Technique::TiledForward) };
    let waste = |cull, bounds| -> Result<f64> {
        let request = Request { cull, depth_bounds: Some(bounds), ..base.clone() };
        Ok(judged(&make(renderer, &scene, &request)?).waste_samples())
    };
    let box_mask = waste(CullTest::FrustumAabb, DepthBounds::Mask)?;
    let box_bounds = waste(CullTest::FrustumAabb, DepthBounds::MinMax)?;
    let box_off = waste(CullTest::FrustumAabb, DepthBounds::Off)?;
    let planes_bounds = waste(CullTest::Frustum, DepthBounds::MinMax)?;
    let row = |name: &str, gain: f64, least: f64| Row {
        name: name.into(),
        passed: gain >= least,
        detail: format!("{gain:.3} times fewer pairs, at least {least}"),
    };
    Ok(vec![
        row("T3 mask of slots against min and max", box_bounds / box_mask, 1.05),
        row("T3 min and max against no bounds", box_off / box_bounds, 1.5),
        row("T1 box and planes against planes", planes_bounds / box_bounds, 1.05),
    ])
}
