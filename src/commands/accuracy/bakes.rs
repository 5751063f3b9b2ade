//! What knobs of bounced light are turned on: bakes of the scene.

use std::sync::Arc;

use crate::cli::KnobName;
use crate::error::Result;
use crate::radiosity::Exchange;
use crate::radiosity::bake::{Bake, CodecName, PatchRule, Settings};
use crate::scene::Scene;

/// Patches where their number is not the knob, and of a quick run.
const PATCHES: [usize; 2] = [1000, 200];
/// Numbers of patches, and of a quick run.
const COUNTS: [&[usize]; 2] = [&[1000, 125, 250, 500, 2000], &[200, 50, 100]];

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
