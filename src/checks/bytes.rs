//! C10: light lists are the same bytes whenever and wherever they are made. Made twenty times on one driver; and on any driver, at any
//! subgroup size, from tile bounds that are made up of integers and uploaded in the place of depth reduction's.
//!
//! What goes into culling is planned on the CPU for the least sub-pixel precision, so that it does not depend on the device. A row's
//! digest is that of its lists; tests/lists.txt has those that every driver must give.

use super::{Row, clusters};
use crate::error::{Error, Result};
use crate::lists::{self, Made};
use crate::math::random::Random;
use crate::passes;
use crate::plan::{AssignChoice, ClusterBounds, CullTest, DepthBounds, Limits, Plan, Request, Technique, Tiles};
use crate::reference::depth_reduce::TileBounds;
use crate::reference::tile_cull::{self, Lists};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Scene, builtin, scatter};

/// Runs that must agree.
const RUNS: usize = 20;

/// Metres.
const RANGE: f64 = 1.5;

/// 64-bit FNV-1a over the words of offsets and ids, from the lowest byte on.
fn digest(lists: [&[u32]; 2]) -> u64 {
    let bytes = lists.into_iter().flatten().flat_map(|word| word.to_le_bytes());
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}

fn court() -> Result<Scene> {
    let mut scene = builtin::load("atrium")?;
    scene.lights = scatter::point_lights(&scene.bounds(), 1500, 3);
    Ok(scene)
}

fn request(technique: Technique) -> Request {
    let rules = LightRules { range: RangeRule::Fixed(RANGE), ..LightRules::default() };
    Request { width: 150, height: 85, technique, rules, ..crate::checks::forward() }
}

/// Lists of tiles and of clusters, twenty times each.
pub fn twenty_runs(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = court()?;
    let mut rows = Vec::new();
    let clusters = |tile| Request { tile, ..request(Technique::ClusteredForward) };
    let by_tree = Request { assign: AssignChoice::Tree, ..clusters(16) };
    // Blocks of a tile of 32 pixels are sorted and merged.
    for (name, request) in [
        ("tiles", request(Technique::TiledForward)),
        ("clusters", clusters(16)),
        ("merged clusters", clusters(32)),
        ("clusters by tree", by_tree),
    ] {
        let plan = Plan::new(&scene, &request, &renderer.limits())?;
        let frame = passes::cluster_frame(&plan).unwrap_or_else(|| passes::list_frame(&plan));
        let mut prepared = renderer.prepare_frame(&scene, &plan, frame)?;
        let mut found: Vec<Made> = Vec::new();
        for _ in 0..RUNS {
            prepared.draw(1)?;
            found.push(lists::read(&plan, &prepared.read_back()?));
        }
        let same = |a: &Made, b: &Made| a.cells == b.cells && a.candidates == b.candidates && a.bounds == b.bounds;
        let different = found.iter().filter(|made| !same(made, &found[0])).count() + prepared.check().len();
        let pairs = found[0].cells.light_pairs();
        let mut row =
            Row::none(format!("C10 lists of {name}, {RUNS} runs"), different, "runs that differ, or violations");
        row.passed &= pairs > 0;
        row.detail += &format!(", {pairs} pairs");
        rows.push(row);
    }
    Ok(rows)
}

/// Bounds of a tile from integers: none, flat, or up to 12 m deep, in steps that f32 holds; any mask.
fn made_up(tile: u64) -> TileBounds {
    let mut random = Random::new(tile);
    let [shape, near, depth, mask] = [(); 4].map(|()| random.next_u64());
    if shape.is_multiple_of(8) {
        return TileBounds::SKY;
    }
    let near = 0.5 + (near % 64) as f32 * 0.25;
    let far = near + (depth % 49) as f32 * 0.25;
    TileBounds { near, far, mask }
}

