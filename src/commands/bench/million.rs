//! `million`: from thousands of lights to a million, whose range shrinks so that as many reach each pixel.

use serde_json::json;

use super::cell::{Cell, digits};
use super::output::{About, Outcome};
use super::run::{Runner, culling_contenders};
use super::sweep::{Place, Shown, Sweep, joined, log_axis};
use crate::commands::report;
use crate::error::Result;
use crate::measure::html::Table;
use crate::measure::plot::{self, Scale};

const COUNTS: [u32; 5] = [4096, 16_384, 65_536, 262_144, 1_000_000];
const QUICK_COUNTS: [u32; 2] = [4096, 65_536];

/// Metres at [`COUNTS`]' first.
const RANGE: f64 = 10.0;

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:terrain")?;
    let counts = runner.counts(&COUNTS, &QUICK_COUNTS);
    let (size, range) = (runner.size((320, 180), (320, 180)), runner.range(RANGE));
    let mut session = runner.session("million", counts.len() * culling_contenders().len());
    let mut sweep = Sweep::new("lights");
    for count in counts {
        runner.light(&mut loaded, count)?;
        // Lights of a volume and the volume of a light: their product stays.
        let range = range * (f64::from(COUNTS[0]) / f64::from(count)).cbrt();
        let cases = runner.sized(culling_contenders(), size, range);
        let cells = session.group(&loaded.scene, &cases, Some(f64::from(count)))?;
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
    outcome.section.tables.push(assignment(runner, &sweep));
    let more = |place: &Place, cell: &Cell| json!({ "assignment_ns_per_light": per_light(place, cell) });
    let row = |(place, cell): (&Place, &Cell)| joined(&joined(&place.facts, &more(place, cell)), &cell.json(runner));
    outcome.rows = sweep.cells().map(row).collect();
    Ok(outcome)
}

/// Nanoseconds of list building a light.
fn per_light(place: &Place, cell: &Cell) -> Option<f64> {
    cell.stages().map(|[_, _, lists, _]| lists * 1e6 / place.x)
}

fn assignment(runner: &Runner, sweep: &Sweep) -> Table {
    let header = ["lights", "case", "range (m)", "lists (ms)", "ns a light", "lists at most"];
    let row = |(place, cell): (&Place, &Cell)| {
        let optional = |value: Option<f64>| value.map_or("-".into(), digits);
        let range = place.facts["light_range"].as_f64().map_or("-".into(), plot::number);
        vec![
            place.name.clone(),
            runner.name_of(cell),
            range,
            optional(cell.stages().map(|ms| ms[2])),
            optional(per_light(place, cell)),
            report::bytes(cell.list_bytes),
        ]
    };
    Table {
        caption: "Assignment of lights, medians".into(),
        header: header.map(String::from).to_vec(),
        rows: sweep.cells().map(row).collect(),
    }
}
