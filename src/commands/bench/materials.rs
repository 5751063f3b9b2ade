//! `materials`: each shading model on every material of the scene, and all of them side by side, in techniques with a pipeline a model and
//! in techniques with one branch.

use serde_json::json;

use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Place, Shown, Sweep};
use crate::error::Result;
use crate::measure::plot::{self, Scale};
use crate::plan::{Request, Technique};
use crate::scene::Scene;
use crate::scene::shading::{Model, OwnModel};

const LIGHTS: u32 = 256;

/// Metres.
const RANGE: f64 = 4.0;

const TECHNIQUES: [Technique; 4] =
    [Technique::Forward, Technique::TiledForward, Technique::TiledDeferred, Technique::ClusteredDeferred];

fn cases() -> Vec<Case> {
    let of = |technique: Technique| (technique.name().to_string(), Request { technique, ..Request::default() });
    TECHNIQUES.map(of).to_vec()
}

/// Gives each material one of the models, in turns.
fn paint(scene: &mut Scene, models: &[Model]) {
    for (material, &model) in scene.materials.iter_mut().zip(models.iter().cycle()) {
        material.model = Some(OwnModel { model, color: [0.2, 0.3, 0.7], exponent: 2.0 });
    }
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
    let alone = Model::ALL.map(|model| (model.name(), vec![model]));
    let places: Vec<_> = alone.into_iter().chain([("all, mixed", Model::ALL.to_vec())]).collect();
    let cases = runner.sized(cases(), size, range);
    let mut session = runner.session("materials", places.len() * cases.len());
    let mut sweep = Sweep::new("model");
    for (index, (name, models)) in places.into_iter().enumerate() {
        paint(&mut loaded.scene, &models);
        let cells = session.group(&loaded.scene, &cases, None)?;
        let facts = json!({ "model": name, "lights": count, "light_range": range });
        sweep.places.push(Place { name: name.into(), x: index as f64, facts, cells });
    }
    drop(session);
    let about = About {
        name: "materials",
        title: format!("materials: {}, {count} lights at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.bars(runner, &about.title, (Shown::Milliseconds, Scale::Linear));
    Ok(Outcome::of_sweep(runner, &sweep, about, vec![figure]))
}
