//! Knobs of bounced light: bakes of the scene that they are turned on, and their settings.

use std::sync::Arc;

use super::knobs::Setting;
use crate::cli::KnobName;
use crate::error::Result;
use crate::plan::{Gathering, Gi, Iteration, MatrixPath, Request, ShadowUpdate};
use crate::radiosity::Exchange;
use crate::radiosity::bake::{Bake, CodecName, PatchRule, Settings};
use crate::scene::Scene;
use crate::scene::lighting::LightRules;

/// Patches where their number is not the knob, and of a quick run.
const PATCHES: [usize; 2] = [1000, 200];
/// Numbers of patches, and of a quick run.
const COUNTS: [&[usize]; 2] = [&[1000, 125, 250, 500, 2000], &[200, 50, 100]];

/// Gathers of bounced light.
const GATHERS: [u32; 6] = [1, 2, 3, 4, 6, 8];
/// The default comes first.
const TOLERANCES: [f64; 5] = [Gathering::TOLERANCE, 0.1, 0.03, 0.001, 0.0001];

/// The knob is one of bounced light: it is turned where it is asked for.
pub(super) fn is_of_bounces(name: KnobName) -> bool {
    matches!(name, KnobName::GiPatches | KnobName::GiCodec) || turns_one_bake(name)
}

/// The knob is turned on one bake.
fn turns_one_bake(name: KnobName) -> bool {
    matches!(name, KnobName::GiGathers | KnobName::GiTolerance | KnobName::GiIteration | KnobName::GiPath)
}

/// As many as the knob needs, the one of the defaults first.
///
/// # Errors
/// A scene that cannot be baked.
pub(super) fn of_knob(name: KnobName, scene: &Scene, quick: bool) -> Result<Vec<Arc<Bake>>> {
    let pick = usize::from(quick);
    let of = |count: usize| {
        let settings = Settings { patches: PatchRule::Count(count), ..Settings::default() };
        Bake::of_scene(scene, settings).map(Arc::new)
    };
    match name {
        name if turns_one_bake(name) => Ok(vec![of(PATCHES[pick])?]),
        KnobName::GiPatches => COUNTS[pick].iter().map(|count| of(*count)).collect(),
        KnobName::GiCodec => {
            let exchange = Exchange::of_scene(scene, &Settings::of_count(PATCHES[pick]))?;
            // The default comes last in the list of all.
            let codecs = CodecName::ALL.into_iter().rev();
            codecs.map(|codec| Bake::new(exchange.clone(), Settings::of_codec(codec)).map(Arc::new)).collect()
        }
        _ => Ok(Vec::new()),
    }
}

/// Light is gathered in every frame, so that its time is seen.
fn bounced(base: &Request, bake: &Arc<Bake>, gathers: Option<u32>) -> Request {
    let gathering = Gathering { gathers, ..Gathering::default() };
    Request {
        gi: Gi::Radiosity(gathering),
        bake: Some(Arc::clone(bake)),
        shadow_update: ShadowUpdate::Frame,
        rules: LightRules { emission_lights: true, ..base.rules.clone() },
        ..base.clone()
    }
}

/// As many as the tolerance needs, and given numbers.
pub(super) fn gathers(base: &Request, bakes: &[Arc<Bake>]) -> Vec<Setting> {
    let Some(bake) = bakes.first() else { return Vec::new() };
    let auto = ("auto".to_string(), bounced(base, bake, None));
    std::iter::once(auto).chain(GATHERS.map(|n| (n.to_string(), bounced(base, bake, Some(n))))).collect()
}

fn gathering(base: &Request, bakes: &[Arc<Bake>], ways: Vec<(String, Gathering)>) -> Vec<Setting> {
    let Some(bake) = bakes.first() else { return Vec::new() };
    let of = |(name, gathering)| (name, Request { gi: Gi::Radiosity(gathering), ..bounced(base, bake, None) });
    ways.into_iter().map(of).collect()
}

/// Shares of light that may be left out.
pub(super) fn tolerances(base: &Request, bakes: &[Arc<Bake>]) -> Vec<Setting> {
    let of = |tolerance: f64| (tolerance.to_string(), Gathering { tolerance, ..Gathering::default() });
    gathering(base, bakes, TOLERANCES.map(of).to_vec())
}

/// Each with as many gathers as the tolerance needs.
pub(super) fn iterations(base: &Request, bakes: &[Arc<Bake>]) -> Vec<Setting> {
    let of = |iteration: Iteration| (iteration.name().to_string(), Gathering { iteration, ..Gathering::default() });
    gathering(base, bakes, [Iteration::Chebyshev, Iteration::Neumann].map(of).to_vec())
}

/// What the matrix is read from.
pub(super) fn paths(base: &Request, bakes: &[Arc<Bake>]) -> Vec<Setting> {
    let of = |path: MatrixPath| (path.name().to_string(), Gathering { path, ..Gathering::default() });
    gathering(base, bakes, [MatrixPath::Texel, MatrixPath::Buffer].map(of).to_vec())
}

/// One a bake, named by what differs.
pub(super) fn of_bakes(base: &Request, bakes: &[Arc<Bake>], name: impl Fn(&Bake) -> String) -> Vec<Setting> {
    bakes.iter().map(|bake| (name(bake), bounced(base, bake, None))).collect()
}
