//! `lights`: every technique over the number of lights, whose range stays.

use super::cell::{Cell, digits};
use super::output::{About, Outcome};
use super::run::{Runner, auto, contenders};
use super::sweep::{Place, Shown, Sweep, log_axis};
use crate::error::Result;
use crate::measure::plot::{self, Scale};

const COUNTS: [u32; 7] = [16, 64, 256, 1024, 4096, 16_384, 65_536];
const QUICK_COUNTS: [u32; 3] = [16, 256, 4096];

/// Metres.
const RANGE: f64 = 1.0;

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (size, range) = (runner.size((1280, 720), (640, 360)), runner.range(RANGE));
    let counts = runner.counts(&COUNTS, &QUICK_COUNTS);
    let cases = contenders().into_iter().chain([auto()]).collect();
    let cases = runner.sized(cases, size, range);
    let sweep = Sweep::over_lights(runner, "lights", &mut loaded, &cases, (&counts, range))?;
    let about = About {
        name: "lights",
        title: format!("lights: {} at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.plot(runner, &about.title, log_axis("lights"), (Shown::Milliseconds, Scale::Log));
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, vec![figure]);
    let how = std::mem::replace(&mut outcome.section.paragraphs, gains(runner, &sweep));
    outcome.section.paragraphs.extend(how);
    Ok(outcome)
}

/// Of each device, how many times longer a full-screen loop over all lights takes than tiles do, and what `auto` takes over the best, as
/// far as both were measured.
fn gains(runner: &Runner, sweep: &Sweep) -> Vec<String> {
    let median = |place: &Place, device: usize, case: &str| {
        let cell = place.cells.iter().find(|cell| cell.device == device && cell.case == case);
        cell.and_then(Cell::spread).map(|spread| spread.median)
    };
    let ratio = |place: &Place, device: usize| {
        let (all, tiles) = (median(place, device, "deferred, fullscreen")?, median(place, device, "tiled-deferred")?);
        Some(format!("{} at {}", digits(all / tiles), place.name))
    };
    let chosen = |place: &Place, device: usize| {
        let own = place.cells.iter().find(|cell| cell.device == device && cell.case == "auto")?;
        let others = place.cells.iter().filter(|cell| cell.device == device && cell.case != "auto");
        let best = others.filter_map(|cell| cell.spread()).map(|spread| spread.median).fold(f64::INFINITY, f64::min);
        let ratio = own.spread()?.median / best;
        best.is_finite().then(|| format!("{ratio:.2} at {} ({})", place.name, own.technique.unwrap_or("-")))
    };
    let auto_line = |device: usize| {
        let ratios: Vec<String> = sweep.places.iter().filter_map(|place| chosen(place, device)).collect();
        let name = &runner.renderers[device].device().facts.name;
        let said = format!("Frame of auto over the best of the others ({name}): {}.", ratios.join(", "));
        (!ratios.is_empty()).then_some(said)
    };
    let line = |device: usize| {
        let ratios: Vec<String> = sweep.places.iter().filter_map(|place| ratio(place, device)).collect();
        let name = &runner.renderers[device].device().facts.name;
        let said =
            format!("Frame of deferred, fullscreen over that of tiled-deferred ({name}): {}.", ratios.join(", "));
        (!ratios.is_empty()).then_some(said)
    };
    (0..runner.renderers.len()).flat_map(|device| [line(device), auto_line(device)]).flatten().collect()
}
