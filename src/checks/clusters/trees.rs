//! Candidates from the light hierarchy against those from lists of tiles: the same clusters, the same lists, and forward's picture.

use glam::DVec3;

use super::{KINDS, Made, differing, judged, make, of_kind, radiance, request, scene, unlike_twin};
use crate::checks::Row;
use crate::error::Result;
use crate::passes;
use crate::plan::{AssignChoice, CameraChoice, ClusterBounds, DepthBounds, Request, Technique, Tiles};
use crate::reference::tile_cull::{self, Lists};
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::shared::BOUNDS_OFF;

/// Pixels along each side of a tile: one block, and several.
const TILES: [u32; 2] = [16, 64];

/// What is asked for, but for the source of candidates.
struct Case {
    name: String,
    scene: Scene,
    request: Request,
}

impl Case {
    fn new(name: impl Into<String>, scene: Scene) -> Self {
        let request = of_kind(&Request { width: 96, height: 54, ..request(Technique::Forward) }, KINDS[0]);
        Self { name: name.into(), scene, request }
    }
}

/// Lists of tiles that know nothing of depths, from the twin: what walks through the hierarchy choose from.
pub(super) fn tile_lists(tiles: &Tiles) -> Lists {
    tile_cull::run(&tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        cull: passes::tile_cull::cull_constant(tiles.cull),
        depth_bounds: BOUNDS_OFF,
        slots: tiles.slots,
        bounds: &[],
    })
}

/// Every kind of clusters.
fn kinds() -> Result<Vec<Case>> {
    let kinds = KINDS.into_iter().flat_map(|kind| TILES.map(|tile| ("atrium", kind, tile)));
    let case = |(name, kind, tile)| -> Result<Case> {
        let (label, _, _): (&str, bool, ClusterBounds) = kind;
        let request = Request { tile, ..of_kind(&request(Technique::Forward), kind) };
        Ok(Case { name: format!("{name}, {label}, tile {tile}"), scene: scene(name, 1200)?, request })
    };
    kinds.chain([("terrain", KINDS[0], TILES[0])]).map(case).collect()
}

/// Few lights and many (C8): below one root and two, in lists longer than one thread sorts, of which some reach everything; and no cluster.
fn counts() -> Result<Vec<Case>> {
    let mut many = Case::new("40,000 lights", scene("atrium", 40_000)?);
    many.scene.lights.iter_mut().for_each(|light| light.range = Some(0.3));
    let mut heap = Case::new("5,000 lights at one point", scene("cornell", 5000)?);
    heap.scene.lights.iter_mut().for_each(|light| light.position = DVec3::new(0.5, 2.0, 1.5));
    let mut wide = Case::new("1,200 lights, 20 of them wide", scene("atrium", 1200)?);
    for (index, light) in wide.scene.lights.iter_mut().enumerate() {
        light.range = Some(if index % 60 == 0 { 1e4 } else { 0.5 });
    }
    let mut away = Case::new("nothing seen", scene("cornell", 33)?);
    let far = DVec3::new(0.0, 0.0, 1000.0);
    away.request.camera = CameraChoice::LookAt(far, 2.0 * far, 1.0);
    // Without a light nothing is listed (`cluster_cases`).
    let few = [1, 33].map(|lights| scene("cornell", lights).map(|scene| Case::new(format!("{lights} lights"), scene)));
    few.into_iter().chain([many, heap, wide, away].map(Ok)).collect()
}

/// Buffers that the two sources leave otherwise.
fn unlike(by_tree: &Made, by_tiles: &Made) -> usize {
    [
        by_tree.depth != by_tiles.depth,
        by_tree.index != by_tiles.index,
        by_tree.keys != by_tiles.keys,
        by_tree.boxes != by_tiles.boxes,
        by_tree.lists != by_tiles.lists,
        !by_tree.plan.walks_tree() || by_tiles.plan.walks_tree(),
    ]
    .into_iter()
    .filter(|unlike| *unlike)
    .count()
}

fn rows(renderer: &Renderer, case: &Case) -> Result<[Row; 4]> {
    let name = &case.name;
    let tree = Request { assign: AssignChoice::Tree, ..case.request.clone() };
    let tiles = Request { assign: AssignChoice::Tiles, depth_bounds: Some(DepthBounds::Off), ..case.request.clone() };
    let by_tree = make(renderer, &case.scene, &tree)?;
    let by_tiles = make(renderer, &case.scene, &tiles)?;
    let mut same = Row::none(format!("tree = tiles, {name}"), unlike(&by_tree, &by_tiles), "buffers that differ");
    let walks = by_tree.plan.clusters.as_ref().and_then(|c| c.tree.as_ref()).map_or(0, |s| s.tree.walk_count());
    let (clusters, pairs) = (by_tree.lists.offsets.len().saturating_sub(1), by_tree.lists.lights.len());
    same.detail += &format!(", {clusters} clusters of {walks} walks, {pairs} pairs");
    let twin = Row::none(format!("clusters by tree = twin, {name}"), unlike_twin(&by_tree)?, "buffers that differ");
    let counts = judged(&by_tree, &by_tree.index, &by_tree.lists);
    let wrong = (counts.missed_pairs + counts.unordered + counts.foreign) as usize;
    let missed = Row::none(format!("clusters by tree miss nothing, {name}"), wrong, "pairs");
    let forward = Request { technique: Technique::Forward, ..case.request.clone() };
    let count = differing(&radiance(renderer, &case.scene, &forward)?, &radiance(renderer, &case.scene, &tree)?);
    Ok([same, twin, missed, Row::none(format!("by tree = forward, {name}"), count, "differing pixels")])
}

/// Lists are the same words whichever way their candidates come.
pub fn cluster_trees(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut found = Vec::new();
    for case in kinds()?.iter().chain(&counts()?) {
        found.extend(rows(renderer, case)?);
    }
    Ok(found)
}
