//! `million`: from thousands of lights to a million, whose range shrinks so that as many reach each pixel. Techniques with light lists
//! alone: what grows is the time, the memory and the waste of lists.

use serde_json::{Value, json};

use super::cell::{Cell, digits};
use super::output::{About, Outcome};
use super::run::{Case, Runner, contenders};
use super::sweep::{Place, Shown, Sweep, joined, log_axis};
use crate::commands::report;
use crate::error::Result;
use crate::lists::{self, Counters};
use crate::measure::html::Table;
use crate::measure::plot::{self, Scale};
use crate::plan::{Plan, Request, Technique};
use crate::scene::Scene;

const COUNTS: [u32; 5] = [4096, 16_384, 65_536, 262_144, 1_000_000];
const QUICK_COUNTS: [u32; 2] = [4096, 65_536];

/// Lights whose time of assignment that of the others is compared with.
const BASE: u32 = 65_536;

/// Metres at [`COUNTS`]' first.
const RANGE: f64 = 10.0;

/// What the lists of each cell hold, by the f64 oracle, in the order of the sweep; `None` where nothing was drawn.
type Judged = Vec<Option<Counters>>;

/// Contenders that make light lists.
fn cases() -> Vec<Case> {
    let tiled = |technique| matches!(technique, Technique::TiledDeferred | Technique::TiledForward);
    let with_lists = |case: &Case| tiled(case.1.technique) || case.1.technique.clusters();
    contenders().into_iter().filter(with_lists).collect()
}

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:terrain")?;
    let counts = runner.counts(&COUNTS, &QUICK_COUNTS);
    let (size, range) = (runner.size((320, 180), (320, 180)), runner.range(RANGE));
    let mut session = runner.session("million", counts.len() * cases().len());
    let (mut sweep, mut judged) = (Sweep::new("lights"), Judged::new());
    for count in counts {
        runner.light(&mut loaded, count)?;
        // Lights of a volume and the volume of a light: their product stays.
        let range = range * (f64::from(COUNTS[0]) / f64::from(count)).cbrt();
        let cases = runner.sized(cases(), size, range);
        let cells = session.group(&loaded.scene, &cases, Some(f64::from(count)))?;
        judged.extend(judge(runner, &loaded.scene, &cases, &cells)?);
        let facts = json!({ "lights": count, "light_range": range });
        sweep.places.push(Place { name: count.to_string(), x: f64::from(count), facts, cells });
    }
    drop(session);
    let about = About {
        name: "million",
        title: format!("million: {} at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m where there are {}", plot::number(range), COUNTS[0]),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.plot(runner, &about.title, log_axis("lights"), (Shown::Milliseconds, Scale::Log));
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, vec![figure]);
    let tables = [assignment(runner, &sweep, &mut outcome.notes), holdings(runner, &sweep, &judged)];
    outcome.section.tables.extend(tables);
    outcome.rows = rows(runner, &sweep, &judged);
    Ok(outcome)
}

/// Judges the lists of every cell that was drawn; those that a deferred and a forward technique make alike once.
fn judge(runner: &Runner, scene: &Scene, cases: &[Case], cells: &[Cell]) -> Result<Judged> {
    let request = |index: usize| &cases[index / runner.renderers.len()].1;
    let alike = |a: usize, b: usize| {
        cells[a].device == cells[b].device && request(a).technique.clusters() == request(b).technique.clusters()
    };
    let mut found = Judged::new();
    for (index, cell) in cells.iter().enumerate() {
        let known = (0..index).find(|&before| alike(before, index) && found[before].is_some());
        let counters = match (cell.times(), known) {
            (None, _) => None,
            (_, Some(known)) => found[known],
            _ => Some(counters(runner, scene, cell, request(index))?),
        };
        found.push(counters);
    }
    Ok(found)
}

fn counters(runner: &Runner, scene: &Scene, cell: &Cell, request: &Request) -> Result<Counters> {
    let renderer = &runner.renderers[cell.device];
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let made = lists::make(renderer, scene, &plan)?;
    Ok(Counters::new(&made.cells, &made.judge(&plan), lists::directional(&plan)))
}

/// Nanoseconds of list building a light.
fn per_light(place: &Place, cell: &Cell) -> Option<f64> {
    cell.stages().map(|[_, _, lists, _]| lists * 1e6 / place.x)
}

/// The same over that of [`BASE`] lights; `index` counts the cells of the sweep, and each place has as many.
fn over_base(sweep: &Sweep, index: usize) -> Option<f64> {
    let (place, cell) = sweep.cells().nth(index)?;
    let base = sweep.places.iter().find(|place| place.x == f64::from(BASE))?;
    Some(per_light(place, cell)? / per_light(base, &base.cells[index % base.cells.len()])?)
}

fn optional(value: Option<f64>) -> String {
    value.map_or("-".into(), digits)
}

fn assignment(runner: &Runner, sweep: &Sweep, notes: &mut Vec<String>) -> Table {
    let ratio = format!("x {BASE}'s");
    let header = ["lights", "case", "range (m)", "lists (ms)", "ns a light", &ratio, "lists at most", "device memory"];
    let row = |(index, (place, cell)): (usize, (&Place, &Cell))| {
        let drawn = cell.times().is_some();
        let ms = if drawn { optional(cell.stages().map(|ms| ms[2])) } else { cell.missing(notes) };
        let bytes = |bytes: u64| if drawn { report::bytes(bytes) } else { "-".into() };
        vec![
            place.name.clone(),
            runner.name_of(cell),
            place.facts["light_range"].as_f64().map_or("-".into(), plot::number),
            ms,
            optional(per_light(place, cell)),
            optional(over_base(sweep, index)),
            bytes(cell.list_bytes),
            bytes(cell.device_bytes),
        ]
    };
    Table {
        caption: "Assignment of lights, medians".into(),
        header: header.map(String::from).to_vec(),
        rows: sweep.cells().enumerate().map(row).collect(),
    }
}

fn holdings(runner: &Runner, sweep: &Sweep, judged: &[Option<Counters>]) -> Table {
    let header = ["lights", "case", "pairs", "longest list", "waste_samples", "waste_cells", "missed pairs"];
    let row = |((place, cell), counters): ((&Place, &Cell), &Option<Counters>)| {
        let count = |of: fn(&Counters) -> u64| counters.as_ref().map_or("-".into(), |c| of(c).to_string());
        vec![
            place.name.clone(),
            runner.name_of(cell),
            count(|c| c.light_pairs),
            count(|c| u64::from(c.longest_list)),
            optional(counters.map(|c| c.waste_samples)),
            optional(counters.map(|c| c.waste_cells)),
            count(|c| c.missed_pairs),
        ]
    };
    Table {
        caption: "What lists hold, by the f64 oracle".into(),
        header: header.map(String::from).to_vec(),
        rows: sweep.cells().zip(judged).map(row).collect(),
    }
}

/// Rows of the machine form.
fn rows(runner: &Runner, sweep: &Sweep, judged: &[Option<Counters>]) -> Vec<Value> {
    let row = |(index, ((place, cell), counters)): (usize, ((&Place, &Cell), &Option<Counters>))| {
        let more = json!({
            "assignment_ns_per_light": per_light(place, cell),
            "assignment_over_65536": over_base(sweep, index),
            "counters": counters,
        });
        joined(&joined(&place.facts, &more), &cell.json(runner))
    };
    sweep.cells().zip(judged).enumerate().map(row).collect()
}
