//! What light lists hold in vain on a fixed scene: the atrium under 4,096 scattered lights of 1 m, tiles of 16 pixels.
//!
//! Three figures, each listed over needed: of pairs of light and sample (`waste_samples`, needed is a light that reaches the sample), of
//! pairs of light and cell (`waste_cells`, needed is one that reaches a sample of the cell), and against the cell's exact volume (needed
//! is one whose sphere, of its true range, meets the volume in f64). That volume is, of a tile, what lies between its four planes and its
//! nearest and farthest sample, or with a mask the parts of that in the slots that hold samples; of an implicit cluster, the part of its
//! tile's volume in its slice; of an explicit one, what lies between its tile's planes, its nearest and farthest sample, and in the box of
//! its samples, each of which fills its pixel at its depth.
//!
//! All but a mask keep what holds this volume, and radii are widened: a sphere that meets the volume must be listed. Slots of a mask are
//! told apart in f32, so a sphere may meet one by a rounding and not be listed.

use glam::DVec3;

use super::Row;
use super::lists::make;
use crate::error::{Error, Result};
use crate::lists::Made;
use crate::plan::{ClusterBounds, Clusters, CullTest, DepthBounds, Plan, Request, Technique, Tiles};
use crate::reference::cell_volume::{self, Volume, VolumeCounts};
use crate::reference::cluster_keys;
use crate::reference::depth_reduce::{self, TileBounds};
use crate::reference::light_pairs::{Lists, Oracle, PairCounts};
use crate::reference::tile_cull;
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Scene, builtin, scatter};
use crate::shared;

/// Entries of lists for each one that is needed, at most.
#[derive(Clone, Copy)]
struct Most {
    samples: f64,
    cells: f64,
    volume: f64,
}

/// What is asserted at one size of the picture.
struct Bounds {
    /// Explicit clusters, implicit clusters, tiles with a mask.
    lists: [Most; 3],
    /// T1: what planes and box list for one light whose sphere meets the exact volume of a tile with min/max.
    tests: f64,
}

/// At 1280x720.
const WHOLE: Bounds = Bounds {
    lists: [
        Most { samples: 1.5, cells: 1.15, volume: 1.1 },
        Most { samples: 1.8, cells: 1.5, volume: 1.1 },
        Most { samples: 3.2, cells: 1.65, volume: 1.2 },
    ],
    tests: 1.2,
};

/// At 320x180, where a tile sees four times as far to each side.
const SMALL: Bounds = Bounds {
    lists: [
        Most { samples: 6.0, cells: 1.6, volume: 1.2 },
        Most { samples: 9.0, cells: 2.9, volume: 1.2 },
        Most { samples: 16.0, cells: 2.6, volume: 1.5 },
    ],
    tests: 1.5,
};

fn court() -> Result<Scene> {
    let mut scene = builtin::load("atrium")?;
    scene.lights = scatter::point_lights(&scene.bounds(), 4096, 3);
    Ok(scene)
}

fn request(width: u32, height: u32) -> Request {
    let rules = LightRules { range: RangeRule::Fixed(1.0), ..LightRules::default() };
    Request { width, height, rules, technique: Technique::TiledForward, ..crate::checks::forward() }
}

fn clustered(base: &Request, bounds: ClusterBounds) -> Request {
    Request { technique: Technique::ClusteredForward, cluster_bounds: Some(bounds), ..base.clone() }
}

fn tiles_of(plan: &Plan) -> Result<&Tiles> {
    plan.tiles.as_ref().ok_or_else(|| Error::new("this technique has no tiles"))
}

fn lists_of(made: &Made) -> Lists<'_> {
    let cells = &made.cells;
    Lists { cell_of_sample: &cells.cell_of_sample, offsets: &cells.offsets, lights: &cells.lights }
}

/// What the samples of a cell span in view space.
#[derive(Clone, Copy)]
struct Span {
    tile: u32,
    /// Of one of them, as stored.
    depth: f32,
    low: DVec3,
    high: DVec3,
}

/// Spans of cells; `None` for one without a sample.
fn spans(plan: &Plan, tiles: &Tiles, depth: &[f32], lists: &Lists) -> Vec<Option<Span>> {
    let view = &plan.view;
    let mut spans: Vec<Option<Span>> = vec![None; lists.offsets.len().saturating_sub(1)];
    for (pixel, (&depth, &cell)) in (0u32..).zip(depth.iter().zip(lists.cell_of_sample)) {
        let (x, y) = (pixel % view.width, pixel / view.width);
        let Some(position) = Oracle::position(view, x, y, depth) else { continue };
        let Some(span) = spans.get_mut(cell as usize) else { continue };
        let [low, high] = cell_volume::extent(view, [x, x + 1], [y, y + 1], [-position.z; 2]);
        *span = Some(match *span {
            Some(known) => Span { low: known.low.min(low), high: known.high.max(high), ..known },
            None => Span { tile: y / tiles.tile * tiles.grid.columns + x / tiles.tile, depth, low, high },
        });
    }
    spans
}

