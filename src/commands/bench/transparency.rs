//! `transparency`: panes of glass behind each other, by what the light lists of blended surfaces know of depths (Billeter, Olsson,
//! Assarsson, "Tiled Forward Shading", GPU Pro 4, 2013: bounds of their own won some 7 %).

use serde_json::json;

use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Place, Shown, Sweep, log_axis};
use crate::error::Result;
use crate::measure::plot::{self, Scale};
use crate::plan::{Request, Technique, TransparentBounds};

const LIGHTS: u32 = 1024;

/// Metres.
const RANGE: f64 = 2.0;

/// Panes.
const LAYERS: &[u32] = &[2, 8, 24];
const QUICK_LAYERS: &[u32] = &[8];

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for technique in [Technique::TiledForward, Technique::TiledDeferred, Technique::ClusteredForward] {
        for bounds in TransparentBounds::ALL {
            if technique.clusters() && bounds == TransparentBounds::Merged {
                continue;
            }
            let request = Request { technique, transparent_bounds: Some(bounds), ..Request::default() };
            cases.push((format!("{}, {}", technique.name(), bounds.name()), request));
        }
    }
    cases.push(("forward".into(), Request { technique: Technique::Forward, ..Request::default() }));
    cases
}

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let (count, range) = (runner.count(LIGHTS), runner.range(RANGE));
    let size = runner.size((960, 540), (480, 270));
    // A scene that was asked for has its own surfaces.
    let layers = if runner.args.scene.is_some() { &LAYERS[..1] } else { runner.either(LAYERS, QUICK_LAYERS) };
    let cases = runner.sized(cases(), size, range);
    let mut session = runner.session("transparency", layers.len() * cases.len());
    let mut sweep = Sweep::new("panes");
    let mut scenes = Vec::new();
    for &panes in layers {
        let mut loaded = runner.load(&format!("builtin:glass:layers={panes}"))?;
        runner.light(&mut loaded, count)?;
        let cells = session.group(&loaded.scene, &cases, None)?;
        let facts = json!({ "panes": panes, "lights": count, "light_range": range });
        sweep.places.push(Place { name: panes.to_string(), x: f64::from(panes), facts, cells });
        scenes.push(loaded.facts);
    }
    drop(session);
    let about = About {
        name: "transparency",
        title: format!("transparency: panes of glass, {count} lights at {}x{}", size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes,
    };
    let figure = sweep.plot(runner, &about.title, log_axis("panes"), (Shown::Milliseconds, Scale::Linear));
    Ok(Outcome::of_sweep(runner, &sweep, about, vec![figure]))
}
