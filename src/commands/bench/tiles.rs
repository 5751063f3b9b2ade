//! `tiles`: tile size, depth bounds and technique, with the times of depth reduction, of list building on the device and on one core
//! of the CPU, and of shading.

use std::hint::black_box;
use std::time::Instant;

use serde_json::{Value, json};

use super::cell::{Cell, STAGES, digits};
use super::output::{About, Outcome};
use super::run::{Case, Runner, contenders};
use super::sweep::{Place, Shown, Sweep, joined};
use crate::error::Result;
use crate::lists;
use crate::measure::html::Table;
use crate::measure::plot::{self, Axis, Bars, Figure, Scale};
use crate::measure::times::Spread;
use crate::passes;
use crate::plan::{DepthBounds, Plan, Request};
use crate::reference::depth_reduce::TileBounds;
use crate::reference::tile_cull;
use crate::scene::Scene;

const LIGHTS: u32 = 4096;

/// Metres.
const RANGE: f64 = 1.0;

/// Pixels along a side.
const TILES: &[u32] = &[8, 16, 32, 64];
const QUICK_TILES: &[u32] = &[8, 32];

/// Times that the CPU makes each set of lists.
const TWIN_ROUNDS: [usize; 2] = [3, 1];

/// Techniques with tiles, each with every knowledge of depth; those of one technique follow one another in the order of
/// [`DepthBounds::ALL`].
fn variants() -> Vec<(String, DepthBounds, Request)> {
    let tiled = contenders().into_iter().filter(|(_, request)| request.technique.name().starts_with("tiled"));
    let variants = tiled.flat_map(|(name, request)| {
        DepthBounds::ALL.map(|bounds| (name.clone(), bounds, Request { depth_bounds: Some(bounds), ..request.clone() }))
    });
    variants.collect()
}

/// Milliseconds of the CPU for one tile size, by [`DepthBounds::ALL`].
type CpuTimes = Vec<Option<f64>>;

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (count, range) = (runner.count(LIGHTS), runner.range(RANGE));
    let size = runner.size((1280, 720), (640, 360));
    runner.light(&mut loaded, count)?;
    let tiles = runner.either(TILES, QUICK_TILES);
    let variants = variants();
    let mut session = runner.session("tiles", tiles.len() * variants.len());
    let (mut sweep, mut cpu) = (Sweep::new("tile"), Vec::new());
    for &tile in tiles {
        let case = |(technique, bounds, request): &(String, DepthBounds, Request)| -> Case {
            (format!("{technique}, {}", bounds.name()), Request { tile, ..request.clone() })
        };
        let cases = runner.sized(variants.iter().map(case).collect(), size, range);
        let cells = session.group(&loaded.scene, &cases, None)?;
        let of_bounds = cases.iter().take(DepthBounds::ALL.len());
        cpu.push(of_bounds.map(|(_, request)| twin_ms(runner, &loaded.scene, request)).collect());
        let facts = json!({ "tile": tile, "lights": count, "light_range": range });
        sweep.places.push(Place { name: tile.to_string(), x: f64::from(tile), facts, cells });
    }
    drop(session);
    let about = About {
        name: "tiles",
        title: format!("tiles: {}, {count} lights at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let bars = sweep.bars(runner, &about.title, (Shown::FramesPerSecond, Scale::Linear));
    let mut figures = vec![bars];
    if let Some((technique, ..)) = variants.first() {
        figures.push(parts(runner, &sweep, technique));
    }
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, figures);
    outcome.notes.clear();
    outcome.section.tables = vec![table(runner, &sweep, &cpu, &mut outcome.notes)];
    outcome.rows = with_variants(runner, &sweep, &cpu)
        .map(|(place, cell, bounds, cpu_ms)| {
            let more = json!({ "depth_bounds": bounds.name(), "cpu_lists_ms": cpu_ms });
            joined(&joined(&place.facts, &more), &cell.json(runner))
        })
        .collect::<Vec<Value>>();
    Ok(outcome)
}