/// By what a cell's exact volume is known, beside the planes of its tile.
#[derive(Clone, Copy)]
enum Known<'a> {
    /// Its nearest and farthest sample.
    Samples,
    /// Tile bounds as stored: the slots of masks.
    Slots(&'a [[u32; 4]]),
    /// Its slice, and tile bounds as stored.
    Slice(&'a Clusters, &'a [[u32; 4]]),
    /// The box of its samples.
    Box,
}

impl<'a> Known<'a> {
    fn of(plan: &'a Plan, tiles: &Tiles, made: &'a Made) -> Self {
        match &plan.clusters {
            Some(clusters) if clusters.bounds == ClusterBounds::Explicit => Self::Box,
            Some(clusters) => Self::Slice(clusters, &made.bounds),
            None if tiles.bounds == DepthBounds::Mask => Self::Slots(&made.bounds),
            None => Self::Samples,
        }
    }

    /// The parts of a cell's volume.
    fn volumes(self, plan: &Plan, tiles: &Tiles, span: &Span) -> Vec<Volume> {
        let (grid, side) = (&tiles.grid, tiles.tile);
        let edges = |at: u32, pixels: u32| [at * side, ((at + 1) * side).min(pixels)];
        let columns = edges(span.tile % grid.columns, grid.width);
        let rows = edges(span.tile / grid.columns, grid.height);
        let piece = |distances: [f64; 2]| Volume::piece(&plan.view, columns, rows, distances);
        let sampled = [-span.high.z, -span.low.z];
        let of_tile = |bounds: &[[u32; 4]]| bounds.get(span.tile as usize).map(|&words| TileBounds::from_words(words));
        match self {
            Self::Samples => vec![piece(sampled)],
            Self::Slots(bounds) => {
                of_tile(bounds).into_iter().flat_map(|bounds| slot_runs(&bounds, tiles.slots)).map(piece).collect()
            }
            Self::Slice(clusters, bounds) => {
                let slice = cluster_keys::slice(grid, &clusters.grid, span.depth);
                let [near, far, ..] = clusters.slices[slice as usize];
                let [first, last] = of_tile(bounds).map_or([near, far], |bounds| [bounds.near, bounds.far]);
                vec![piece([near.max(first), far.min(last)].map(f64::from))]
            }
            Self::Box => vec![piece(sampled).within([span.low.x, span.high.x], [span.low.y, span.high.y])],
        }
    }
}

/// Distances at which runs of slots that hold samples begin and end.
fn slot_runs(bounds: &TileBounds, slots: u32) -> Vec<[f64; 2]> {
    let (near, far) = (f64::from(bounds.near), f64::from(bounds.far));
    let begin = |slot: u32| near + (far - near) * f64::from(slot) / f64::from(slots);
    let mut runs: Vec<[f64; 2]> = Vec::new();
    let mut open = false;
    for slot in 0..slots {
        let holds = bounds.mask >> slot & 1 == 1;
        if holds
            && open
            && let Some(run) = runs.last_mut()
        {
            run[1] = begin(slot + 1);
        } else if holds {
            runs.push([begin(slot), begin(slot + 1)]);
        }
        open = holds;
    }
    runs
}

/// What lists hold and what they must.
struct Figures {
    counts: PairCounts,
    volume: VolumeCounts,
    /// Pairs that are missed and, where their listing is proved, pairs of touching light and cell that are not listed.
    wrong: u64,
}

impl Figures {
    fn new(plan: &Plan, depth: &[f32], lists: &Lists, known: Known) -> Result<Self> {
        let tiles = tiles_of(plan)?;
        let parts = |span: &Option<Span>| span.map_or(Vec::new(), |span| known.volumes(plan, tiles, &span));
        let cells: Vec<Vec<Volume>> = spans(plan, tiles, depth, lists).iter().map(parts).collect();
        let lights: Vec<_> = plan.lighting.in_table_order().cloned().collect();
        let counts = Oracle::new(&lights, &plan.view).count(depth, lists);
        let volume = cell_volume::count(&cells, lists, &lights, &plan.view);
        let proved = if matches!(known, Known::Slots(_)) { 0 } else { volume.unlisted };
        Ok(Self { wrong: counts.missed_pairs + proved, counts, volume })
    }

