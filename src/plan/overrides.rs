//! `--force` and `--forbid`: effects that run, or do not, whatever calls for them. What materials call for is changed in the scene, before it is
//! planned; what the picture asks for, in the request.

use super::request::{DepthBounds, Gi, Technique};
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
    /// Shadows of lights.
    Shadows,
    /// Bounced light.
    Radiosity,
}

impl EffectName {
    /// Every name.
    pub const ALL: [Self; 10] = [
        Self::Prepass,
        Self::DepthBounds,
        Self::Transparency,
        Self::AlphaMask,
        Self::NormalMaps,
        Self::Parallax,
        Self::MaterialModels,
        Self::Msaa,
        Self::Shadows,
        Self::Radiosity,
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
            Self::Shadows => "shadows",
            Self::Radiosity => "radiosity",
        }
    }

    fn of_materials(self) -> Option<MaterialEffect> {
        match self {
            Self::Transparency => Some(MaterialEffect::Transparency),
            Self::AlphaMask => Some(MaterialEffect::AlphaMask),
            Self::NormalMaps => Some(MaterialEffect::NormalMaps),
            Self::Parallax => Some(MaterialEffect::Parallax),
            Self::MaterialModels => Some(MaterialEffect::MaterialModels),
            Self::Prepass | Self::DepthBounds | Self::Msaa | Self::Shadows | Self::Radiosity => None,
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
/// An effect both forced and forbidden, or one that the technique or another option rules out.
pub fn apply(scene: &mut Scene, request: &mut Request, force: &[EffectName], forbid: &[EffectName]) -> Result<()> {
    if let Some(both) = force.iter().find(|effect| forbid.contains(effect)) {
        return Err(Error::usage(format!("{} is both forced and forbidden", both.name())));
    }
    for (effects, forced) in [(forbid, false), (force, true)] {
        // What others need comes first, in whatever order they are typed.
        let (first, others): (Vec<_>, Vec<_>) = effects.iter().partition(|effect| **effect == EffectName::Prepass);
        for &effect in first.into_iter().chain(others) {
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
    let lists = request.technique == Technique::Auto || request.technique.has_lists();
    match (effect, forced) {
        (EffectName::Prepass, _) => request.prepass = forced,
        (EffectName::Msaa, false) => request.msaa = 1,
        (EffectName::Msaa, true) => request.msaa = request.msaa.max(4),
        (EffectName::Shadows, false) => request.shadows = Some(0),
        // Which lights ask and reach what is seen is found later (plan/shadows/select.rs).
        (EffectName::Shadows, true) if request.shadows == Some(0) => {
            return Err(Error::usage("--shadows 0 contradicts --force shadows"));
        }
        (EffectName::Radiosity, false) if matches!(request.gi, Gi::Radiosity(_)) => {
            request.gi = Gi::Off;
            request.rules.emission_lights = false;
        }
        // What it would be gathered with has to be said; that it is worth a pass need not (plan/bounced.rs).
        (EffectName::Radiosity, true) if !matches!(request.gi, Gi::Radiosity(_)) => {
            return Err(Error::usage("--force radiosity needs --gi radiosity or --gi radiosity:DIR"));
        }
        (EffectName::DepthBounds, false) => request.depth_bounds = Some(DepthBounds::Off),
        (EffectName::DepthBounds, true) if !lists || !request.prepass => {
            return Err(Error::usage("--force depth_bounds needs a technique with light lists, and a pre-pass"));
        }
        (EffectName::DepthBounds, true) => match request.depth_bounds {
            Some(DepthBounds::Off) => {
                return Err(Error::usage("--depth-bounds off contradicts --force depth_bounds"));
            }
            given => request.depth_bounds = given.or(Some(DepthBounds::Mask)),
        },
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
        let said = effects.iter_mut().find(|said| said.name == name);
        let in_vain = *forced && said.as_ref().is_none_or(|said| !said.runs);
        let end = if in_vain { ", and nothing in this plan can run it" } else { "" };
        notes.push(format!("{name} is {verb}{of_materials}{end}"));
        if let Some(said) = said {
            said.why = format!("{verb}{of_materials}; {}", said.why);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Plan};
    use crate::scene::builtin;

    fn overridden(mut request: Request, force: &[EffectName], forbid: &[EffectName]) -> Result<Plan> {
        let mut scene = builtin::load("cornell").expect("a built-in scene");
        apply(&mut scene, &mut request, force, forbid)?;
        Plan::new(&scene, &request, &Limits::MINIMUM)
    }

    #[test]
    fn a_prepass_is_forced_before_what_needs_it() {
        let request = Request { technique: Technique::TiledForward, prepass: false, ..Request::default() };
        let (prepass, bounds) = (EffectName::Prepass, EffectName::DepthBounds);
        for force in [[prepass, bounds], [bounds, prepass]] {
            let plan = overridden(request.clone(), &force, &[]).expect("a plan");
            assert!(plan.prepass && plan.tiles.is_some_and(|tiles| tiles.bounds == DepthBounds::Mask));
        }
        assert!(overridden(request, &[bounds], &[]).is_err());
    }

    #[test]
    fn depth_bounds_are_forced_as_they_were_asked_for() {
        let of = |bounds| Request { technique: Technique::TiledForward, depth_bounds: bounds, ..Request::default() };
        let bounds = EffectName::DepthBounds;
        let plan = overridden(of(Some(DepthBounds::MinMax)), &[bounds], &[]).expect("a plan");
        assert!(plan.tiles.is_some_and(|tiles| tiles.bounds == DepthBounds::MinMax));
        let refused = overridden(of(Some(DepthBounds::Off)), &[bounds], &[]).expect_err("a contradiction");
        assert!(refused.to_string().contains("contradicts"), "{refused}");
        assert!(overridden(of(None), &[bounds], &[bounds]).is_err());
    }

    #[test]
    fn what_cannot_run_is_not_said_to_be_forced_alone() {
        let request = Request { technique: Technique::Auto, ..Request::default() };
        let plan = overridden(request, &[EffectName::DepthBounds], &[]).expect("a plan");
        let runs = plan.effects.iter().any(|effect| effect.name == "depth_bounds" && effect.runs);
        let said = plan.notes.iter().find(|note| note.starts_with("depth_bounds is forced")).expect("a note");
        assert_eq!(said.contains("nothing in this plan can run it"), !runs, "{said}");
    }
}