/// Each test with each knowledge of depth, and tiles of other sizes.
fn variants() -> Vec<(String, Request)> {
    let base = request(Technique::TiledForward);
    let mut variants = Vec::new();
    for cull in [CullTest::Bounds, CullTest::Frustum, CullTest::FrustumAabb] {
        for bounds in [DepthBounds::MinMax, DepthBounds::Mask] {
            let request = Request { cull, depth_bounds: Some(bounds), ..base.clone() };
            variants.push((format!("{} {}", cull.name(), bounds.name()), request));
        }
    }
    for tile in [8, 32, 64] {
        variants.push((format!("tile {tile}"), Request { tile, ..base.clone() }));
    }
    variants
}

/// What the twin makes of the same bounds.
fn twin(tiles: &Tiles, bounds: &[TileBounds]) -> Lists {
    tile_cull::run(&tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        cull: passes::tile_cull::cull_constant(tiles.cull),
        depth_bounds: passes::depth_reduce::bounds_constant(tiles.bounds),
        slots: tiles.slots,
        bounds,
    })
}

/// Lists from bounds that are given: the twin's, and their digest.
pub fn given_bounds(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = court()?;
    let limits = Limits { sub_pixel_bits: Limits::MINIMUM.sub_pixel_bits, ..renderer.limits() };
    let mut rows = Vec::new();
    for (name, request) in variants() {
        let plan = Plan::new(&scene, &request, &limits)?;
        let tiles = plan.tiles.as_ref().ok_or_else(|| Error::new("this technique has no tiles"))?;
        let bounds: Vec<TileBounds> = (0..u64::from(tiles.count_tiles())).map(made_up).collect();
        let texels: Vec<[u32; 4]> = bounds.iter().map(TileBounds::words).collect();
        let frame = passes::given_bounds_frame(&plan, &texels).ok_or_else(|| Error::new("the plan has no tiles"))?;
        let mut prepared = renderer.prepare_frame(&scene, &plan, frame)?;
        prepared.draw(1)?;
        let (picture, violations) = prepared.finish()?;
        let (cells, twin) = (lists::read(&plan, &picture).cells, twin(tiles, &bounds));
        let differ = cells.offsets != twin.offsets || cells.lights != twin.lights;
        let wrong = usize::from(differ) + violations.len();
        let mut row = Row::none(format!("C10 lists of given bounds, {name}"), wrong, "buffers that differ");
        row.passed &= !cells.lights.is_empty();
        let digest = digest([&cells.offsets, &cells.lights]);
        row.detail += &format!(", {} pairs, digest {digest:016x}", cells.lights.len());
        rows.push(row);
    }
    Ok(rows)
}

/// T10: numbers that a depth buffer may hold and those that it should not: no surface, -0, the least and the largest denormal, the least
/// normal number, depths about 1, one past it, infinity, and a hundredth.
const ODD: [u32; 10] =
    [0, 0x8000_0000, 1, 0x007f_ffff, 0x0080_0000, 0x3f7f_ffff, 0x3f80_0000, 0x3f80_0001, 0x7f80_0000, 0x3c23_d70a];

/// Depths in blocks of 4x4 pixels: sky, odd numbers, one distance, two, and many from one on; from integers, so that every machine has the
/// same.
fn made_up_depths(width: u32, height: u32) -> Vec<f32> {
    let of_pixel = |pixel: u32| {
        let block = u64::from(pixel / width / 4 * width + pixel % width / 4);
        let mut shape = Random::new(block);
        let mut own = Random::new(1 << 32 | u64::from(pixel));
        let [kind, first, last] = [(); 3].map(|()| shape.next_u64());
        // From 1/256 to 1: 12.8 m and nearer, up to a near plane of 0.05 m.
        let stored = |word: u64| f32::from_bits(0x3b80_0000 + (word % 0x0400_0000) as u32);
        let mix = own.next_u64();
        match kind % 8 {
            0 => 0.0,
            1 => f32::from_bits(ODD[(mix % ODD.len() as u64) as usize]),
            2 => stored(first),
            3 | 4 => stored(if mix.is_multiple_of(2) { first } else { last }),
            _ => stored(first.wrapping_add(mix % 0x0100_0000)),
        }
    };
    (0..width * height).map(of_pixel).collect()
}