    fn all(&self) -> [(&'static str, f64); 3] {
        [
            ("waste_samples", self.counts.waste_samples()),
            ("waste_cells", self.counts.waste_cells()),
            ("waste against exact volumes", self.volume.waste()),
        ]
    }

    fn rows(&self, name: &str, most: Most) -> Vec<Row> {
        let bounds = [most.samples, most.cells, most.volume];
        let row = |((figure, value), most): ((&str, f64), f64)| at_most(format!("{figure} of {name}"), value, most);
        let mut rows: Vec<Row> = self.all().into_iter().zip(bounds).map(row).collect();
        let pairs = format!("pairs missed or unlisted of {}", self.counts.exact_pairs);
        rows.push(Row::none(format!("T1 nothing missed by {name}"), self.wrong as usize, &pairs));
        rows
    }
}

fn at_most(name: String, figure: f64, most: f64) -> Row {
    Row { name, passed: figure <= most, detail: format!("{figure:.3}, at most {most}") }
}

/// T1: what planes, the box and both list, by the twin and from the bounds that the device made.
fn culling_tests(renderer: &Renderer, scene: &Scene, base: &Request, most: f64) -> Result<Vec<Row>> {
    let asked = Request { depth_bounds: Some(DepthBounds::MinMax), ..base.clone() };
    let (plan, made) = make(renderer, scene, &asked)?;
    let tiles = tiles_of(&plan)?;
    let bounds: Vec<TileBounds> = made.bounds.iter().map(|&words| TileBounds::from_words(words)).collect();
    // Planes that every light passes, so that the box alone decides among the lights of the tile's bin.
    let no_planes: Vec<[f32; 4]> = tiles.edges.iter().map(|edge| [edge[0], 0.0, 0.0, 0.0]).collect();
    let tests: [(&str, u32, &[[f32; 4]]); 4] = [
        ("the rectangle", shared::CULL_RECTANGLE, &tiles.edges),
        ("planes", shared::CULL_PLANES, &tiles.edges),
        ("the box", shared::CULL_PLANES_BOX, &no_planes),
        ("planes and box", shared::CULL_PLANES_BOX, &tiles.edges),
    ];
    let size = format!("{}x{}", base.width, base.height);
    let (mut rows, mut last) = (Vec::new(), f64::NAN);
    for (name, cull, edges) in tests {
        let lists = tile_cull::run(&tile_cull::Inputs {
            grid: &tiles.grid,
            lights: &tiles.lights,
            cones: &tiles.cones,
            edges,
            cull,
            depth_bounds: shared::BOUNDS_MIN_MAX,
            slots: tiles.slots,
            bounds: &bounds,
        });
        let lists = Lists { offsets: &lists.offsets, lights: &lists.lights, ..lists_of(&made) };
        let figures = Figures::new(&plan, &made.depth, &lists, Known::Samples)?;
        let detail = figures.all().map(|(figure, value)| format!("{figure} {value:.3}")).join(", ");
        rows.push(Row { name: format!("T1 {name} for tiles, {size}"), passed: figures.wrong == 0, detail });
        last = figures.volume.waste();
    }
    let name = format!("T1 waste of planes and box against exact volumes, {size}");
    rows.push(at_most(name, last, most));
    Ok(rows)
}

fn wastes(renderer: &Renderer, (width, height): (u32, u32), bounds: &Bounds) -> Result<Vec<Row>> {
    let (scene, base) = (court()?, request(width, height));
    let kinds = [
        ("explicit clusters", clustered(&base, ClusterBounds::Explicit)),
        ("implicit clusters", clustered(&base, ClusterBounds::Implicit)),
        ("tiles with a mask", Request { depth_bounds: Some(DepthBounds::Mask), ..base.clone() }),
    ];
    let mut rows = Vec::new();
    for ((name, asked), &most) in kinds.iter().zip(&bounds.lists) {
        let (plan, made) = make(renderer, &scene, asked)?;
        let known = Known::of(&plan, tiles_of(&plan)?, &made);
        let figures = Figures::new(&plan, &made.depth, &lists_of(&made), known)?;
        rows.extend(figures.rows(&format!("{name}, {width}x{height}"), most));
    }
    rows.extend(culling_tests(renderer, &scene, &base, bounds.tests)?);
    Ok(rows)
}

/// Waste at 320x180.
pub fn waste(renderer: &Renderer) -> Result<Vec<Row>> {
    wastes(renderer, (320, 180), &SMALL)
}

/// Waste at 1280x720.
pub fn waste_deep(renderer: &Renderer) -> Result<Vec<Row>> {
    wastes(renderer, (1280, 720), &WHOLE)
}

/// How much less one way of making lists holds than another.
fn gain(name: &str, more: f64, less: f64, least: f64) -> Row {
    let gain = more / less;
    Row { name: name.into(), passed: gain >= least, detail: format!("{gain:.3} times less, at least {least}") }
}

/// `waste_samples` of the twin's lists with a mask of so many slots, and what its bins save: tests of tile and light over those without.
fn masked(plan: &Plan, made: &Made, slots: u32) -> Result<[f64; 2]> {
    let tiles = tiles_of(plan)?;
    let bounds = depth_reduce::run(&tiles.grid, tiles.tile, Some(slots), &made.depth);
    let inputs = tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        cull: shared::CULL_PLANES_BOX,
        depth_bounds: shared::BOUNDS_MASK,
        slots,
        bounds: &bounds,
    };
    let (bins, lists) = (tile_cull::bins(&inputs), tile_cull::run(&inputs));
    let bin_of = |tile: u32| {
        let [x, y] = [tile % tiles.grid.columns, tile / tiles.grid.columns].map(|at| at / shared::BIN_TILES);
        (y * tiles.grid.bin_columns + x) as usize
    };
    let tested: usize = (0..tiles.count_tiles()).map(|tile| bins.of(bin_of(tile)).len()).sum();
    let lights: Vec<_> = plan.lighting.in_table_order().cloned().collect();
    let lists = Lists { offsets: &lists.offsets, lights: &lists.lights, ..lists_of(made) };
    let waste = Oracle::new(&lights, &plan.view).count(&made.depth, &lists).waste_samples();
    Ok([waste, f64::from(tiles.count_tiles()) * f64::from(tiles.grid.light_count) / tested as f64])
}

