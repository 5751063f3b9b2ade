//! `views`: every technique seen by a person, with depths from near to far in one tile, and from above, with hardly any.

use std::f64::consts::FRAC_PI_3;

use glam::DVec3;
use serde_json::json;

use super::output::{About, Outcome};
use super::run::{Case, Loaded, Runner, contenders};
use super::sweep::{Place, Shown, Sweep};
use crate::error::Result;
use crate::measure::plot::{self, Scale};
use crate::plan::{CameraChoice, Request};
use crate::scene::Scene;

const LIGHTS: u32 = 1024;

/// Name that scenes of this program give to their camera from above.
const ABOVE: &str = "top-down";

/// Scene, whether it is seen from above, and range of its lights in metres: as many of them reach an average point of the country as
/// of the court.
const VIEWS: &[(&str, bool, f64)] =
    &[("builtin:atrium", false, 1.0), ("builtin:atrium", true, 1.0), ("builtin:terrain", true, 7.0)];

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let (count, size) = (runner.count(LIGHTS), runner.size((960, 540), (480, 270)));
    // A scene that was asked for takes the place of both.
    let asked = runner.args.scene.is_some();
    let views = if asked { &VIEWS[..2] } else { VIEWS };
    let mut session = runner.session("views", views.len() * contenders().len());
    let mut sweep = Sweep::new("view");
    let mut scenes: Vec<(&str, Loaded)> = Vec::new();
    let mut ranges = Vec::new();
    for (index, &(own, above, range)) in views.iter().enumerate() {
        if !scenes.iter().any(|known| asked || known.0 == own) {
            let mut loaded = runner.load(own)?;
            runner.light(&mut loaded, count)?;
            scenes.push((own, loaded));
        }
        let Some((_, loaded)) = scenes.last() else { continue };
        let range = runner.range(range);
        let camera = if above { from_above(&loaded.scene, size) } else { CameraChoice::Default };
        let with_camera = |(name, request): Case| (name, Request { camera: camera.clone(), ..request });
        let cases: Vec<Case> = runner.sized(contenders(), size, range).into_iter().map(with_camera).collect();
        let cells = session.group(&loaded.scene, &cases, None)?;
        let view = if above { "from above" } else { "first person" };
        let name = format!("{}, {view}", loaded.spec.trim_start_matches("builtin:"));
        let facts = json!({ "view": view, "scene": loaded.spec, "lights": count, "light_range": range });
        ranges.push(format!("{} m ({name})", plot::number(range)));
        sweep.places.push(Place { name, x: index as f64, facts, cells });
    }
    drop(session);
    let about = About {
        name: "views",
        title: format!("views: {count} lights at {}x{}", size.0, size.1),
        lights: format!("lights of range {}", ranges.join(", ")),
        size,
        scenes: scenes.into_iter().map(|(_, loaded)| loaded.facts).collect(),
    };
    let figure = sweep.bars(runner, &about.title, (Shown::Milliseconds, Scale::Linear));
    Ok(Outcome::of_sweep(runner, &sweep, about, vec![figure]))
}

/// The scene's own camera of that name, else one above the middle from which the whole scene is seen.
fn from_above(scene: &Scene, size: (u32, u32)) -> CameraChoice {
    if scene.cameras.iter().any(|camera| camera.name == ABOVE) {
        return CameraChoice::Named(ABOVE.into());
    }
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return CameraChoice::Default;
    }
    let half = (bounds.max - bounds.min) * 0.5;
    let (center, tangent) = (bounds.center(), (FRAC_PI_3 * 0.5).tan());
    let aspect = f64::from(size.0) / f64::from(size.1);
    let height = (half.z / tangent).max(half.x / (tangent * aspect)).max(1.0);
    let eye = DVec3::new(center.x, bounds.max.y + height, center.z);
    CameraChoice::LookAt(eye, center, FRAC_PI_3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn scenes_without_a_camera_from_above_get_one_that_sees_them_whole() {
        let scene = builtin::load("cornell").expect("a scene");
        let CameraChoice::LookAt(eye, at, fov) = from_above(&scene, (160, 90)) else { panic!("a camera of its own") };
        let bounds = scene.bounds();
        assert!(eye.x == at.x && eye.z == at.z && eye.y > bounds.max.y);
        let reach = (eye.y - bounds.max.y) * (fov * 0.5).tan() * (1.0 + 1e-9);
        assert!(reach >= bounds.max.z - at.z && reach * 160.0 / 90.0 >= bounds.max.x - at.x);
        let atrium = builtin::load("atrium").expect("a scene");
        assert_eq!(from_above(&atrium, (160, 90)), CameraChoice::Named("top-down".into()));
    }
}
