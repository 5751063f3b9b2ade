//! `--force` and `--forbid`: effects that run, or do not, whatever calls for them. What materials call for is changed in the scene, before it is
//! planned; what the picture asks for, in the request.

use super::request::{DepthBounds, Technique};
use super::{Effect, Request};
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::scene::overrides::MaterialEffect;

/// Effects that can be overridden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectName {
    /// Depth before shading.
    Prepass,
    /// Depth bounds of tiles.
    DepthBounds,
    /// Blended surfaces.
    Transparency,
    /// Masks.
    AlphaMask,
    /// Normal maps.
    NormalMaps,
    /// Height maps.
    Parallax,
    /// Shading models of materials.
    MaterialModels,
    /// Several samples a pixel.
    Msaa,
}

impl EffectName {
    /// Every name.
    pub const ALL: [Self; 8] = [
        Self::Prepass,
        Self::DepthBounds,
        Self::Transparency,
        Self::AlphaMask,
        Self::NormalMaps,
        Self::Parallax,
        Self::MaterialModels,
        Self::Msaa,
    ];

    /// As typed, and as the JSON names the effect.
    pub fn name(self) -> &'static str {
        match self {
            Self::Prepass => "prepass",
            Self::DepthBounds => "depth_bounds",
            Self::Transparency => "transparency",
            Self::AlphaMask => "alpha_mask",
            Self::NormalMaps => "normal_maps",
            Self::Parallax => "parallax",
            Self::MaterialModels => "material_models",
            Self::Msaa => "msaa",
        }
    }

    fn of_materials(self) -> Option<MaterialEffect> {
        match self {
            Self::Transparency => Some(MaterialEffect::Transparency),
            Self::AlphaMask => Some(MaterialEffect::AlphaMask),
            Self::NormalMaps => Some(MaterialEffect::NormalMaps),
            Self::Parallax => Some(MaterialEffect::Parallax),
            Self::MaterialModels => Some(MaterialEffect::MaterialModels),
            Self::Prepass | Self::DepthBounds | Self::Msaa => None,
        }
    }
}

/// What an override did, for the plan to say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Of which effect.
    pub effect: EffectName,
    /// Forced, else forbidden.
    pub forced: bool,
    /// Materials that it changed.
    pub materials: usize,
}

/// Carries out overrides on a scene and the request for its picture; [`Request::overrides`] says afterwards what they did.
///
/// # Errors
/// An effect both forced and forbidden, one that has nothing neutral to be forced with, or one that the technique cannot have.
pub fn apply(scene: &mut Scene, request: &mut Request, force: &[EffectName], forbid: &[EffectName]) -> Result<()> {
    if let Some(both) = force.iter().find(|effect| forbid.contains(effect)) {
        return Err(Error::usage(format!("{} is both forced and forbidden", both.name())));
    }
    for (effects, forced) in [(forbid, false), (force, true)] {
        for &effect in effects {
            if request.overrides.iter().any(|known| known.effect == effect) {
                continue;
            }
            let materials = match (effect.of_materials(), forced) {
                (Some(of_materials), false) => scene.forbid(of_materials),
                (Some(of_materials), true) => scene.force(of_materials, request.shading.into()),
                (None, _) => {
                    override_request(request, effect, forced)?;
                    0
                }
            };
            request.overrides.push(Override { effect, forced, materials });
        }
    }
    Ok(())
}

fn override_request(request: &mut Request, effect: EffectName, forced: bool) -> Result<()> {
    let lists = !matches!(request.technique, Technique::Forward | Technique::Deferred | Technique::Reference);
    match (effect, forced) {
        (EffectName::Prepass, _) => request.prepass = forced,
        (EffectName::Msaa, false) => request.msaa = 1,
        (EffectName::Msaa, true) => request.msaa = request.msaa.max(4),
        (EffectName::DepthBounds, false) => request.depth_bounds = Some(DepthBounds::Off),
        (EffectName::DepthBounds, true) if !lists || !request.prepass => {
            return Err(Error::usage("--force depth_bounds needs a technique with light lists, and a pre-pass"));
        }
        (EffectName::DepthBounds, true) => request.depth_bounds = Some(DepthBounds::Mask),
        _ => {}
    }
    Ok(())
}

/// Says of each effect what was overridden.
pub(super) fn say(effects: &mut [Effect], request: &Request, notes: &mut Vec<String>) {
    for Override { effect, forced, materials } in &request.overrides {
        let (name, verb) = (effect.name(), if *forced { "forced" } else { "forbidden" });
        let of_materials = match (effect.of_materials(), materials) {
            (None, _) => String::new(),
            (Some(_), count) => format!(" ({count} materials changed)"),
        };
        notes.push(format!("{name} is {verb}{of_materials}"));
        if let Some(said) = effects.iter_mut().find(|said| said.name == name) {
            said.why = format!("{verb}{of_materials}; {}", said.why);
        }
    }
}
