//! `prepass`: tiled forward shading without a depth pre-pass, with one, and with one from which tiles know their nearest and farthest
//! depth (Billeter, Olsson, Assarsson, "Tiled Forward Shading", GPU Pro 4, 2013).

use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Shown, Sweep, log_axis};
use crate::error::Result;
use crate::measure::plot::{self, Scale};
use crate::plan::{DepthBounds, Request, Technique};

const COUNTS: [u32; 4] = [64, 256, 1024, 4096];
const QUICK_COUNTS: [u32; 2] = [256, 4096];

/// Metres.
const RANGE: f64 = 1.0;

fn variants() -> Vec<Case> {
    let base = Request { technique: Technique::TiledForward, ..Request::default() };
    let bounds = |bounds| Request { depth_bounds: Some(bounds), ..base.clone() };
    vec![
        ("no pre-Z".into(), Request { prepass: false, ..base.clone() }),
        ("pre-Z".into(), bounds(DepthBounds::Off)),
        ("pre-Z + bounds".into(), bounds(DepthBounds::MinMax)),
    ]
}

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (size, range) = (runner.size((1280, 720), (640, 360)), runner.range(RANGE));
    let counts = runner.counts(&COUNTS, &QUICK_COUNTS);
    let cases = runner.sized(variants(), size, range);
    let sweep = Sweep::over_lights(runner, "prepass", &mut loaded, &cases, (&counts, range))?;
    let about = About {
        name: "prepass",
        title: format!("prepass: tiled-forward, {} at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.plot(runner, &about.title, log_axis("lights"), (Shown::Milliseconds, Scale::Linear));
    Ok(Outcome::of_sweep(runner, &sweep, about, vec![figure]))
}
