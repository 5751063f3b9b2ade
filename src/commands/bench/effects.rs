//! `effects`: what each effect costs where nothing calls for it. It is forced on a scene with input that changes nothing, beside the same scene without
//! it: the difference is what leaving it out saves.

use serde_json::json;

use super::cell::{Cell, digits};
use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Place, Shown, Sweep};
use crate::error::{Error, Result};
use crate::measure::html::Table;
use crate::measure::plot::{self, Scale};
use crate::plan::overrides::{EffectName, apply};
use crate::plan::profile::Forced;
use crate::plan::{Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::Scene;

const LIGHTS: u32 = 64;

/// Metres.
const RANGE: f64 = 4.0;

const TECHNIQUES: [Technique; 3] = [Technique::Forward, Technique::TiledForward, Technique::TiledDeferred];

/// Every effect but those of lists, which a technique has or has not.
const EFFECTS: [EffectName; 8] = [
    EffectName::Prepass,
    EffectName::Transparency,
    EffectName::AlphaMask,
    EffectName::NormalMaps,
    EffectName::Parallax,
    EffectName::MaterialModels,
    EffectName::Msaa,
    EffectName::Shadows,
];

/// The scene and the request with one effect forbidden, or forced.
fn overridden(scene: &Scene, request: &Request, effect: EffectName, force: bool) -> Result<(Scene, Request)> {
    let (mut scene, mut request) = (scene.clone(), request.clone());
    let effects = [effect];
    let (forced, forbidden): (&[EffectName], &[EffectName]) = if force { (&effects, &[]) } else { (&[], &effects) };
    apply(&mut scene, &mut request, forced, forbidden)?;
    Ok((scene, request))
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
    let mut session = runner.session("effects", EFFECTS.len() * TECHNIQUES.len() * 2);
    let mut sweep = Sweep::new("effect");
    for (index, effect) in EFFECTS.into_iter().enumerate() {
        let mut measured: Vec<(Scene, Case)> = Vec::new();
        for technique in TECHNIQUES {
            for (word, force) in [("left out", false), ("forced", true)] {
                let (scene, request) =
                    overridden(&loaded.scene, &Request { technique, ..Request::default() }, effect, force)?;
                let sized = runner.sized(vec![(format!("{}, {word}", technique.name()), request)], size, range);
                measured.extend(sized.into_iter().map(|case| (scene.clone(), case)));
            }
        }
        let cases: Vec<_> = measured.iter().map(|(scene, case)| (scene, case)).collect();
        let cells = session.group_of_scenes(&cases, None)?;
        let facts = json!({ "effect": effect.name(), "lights": count, "light_range": range });
        sweep.places.push(Place { name: effect.name().into(), x: index as f64, facts, cells });
    }
    drop(session);
    let about = About {
        name: "effects",
        title: format!("effects: {}, {count} lights at {}x{}", loaded.spec, size.0, size.1),
        lights: format!("lights of range {} m", plot::number(range)),
        size,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.bars(runner, &about.title, (Shown::Milliseconds, Scale::Linear));
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, vec![figure]);
    outcome.section.tables.push(saved(runner, &sweep));
    Ok(outcome)
}

/// A row an effect: what leaving it out saves, by technique and device.
fn saved(runner: &Runner, sweep: &Sweep) -> Table {
    let devices = runner.renderers.len();
    let pairs = |place: &Place| -> Vec<[usize; 2]> {
        let cases = place.cells.len() / devices;
        (0..cases / 2)
            .flat_map(|t| (0..devices).map(move |d| [2 * t * devices + d, (2 * t + 1) * devices + d]))
            .collect()
    };
    let mut header = vec!["saved by leaving it out".to_string()];
    if let Some(place) = sweep.places.first() {
        for [out, _] in pairs(place) {
            let name = runner.name_of(&place.cells[out]).replace(", left out", "");
            header.extend([format!("{name} (ms)"), format!("{name} (MiB)")]);
        }
    }
    let row = |place: &Place| {
        let of = |[out, forced]: [usize; 2]| {
            let (out, forced): (&Cell, &Cell) = (&place.cells[out], &place.cells[forced]);
            let ms = out.spread().zip(forced.spread()).map_or("-".into(), |(a, b)| digits(b.median - a.median));
            let bytes = (forced.device_bytes as f64 - out.device_bytes as f64) / f64::from(1 << 20);
            [ms, digits(bytes)]
        };
        std::iter::once(place.name.clone()).chain(pairs(place).into_iter().flat_map(of)).collect()
    };
    Table { caption: "Saved against forced, medians".into(), header, rows: sweep.places.iter().map(row).collect() }
}

/// What each effect costs a pixel of `request`, forced beside the same without it, in turns.
///
/// # Errors
/// A lost device.
pub(super) fn forced_costs(renderer: &Renderer, scene: &Scene, request: &Request, frames: usize) -> Result<Forced> {
    let cost = |effect: EffectName| -> Result<f64> {
        let prepare = |force: bool| {
            let (scene, request) = overridden(scene, request, effect, force)?;
            let plan = Plan::new(&scene, &request, &renderer.limits())?;
            let mut prepared = renderer.prepare(&scene, &plan)?;
            prepared.draw(1)?;
            Ok::<_, Error>(prepared)
        };
        let mut both = [prepare(false)?, prepare(true)?];
        let mut walls = [Vec::new(), Vec::new()];
        for _ in 0..frames {
            for (prepared, walls) in both.iter_mut().zip(&mut walls) {
                walls.push(prepared.draw(1)?.frame().median);
            }
        }
        let [out, forced] = walls.map(|walls| crate::measure::times::Spread::of(&walls).median);
        Ok((forced - out) * 1e6 / (f64::from(request.width) * f64::from(request.height)))
    };
    Ok(Forced {
        prepass: cost(EffectName::Prepass)?,
        transparency: cost(EffectName::Transparency)?,
        alpha_mask: cost(EffectName::AlphaMask)?,
        normal_maps: cost(EffectName::NormalMaps)?,
        parallax: cost(EffectName::Parallax)?,
        material_models: cost(EffectName::MaterialModels)?,
        msaa: cost(EffectName::Msaa)?,
        shadows: cost(EffectName::Shadows)?,
    })
}
