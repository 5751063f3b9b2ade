//! Clusters: clustered forward against forward bit for bit, the device's clusters and lists against their CPU twins, both against the f64
//! oracle, and what they waste.

mod cases;
mod normals;
mod slices;
mod trees;

use super::Row;
use super::lists::radiance;
use crate::error::{Error, Result};
use crate::lists::normal_codes;
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::{ClusterBounds, Clusters, DepthBounds, Plan, Request, Technique, Tiles};
use crate::reference::light_pairs::{self, NO_CELL, Oracle, PairCounts};
use crate::reference::tile_cull::Lists;
use crate::reference::{cluster_assign, cluster_index, cluster_keys, octahedral};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Scene, builtin, scatter};
use crate::shared::BOX_WORDS;

pub(super) use cases::cluster_cases;
pub(super) use normals::cluster_normals;
pub(super) use slices::cluster_slices;
pub(super) use trees::cluster_trees;

/// Not a multiple of any tile size: the last column and row are cut.
const SIZE: (u32, u32) = (150, 85);

/// Every built-in scene.
const SCENES: [&str; 5] = ["cornell", "corridor", "atrium", "terrain", "furnace"];

/// Pixels along each side of a tile.
const TILES: [u32; 4] = [8, 16, 32, 64];

/// Ways to make clusters: their name, whether depth comes first, and what bounds them.
const KINDS: [(&str, bool, ClusterBounds); 3] = [
    ("explicit", true, ClusterBounds::Explicit),
    ("implicit", true, ClusterBounds::Implicit),
    ("no pre-pass", false, ClusterBounds::Implicit),
];

fn scene(name: &str, lights: usize) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
    Ok(scene)
}

fn request(technique: Technique) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, ..crate::checks::forward() }
}

/// The clustered request of a kind; all else as in `base`.
fn of_kind(base: &Request, (_, prepass, bounds): (&str, bool, ClusterBounds)) -> Request {
    let technique = Technique::ClusteredForward;
    Request { technique, prepass, cluster_bounds: Some(bounds), ..base.clone() }
}

fn differing(a: &[u32], b: &[u32]) -> usize {
    if a.len() != b.len() || a.is_empty() {
        return usize::MAX;
    }
    a.chunks(4).zip(b.chunks(4)).filter(|(p, q)| p != q).count()
}

/// Clustered forward draws what forward draws: every scene, every tile size, every kind of clusters.
pub fn clustered(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in SCENES {
        let scene = scene(name, 96)?;
        let forward = radiance(renderer, &scene, &request(Technique::Forward))?;
        for (kind, tile) in KINDS.into_iter().flat_map(|kind| TILES.map(|tile| (kind, tile))) {
            let asked = Request { tile, ..of_kind(&request(Technique::ClusteredForward), kind) };
            let count = differing(&forward, &radiance(renderer, &scene, &asked)?);
            let row = format!("clustered-forward = forward, {name}, {}, tile {tile}", kind.0);
            rows.push(Row::none(row, count, "differing pixels"));
        }
    }
    Ok(rows)
}

/// What the device made of one request.
struct Made {
    plan: Plan,
    depth: Vec<f32>,
    /// Lists of tiles, from which candidates came: an offset a tile. Where they came from the light hierarchy, those of tiles without
    /// depth bounds, made here.
    tile_lists: Lists,
    /// Cluster of each sample, as stored or, where every slice of every tile is one, as its depth says.
    index: Vec<u32>,
    /// Key of each cluster; empty where they have none.
    keys: Vec<u32>,
    /// Box of each cluster; empty where they have none.
    boxes: Vec<u32>,
    /// Codes of the normals that clusters were told apart by; empty where they were not.
    codes: Vec<[u32; 2]>,
    lists: Lists,
    violations: usize,
}

fn words(picture: &Picture, layer: &str) -> Vec<u32> {
    picture.layer(layer).unwrap_or(&[]).iter().map(|x| x.to_bits()).collect()
}

/// Lists whose cells begin at every `stride`th offset.
fn lists(picture: &Picture, [offsets, lights]: [&str; 2], stride: u32, cells: u32) -> Lists {
    let offsets: Vec<u32> =
        words(picture, offsets).into_iter().step_by(stride as usize).take(cells as usize + 1).collect();
    let mut lights = words(picture, lights);
    lights.truncate(offsets.last().map_or(0, |&end| end as usize));
    Lists { offsets, lights }
}