/// C10, T10: lists of tiles and of clusters from depths that are given: bounds, clusters and lists equal the twin's, the oracle misses no
/// light, and their digest.
pub fn given_depth(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = court()?;
    let limits = Limits { sub_pixel_bits: Limits::MINIMUM.sub_pixel_bits, ..renderer.limits() };
    let depth = made_up_depths(150, 85);
    let clustered = |tile| Request { tile, ..request(Technique::ClusteredForward) };
    let implicit = Request { cluster_bounds: Some(ClusterBounds::Implicit), ..clustered(16) };
    let by_tree = Request { assign: AssignChoice::Tree, ..clustered(16) };
    let masked = Request { depth_bounds: Some(DepthBounds::Mask), ..request(Technique::TiledForward) };
    let cases = [
        ("tiles, 2.5d", masked.clone()),
        ("tiles, 2.5d, reduced by groups", Request { group_a_tile: Some(true), ..masked.clone() }),
        ("tiles of 64, 2.5d", Request { tile: 64, ..masked }),
        ("explicit clusters", clustered(16)),
        ("merged clusters", clustered(32)),
        ("implicit clusters", implicit),
        ("clusters by tree", by_tree),
    ];
    let mut rows = Vec::new();
    for (name, request) in cases {
        let plan = Plan::new(&scene, &request, &limits)?;
        let frame = passes::given_depth_frame(&plan, &depth).ok_or_else(|| Error::new("the plan has no lists"))?;
        let mut prepared = renderer.prepare_frame(&scene, &plan, frame)?;
        prepared.draw(1)?;
        let (picture, violations) = prepared.finish()?;
        let made = lists::read(&plan, &picture);
        let of_lists = if plan.clusters.is_some() {
            clusters::wrong_of(plan, &picture, violations.len())?
        } else {
            let counts = made.judge(&plan);
            let missed = counts.missed_pairs + counts.unordered + counts.foreign;
            violations.len() + super::lists::unlike_twin(&plan, &made) + missed as usize
        };
        let wrong = of_lists + unlike_depths(&made.depth, &depth);
        let mut row =
            Row::none(format!("C10 lists of given depths, {name}"), wrong, "buffers that differ, or pairs missed");
        row.passed &= !made.cells.lights.is_empty();
        let digest = digest([&made.cells.offsets, &made.cells.lights]);
        row.detail += &format!(", {} pairs, digest {digest:016x}", made.cells.lights.len());
        rows.push(row);
    }
    Ok(rows)
}

/// Depths that came back as other bits.
fn unlike_depths(back: &[f32], given: &[f32]) -> usize {
    let bits = |depths: &[f32]| depths.iter().map(|depth| depth.to_bits()).collect::<Vec<u32>>();
    usize::from(bits(back) != bits(given))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_changes_the_digest() {
        // Published for no byte and for "foob".
        assert_eq!(digest([&[], &[]]), 0xCBF2_9CE4_8422_2325);
        assert_eq!(digest([&[], &[u32::from_le_bytes(*b"foob")]]), 0xDD12_0E79_0C25_12AF);
        let lists = [&[0, 2, 3][..], &[7, 9, 1]];
        assert_ne!(digest(lists), digest([&[0, 2, 3], &[7, 9, 0]]));
        assert_ne!(digest(lists), digest([&[0, 1, 3], &[7, 9, 1]]));
    }

    #[test]
    fn made_up_bounds_have_skies_flat_and_deep_tiles() {
        let bounds: Vec<TileBounds> = (0..400).map(made_up).collect();
        let count = |test: fn(&TileBounds) -> bool| bounds.iter().filter(|b| test(b)).count();
        assert!(count(|b| *b == TileBounds::SKY) > 20);
        assert!(count(|b| b.near == b.far) > 2);
        assert!(count(|b| b.near < b.far) > 200);
        assert_eq!(made_up(5), made_up(5));
    }
}