/// T1, T3: each step keeps what it gains, as waste on the fixed scene. A mask or a box that quietly stops working fails here.
pub fn tile_waste(renderer: &Renderer) -> Result<Vec<Row>> {
    let (scene, base) = (court()?, request(320, 180));
    let of = |asked: &Request| -> Result<f64> {
        let (plan, made) = make(renderer, &scene, asked)?;
        Ok(made.judge(&plan).waste_samples())
    };
    let tiled = |cull, bounds| of(&Request { cull, depth_bounds: Some(bounds), ..base.clone() });
    let (plan, made) = make(renderer, &scene, &Request { depth_bounds: Some(DepthBounds::Mask), ..base.clone() })?;
    let mask = made.judge(&plan).waste_samples();
    let min_max = tiled(CullTest::FrustumAabb, DepthBounds::MinMax)?;
    let off = tiled(CullTest::FrustumAabb, DepthBounds::Off)?;
    let planes = tiled(CullTest::Frustum, DepthBounds::MinMax)?;
    let explicit = of(&clustered(&base, ClusterBounds::Explicit))?;
    let implicit = of(&clustered(&base, ClusterBounds::Implicit))?;
    let ([few_slots, _], [many_slots, tests]) = (masked(&plan, &made, 8)?, masked(&plan, &made, 32)?);
    Ok(vec![
        gain("T3 waste, mask of slots against min and max", min_max, mask, 1.05),
        gain("T3 waste, min and max against no bounds", off, min_max, 1.5),
        gain("T3 waste, 32 slots against 8", few_slots, many_slots, 1.01),
        gain("T3 waste, implicit clusters against tiles with a mask", mask, implicit, 1.05),
        gain("T3 waste, explicit clusters against implicit", implicit, explicit, 1.05),
        gain("T3 tests of tile and light, bins against none", tests, 1.0, 2.0),
        gain("T1 waste, box and planes against planes", planes, min_max, 1.05),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_slots_are_distances() {
        let bounds = TileBounds { near: 2.0, far: 10.0, mask: 0b1011_0011 };
        assert_eq!(slot_runs(&bounds, 8), [[2.0, 4.0], [6.0, 8.0], [9.0, 10.0]]);
        assert_eq!(slot_runs(&bounds, 4), [[2.0, 6.0]]);
        assert!(slot_runs(&TileBounds::SKY, 32).is_empty());
        assert_eq!(slot_runs(&TileBounds { mask: u64::MAX, ..bounds }, 64), [[2.0, 10.0]]);
    }
}
