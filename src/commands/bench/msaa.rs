//! `msaa`: time and memory by samples a pixel, for forward and deferred techniques, and the cost of the depth reduction (Billeter, Olsson,
//! Assarsson, "Tiled Forward Shading", GPU Pro 4, 2013, figure 4.4).

use serde_json::json;

use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Place, Shown, Sweep, log_axis};
use crate::error::Result;
use crate::measure::html::Table;
use crate::measure::plot::{self, Scale};
use crate::plan::{Request, Technique};

const LIGHTS: u32 = 1024;

/// Metres.
const RANGE: f64 = 1.0;

const TECHNIQUES: [Technique; 6] = [
    Technique::Forward,
    Technique::TiledForward,
    Technique::ClusteredForward,
    Technique::Deferred,
    Technique::TiledDeferred,
    Technique::ClusteredDeferred,
];

fn cases(msaa: u32) -> Vec<Case> {
    let of = |technique: Technique| {
        let request = Request { technique, msaa, strict: true, ..Request::default() };
        (technique.name().to_string(), request)
    };
    TECHNIQUES.map(of).to_vec()
}

/// Numbers of samples that any of the devices has in both kinds of pictures.
fn counts(runner: &Runner) -> Vec<u32> {
    let granted = runner.renderers.iter().fold(0, |bits, renderer| {
        let [lit, stored] = renderer.limits().samples;
        bits | lit | stored
    });
    crate::plan::samples::COUNTS.into_iter().filter(|count| granted & count != 0).collect()
}

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (count, range) = (runner.count(LIGHTS), runner.range(RANGE));
    let size = runner.size((960, 540), (480, 270));
    runner.light(&mut loaded, count)?;
    let counts = counts(runner);
    let mut session = runner.session("msaa", counts.len() * TECHNIQUES.len());
    let mut sweep = Sweep::new("samples");
    for &samples in &counts {
        let cases = runner.sized(cases(samples), size, range);
        let cells = session.group(&loaded.scene, &cases, None)?;
        let facts = json!({ "samples": samples, "lights": count, "light_range": range });
        sweep.places.push(Place { name: samples.to_string(), x: f64::from(samples), facts, cells });
    }
    drop(session);
    let about = About {
        name: "msaa",
        title: format!("msaa: {}, {count} lights at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.plot(runner, &about.title, log_axis("samples a pixel"), (Shown::Milliseconds, Scale::Linear));
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, vec![figure]);
    outcome.section.tables.push(of_cells(runner, &sweep, "depth reduction (ms), medians", |cell| {
        cell.stages().filter(|stages| stages[1] > 0.0).map_or("-".into(), |stages| super::cell::digits(stages[1]))
    }));
    outcome.section.tables.push(of_cells(runner, &sweep, "device memory (MiB)", |cell| match cell.device_bytes {
        0 => "-".into(),
        bytes => super::cell::digits(bytes as f64 / f64::from(1 << 20)),
    }));
    Ok(outcome)
}

/// A row a case, a column a number of samples.
fn of_cells(runner: &Runner, sweep: &Sweep, caption: &str, text: impl Fn(&super::cell::Cell) -> String) -> Table {
    let header = std::iter::once("samples".to_string()).chain(sweep.places.iter().map(|place| place.name.clone()));
    let names = sweep.names(runner);
    let row = |(index, name): (usize, &String)| {
        let cells = sweep.places.iter().map(|place| text(&place.cells[index]));
        std::iter::once(name.clone()).chain(cells).collect()
    };
    let rows = names.iter().enumerate().map(row).collect();
    Table { caption: caption.into(), header: header.collect(), rows }
}
