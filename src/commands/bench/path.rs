//! `path`: frames a second along a camera path. Each pose is planned and prepared anew; that is timed beside, not within, the frames.

use serde_json::json;

use super::cell::digits;
use super::keys::Pose;
use super::output::{About, Outcome};
use super::run::{Case, Runner, culling_contenders};
use super::sweep::{Place, Shown, Sweep};
use crate::error::Result;
use crate::measure::html::Table;
use crate::measure::plot::{self, Axis, Scale};
use crate::measure::times::Spread;
use crate::plan::{CameraChoice, Request};

const LIGHTS: u32 = 1024;

/// Metres.
const RANGE: f64 = 1.0;

/// Most frames of a pose: neighbours are measurements of nearly the same.
const ROUNDS: u32 = 3;

/// Poses from one that is drawn to the next, and those of a quick run.
const STEPS: [usize; 2] = [1, 5];

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (count, range) = (runner.count(LIGHTS), runner.range(RANGE));
    let size = runner.size((640, 360), (320, 180));
    runner.light(&mut loaded, count)?;
    let poses: Vec<&Pose> = runner.path.poses.iter().step_by(runner.either(STEPS[0], STEPS[1])).collect();
    let cases = runner.sized(culling_contenders(), size, range);
    let mut session = runner.session("path", poses.len() * cases.len());
    session.rounds = session.rounds.min(ROUNDS);
    let rounds = session.rounds;
    let mut sweep = Sweep::new("time (s)");
    for pose in poses {
        let camera = CameraChoice::LookAt(pose.from, pose.at, pose.fov.to_radians());
        let with_camera =
            |(name, request): &Case| (name.clone(), Request { camera: camera.clone(), ..request.clone() });
        let cases: Vec<Case> = cases.iter().map(with_camera).collect();
        // Poses are alike: where one is too slow, the others are not waited for.
        let cells = session.group(&loaded.scene, &cases, Some(1.0))?;
        let (from, at) = (pose.from.to_array(), pose.at.to_array());
        let facts = json!({
            "time": pose.time, "from": from, "at": at, "fov": pose.fov, "lights": count, "light_range": range,
        });
        sweep.places.push(Place { name: plot::number(pose.time), x: pose.time, facts, cells });
    }
    drop(session);
    let about = About {
        name: "path",
        title: format!("path: {}, {count} lights at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let how = runner.how(&about.lights, rounds);
    let time = Axis { label: "time (s)".into(), scale: Scale::Linear };
    let figure = sweep.plot(runner, &about.title, time, (Shown::FramesPerSecond, Scale::Linear));
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, vec![figure]);
    outcome.notes.clear();
    outcome.section.tables =
        vec![sweep.turned(runner, Shown::FramesPerSecond, &mut outcome.notes), summary(runner, &sweep)];
    outcome.section.paragraphs =
        vec![format!("Camera path {}; each pose is planned and prepared anew.", runner.path.name), how];
    Ok(outcome)
}

/// A row a case, over all poses.
fn summary(runner: &Runner, sweep: &Sweep) -> Table {
    let header = ["case", "least frames/s", "median", "most", "plan (ms)", "prepare (ms)"];
    let row = |(index, name): (usize, String)| {
        let cells: Vec<_> = sweep.places.iter().map(|place| &place.cells[index]).collect();
        let rates: Vec<f64> = cells.iter().filter_map(|cell| cell.spread()).map(|ms| 1e3 / ms.median).collect();
        let rate = Spread::of(&rates);
        let rates = if rates.is_empty() {
            vec!["-".to_string(); 3]
        } else {
            [rate.min, rate.median, rate.max].map(digits).to_vec()
        };
        let plan = Spread::of(&cells.iter().map(|cell| cell.plan_ms).collect::<Vec<_>>()).median;
        let prepare = Spread::of(&cells.iter().map(|cell| cell.prepare_ms).collect::<Vec<_>>()).median;
        [vec![name], rates, vec![digits(plan), digits(prepare)]].concat()
    };
    Table {
        caption: "Over the path".into(),
        header: header.map(String::from).to_vec(),
        rows: sweep.names(runner).into_iter().enumerate().map(row).collect(),
    }
}