fn parts(plan: &Plan) -> Result<(&Tiles, &Clusters)> {
    plan.tiles.as_ref().zip(plan.clusters.as_ref()).ok_or_else(|| Error::new("this technique has no clusters"))
}

fn tile_of(tiles: &Tiles, pixel: u32) -> u32 {
    let (x, y) = (pixel % tiles.grid.width, pixel / tiles.grid.width);
    y / tiles.tile * tiles.grid.columns + x / tiles.tile
}

fn make(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Made> {
    make_of(renderer, scene, Plan::new(scene, request, &renderer.limits())?)
}

fn make_of(renderer: &Renderer, scene: &Scene, plan: Plan) -> Result<Made> {
    let frame = passes::cluster_frame(&plan).ok_or_else(|| Error::new("this technique has no clusters"))?;
    let mut prepared = renderer.prepare_frame(scene, &plan, frame)?;
    // The second frame meets what the first one left.
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    read(plan, &picture, violations.len())
}

/// Buffers of clusters that differ from the twin's, and pairs that are missed or out of order, in what a frame of their lists left.
pub(in crate::checks) fn wrong_of(plan: Plan, picture: &Picture, violations: usize) -> Result<usize> {
    let made = read(plan, picture, violations)?;
    let counts = judged(&made, &made.index, &made.lists);
    Ok(unlike_twin(&made)? + (counts.missed_pairs + counts.unordered + counts.foreign) as usize)
}

fn read(plan: Plan, picture: &Picture, violations: usize) -> Result<Made> {
    let (tiles, clusters) = parts(&plan)?;
    let depth = picture.layer("depth").unwrap_or(&[]).to_vec();
    let total = words(picture, "cluster_total").first().copied().unwrap_or(clusters.grid.capacity);
    let dense = |(pixel, &depth): (u32, &f32)| {
        tile_of(tiles, pixel) * clusters.grid.slices + cluster_keys::slice(&tiles.grid, &clusters.grid, depth)
    };
    let mut index = words(picture, "cluster_index");
    if !clusters.keyed {
        index = (0..).zip(&depth).map(dense).collect();
    }
    let mut keys = words(picture, "cluster_keys");
    keys.truncate(total as usize);
    let mut boxes = words(picture, "cluster_bounds");
    let explicit = clusters.bounds == ClusterBounds::Explicit;
    boxes.truncate(if explicit { (total * BOX_WORDS) as usize } else { 0 });
    let tile_lists = if plan.walks_tree() {
        trees::tile_lists(tiles)
    } else {
        lists(picture, ["tile_offsets", "tile_lights"], tiles.grid.list_chunks, tiles.count_tiles())
    };
    let lists = lists(picture, ["list_offsets", "list_lights"], 1, total);
    let planned = plan.deferred.as_ref().map(|deferred| deferred.gbuffer);
    let codes = planned.map_or_else(Vec::new, |planned| normal_codes(picture, &planned));
    Ok(Made { depth, tile_lists, index, keys, boxes, codes, lists, violations, plan })
}

/// Buffers in which the device differs from the twin run on the depth that was read back, and what the checker found.
fn unlike_twin(made: &Made) -> Result<usize> {
    let (tiles, clusters) = parts(&made.plan)?;
    let (grid, cut) = (&tiles.grid, &clusters.grid);
    let twin = cluster_keys::run(grid, cut, &made.depth, clusters.by_normal().then_some(&made.codes[..]));
    let mut wrong = made.violations;
    if clusters.keyed {
        wrong += usize::from(twin.keys != made.keys) + usize::from(twin.index != made.index);
    }
    let explicit = clusters.bounds == ClusterBounds::Explicit;
    let boxes = cluster_index::run(grid, cut, &made.depth, &twin.index, twin.keys.len());
    if explicit {
        let stored: Vec<u32> = boxes.iter().flat_map(|b| b.words()).collect();
        wrong += usize::from(stored != made.boxes);
    }
    let inputs = cluster_assign::Inputs {
        grid,
        clusters: cut,
        slices: &clusters.slices,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        tile_lists: &made.tile_lists,
        keys: clusters.keyed.then_some(&twin.keys[..]),
        boxes: explicit.then_some(&boxes[..]),
        directions: clusters.by_normal().then_some(&clusters.directions[..]),
    };
    Ok(wrong + usize::from(cluster_assign::run(&inputs) != made.lists))
}

/// Judges lists by the f64 oracle.
fn judged(made: &Made, cell_of_sample: &[u32], lists: &Lists) -> PairCounts {
    let lists = light_pairs::Lists { cell_of_sample, offsets: &lists.offsets, lights: &lists.lights };
    let lights: Vec<_> = made.plan.lighting.in_table_order().cloned().collect();
    let bits = made.plan.deferred.as_ref().map_or(0, |deferred| deferred.gbuffer.normal_bits);
    let normals = made.codes.iter().map(|&code| octahedral::decode(code, bits)).collect();
    Oracle::new(&lights, &made.plan.view).facing(normals).count(&made.depth, &lists)
}

/// Clusters and lists of one request: twin and oracle.
pub(in crate::checks) fn rows_of(
    renderer: &Renderer,
    name: &str,
    scene: &Scene,
    request: &Request,
) -> Result<[Row; 2]> {
    let made = make(renderer, scene, request)?;
    let counts = judged(&made, &made.index, &made.lists);
    let solid = made.depth.iter().zip(&made.index).filter(|(depth, _)| cluster_keys::shows_surface(**depth));
    let homeless = solid.filter(|(_, id)| **id == NO_CELL).count();
    let wrong = counts.missed_pairs + counts.unordered + counts.foreign;
    let (_, clusters) = parts(&made.plan)?;
    let mut twin = Row::none(format!("clusters = twin, {name}"), unlike_twin(&made)?, "buffers that differ");
    twin.detail +=
        &format!(", {} clusters of {} slices", made.lists.offsets.len().saturating_sub(1), clusters.grid.slices);
    let mut missed = Row::none(format!("clusters miss nothing, {name}"), wrong as usize + homeless, "pairs");
    missed.detail += &format!(", waste_samples {:.3}, waste_cells {:.3}", counts.waste_samples(), counts.waste_cells());
    Ok([twin, missed])
}

/// Clusters, boxes and lists equal their twin to the bit, and the oracle misses no light.
pub fn cluster_lists(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in ["atrium", "terrain"] {
        let scene = scene(name, 1200)?;
        for (kind, tile) in KINDS.into_iter().flat_map(|kind| TILES.map(|tile| (kind, tile))) {
            let asked = Request { tile, ..of_kind(&request(Technique::ClusteredForward), kind) };
            rows.extend(rows_of(renderer, &format!("{name}, {}, tile {tile}", kind.0), &scene, &asked)?);
        }
    }
    Ok(rows)
}

/// Waste on a fixed scene: boxes of samples beat slices of tiles, and these beat tiles with a mask. A box that quietly grows fails here.
pub fn cluster_waste(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = scene("atrium", 4096)?;
    let rules = LightRules { range: RangeRule::Fixed(1.0), ..LightRules::default() };
    let base = Request { width: 320, height: 180, rules, ..request(Technique::ClusteredForward) };
    let masked = Request { depth_bounds: Some(DepthBounds::Mask), ..base };
    let [explicit, implicit, _] = KINDS.map(|kind| of_kind(&masked, kind));
    let (explicit, implicit) = (make(renderer, &scene, &explicit)?, make(renderer, &scene, &implicit)?);
    let (tiles, _) = parts(&implicit.plan)?;
    let tile_of_sample: Vec<u32> = (0..tiles.grid.width * tiles.grid.height).map(|p| tile_of(tiles, p)).collect();
    let of_tiles = judged(&implicit, &tile_of_sample, &implicit.tile_lists);
    let of_slices = judged(&implicit, &implicit.index, &implicit.lists);
    let of_boxes = judged(&explicit, &explicit.index, &explicit.lists);
    let row = |name: &str, less: &PairCounts, more: &PairCounts| Row {
        name: format!("waste of {name}"),
        passed: less.waste_samples() < more.waste_samples() && less.missed_pairs == 0 && less.exact_pairs > 0,
        detail: format!(
            "waste_samples {:.3} under {:.3}, waste_cells {:.3} and {:.3}",
            less.waste_samples(),
            more.waste_samples(),
            less.waste_cells(),
            more.waste_cells()
        ),
    };
    Ok(vec![
        row("explicit clusters against implicit", &of_boxes, &of_slices),
        row("implicit clusters against tiles with a mask", &of_slices, &of_tiles),
    ])
}