/// Every cell with its knowledge of depth and the time of the CPU.
fn with_variants<'a>(
    runner: &Runner,
    sweep: &'a Sweep,
    cpu: &'a [CpuTimes],
) -> impl Iterator<Item = (&'a Place, &'a Cell, DepthBounds, Option<f64>)> {
    let devices = runner.renderers.len();
    sweep.places.iter().zip(cpu).flat_map(move |(place, times)| {
        place.cells.iter().enumerate().map(move |(index, cell)| {
            let bounds = index / devices % DepthBounds::ALL.len();
            (place, cell, DepthBounds::ALL[bounds], times.get(bounds).copied().flatten())
        })
    })
}

/// Milliseconds in which one core makes the lists of a plan from the depth bounds that the first device found; `None` where it refuses
/// the plan.
fn twin_ms(runner: &Runner, scene: &Scene, request: &Request) -> Option<f64> {
    let renderer = &runner.renderers[0];
    let plan = Plan::new(scene, request, &renderer.limits()).ok()?;
    let tiles = plan.tiles.as_ref()?;
    let made = lists::make(renderer, scene, &plan).ok()?;
    let bounds: Vec<TileBounds> = made.bounds.iter().map(|&words| TileBounds::from_words(words)).collect();
    let inputs = tile_cull::Inputs {
        grid: &tiles.grid,
        lights: &tiles.lights,
        cones: &tiles.cones,
        edges: &tiles.edges,
        cull: passes::tile_cull::cull_constant(tiles.cull),
        depth_bounds: passes::depth_reduce::bounds_constant(tiles.bounds),
        slots: tiles.slots,
        bounds: &bounds,
    };
    let once = |_| {
        let start = Instant::now();
        black_box(tile_cull::run(black_box(&inputs)));
        start.elapsed().as_secs_f64() * 1e3
    };
    let times: Vec<f64> = (0..runner.either(TWIN_ROUNDS[0], TWIN_ROUNDS[1])).map(once).collect();
    Some(Spread::of(&times).median)
}

fn table(runner: &Runner, sweep: &Sweep, cpu: &[CpuTimes], notes: &mut Vec<String>) -> Table {
    let header =
        ["tile", "case", "frames/s", "frame", "geometry", "depth reduction", "lists", "lists, one CPU core", "shading"];
    let row = |(place, cell, _, cpu_ms): (&Place, &Cell, DepthBounds, Option<f64>)| {
        let optional = |value: Option<f64>| value.map_or("-".into(), digits);
        let median = cell.spread().map(|spread| spread.median);
        let rate = median.map_or_else(|| cell.missing(notes), |ms| digits(1e3 / ms));
        let [geometry, reduction, lists, shading] =
            std::array::from_fn(|stage| optional(cell.stages().map(|ms| ms[stage])));
        let name = runner.name_of(cell);
        vec![place.name.clone(), name, rate, optional(median), geometry, reduction, lists, optional(cpu_ms), shading]
    };
    Table {
        caption: "Medians, in ms but for the frames a second".into(),
        header: header.map(String::from).to_vec(),
        rows: with_variants(runner, sweep, cpu).map(row).collect(),
    }
}

/// Where the time of the first technique goes on the first device.
fn parts(runner: &Runner, sweep: &Sweep, technique: &str) -> Figure {
    let devices = runner.renderers.len();
    let places = || sweep.places.iter();
    let shown = |place: &Place| -> Vec<Option<[f64; STAGES.len()]>> {
        place.cells.iter().step_by(devices).take(DepthBounds::ALL.len()).map(Cell::stages).collect()
    };
    let names = |place: &Place| DepthBounds::ALL.map(|bounds| format!("{} {}", place.name, bounds.name()));
    let of_stage = |stage: usize| places().flat_map(&shown).map(|ms| ms.map(|ms| ms[stage])).collect();
    Figure::Bars(Bars {
        title: format!("tiles: where the time of {technique} goes"),
        caption: "By the pixels along a tile's side and what is known of its depths; medians.".into(),
        y: Axis { label: "ms".into(), scale: Scale::Linear },
        groups: places().flat_map(names).collect(),
        series: STAGES.iter().enumerate().map(|(stage, name)| (name.to_string(), of_stage(stage))).collect(),
        stacked: true,
    })
}
