//! Every effect with the decision whether it runs, the number that decided, and what it costs.

mod statements;

use serde::Serialize;

use super::cost::Load;
use super::materials::{HEIGHT_MAP, NORMAL_MAP};
use super::profile::Profile;
use super::shadows::Selection;
use super::{DepthBounds, Gbuffer, Plan, Request, Technique};
use super::{bounced, gbuffer, samples, shadows, transparency};
use crate::scene::shading::Model;
use crate::scene::{AlphaMode, Scene};

pub use statements::{STATEMENTS, Statement};

/// One effect and its decision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Effect {
    /// As the JSON names it.
    pub name: &'static str,
    /// In this frame or not.
    pub runs: bool,
    /// With the number that decided.
    pub why: String,
    /// Device memory it takes, or would have taken.
    pub bytes: u64,
    /// Milliseconds of a frame that it takes, or would have taken, as [`estimate`] has it; `None` where no figure of a device says.
    pub ms: Option<f64>,
}

impl Effect {
    pub(super) fn new(name: &'static str, runs: bool, why: String, bytes: u64) -> Self {
        Self { name, runs, why, bytes, ms: None }
    }
}

fn effect(name: &'static str, runs: bool, why: String, bytes: u64) -> Effect {
    Effect::new(name, runs, why, bytes)
}

/// Gives each effect its milliseconds by what was measured on the device: steps of lists and G-buffers by the model of `plan/cost.rs`, the others by
/// what they cost where they are forced. Estimates: a scene may call for more of an effect, or less. The reference has none.
pub fn estimate(plan: &mut Plan, scene: &Scene, tile: u32, profile: &Profile) {
    if plan.technique == Technique::Reference {
        return;
    }
    let load = Load::new(scene, &plan.lighting, &plan.view, tile);
    let pixels = load.pixels;
    for effect in &mut plan.effects {
        let nanoseconds = match effect.name {
            "gbuffer" => Some(pixels * profile.gbuffer),
            "light_volumes" => Some(load.seen * profile.volume + load.covered * profile.volume_pixel),
            "depth_bounds" => Some(pixels * profile.bounds.min(profile.group_bounds)),
            "light_lists" => Some(profile.lists_ms * 1e6 + load.tests * profile.cull),
            "clusters" => Some(profile.clusters_ms * 1e6 + pixels * profile.cluster),
            "shadows" => {
                let lights = plan.shadows.as_ref().map_or(1, |shadows| shadows.lights.len());
                profile.forced.map(|forced| forced.shadows * pixels * lights as f64)
            }
            name => profile.forced.and_then(|forced| forced.of(name)).map(|each| each * pixels),
        };
        effect.ms = nanoseconds.map(|ns| ns * 1e-6);
    }
}

pub(super) fn decide(plan: &Plan, scene: &Scene, request: &Request, shadowed: &Selection) -> Vec<Effect> {
    let on_device = plan.technique != Technique::Reference;
    vec![
        prepass(plan, request),
        lights(plan),
        gbuffer::effect(plan),
        gbuffer::volumes_effect(plan),
        depth_bounds(plan),
        light_lists(plan),
        clusters(plan),
        normal_maps(plan, scene, on_device),
        parallax(plan, scene, on_device),
        material_models(plan, scene),
        alpha_mask(scene),
        samples::effect(plan, request),
        transparency::effect(plan, scene),
        shadows::effect(plan, shadowed, request),
        bounced::effect(plan),
    ]
}

fn prepass(plan: &Plan, request: &Request) -> Effect {
    let bytes = plan.pixels() * super::DEPTH_BYTES;
    let why = if plan.prepass {
        format!("{} draws: each pixel is shaded once", plan.geometry.draws.len())
    } else if !request.prepass {
        "--prepass off".into()
    } else if plan.geometry.draws.is_empty() {
        "nothing is drawn".into()
    } else {
        format!("{} traces rays", plan.technique.name())
    };
    effect("prepass", plan.prepass, why, bytes)
}

fn lights(plan: &Plan) -> Effect {
    let count = plan.lights.count;
    let why = match count {
        0 => "no light reaches anything".to_string(),
        _ if plan.technique == Technique::Reference => format!("{count} lights, in f64"),
        _ => format!(
            "{count} lights, {} bytes each, read by {} ({})",
            plan.lights.texels_each * 16,
            plan.lights.fetch.name(),
            plan.lights.fetch_why
        ),
    };
    effect("lights", count > 0, why, plan.lights.bytes())
}

/// Why there are no lists: the technique has none, or nothing would stand in them.
fn without_lists(plan: &Plan, otherwise: &str) -> String {
    let name = plan.technique.name();
    if plan.tiles.is_none() && plan.technique.has_lists() {
        return format!("none of {} lights ends anywhere: there is nothing to list", plan.lights.count);
    }
    format!("{name} {otherwise}")
}

fn depth_bounds(plan: &Plan) -> Effect {
    let Some(tiles) = &plan.tiles else {
        return effect("depth_bounds", false, without_lists(plan, "has no light lists"), 0);
    };
    let bytes = tiles.bounds_bytes(DepthBounds::MinMax);
    let why = match tiles.bounds {
        DepthBounds::Off if plan.walks_tree() => "clusters find their lights without lists of tiles".into(),
        DepthBounds::Off if !plan.prepass => "no depth is known before shading".into(),
        DepthBounds::Off => "--depth-bounds off".into(),
        DepthBounds::MinMax => "nearest and farthest sample of each tile".into(),
        DepthBounds::Mask => {
            format!("nearest and farthest sample of each tile, and which of {} slots hold samples", tiles.slots)
        }
    };
    effect("depth_bounds", tiles.bounds != DepthBounds::Off && plan.prepass, why, bytes)
}

fn light_lists(plan: &Plan) -> Effect {
    let Some(tiles) = &plan.tiles else {
        return effect("light_lists", false, without_lists(plan, "loops over all lights"), 0);
    };
    let grid = &tiles.grid;
    let why = format!(
        "{}x{} tiles of {} pixels, {}: at most {} pairs, the longest list {}; {}x{} bins hold {} pairs",
        grid.columns,
        grid.rows,
        tiles.tile,
        tiles.cull.name(),
        tiles.tile_pairs,
        tiles.longest_tile,
        grid.bin_columns,
        grid.bin_rows,
        tiles.bin_pairs
    );
    if plan.walks_tree() {
        return effect(
            "light_lists",
            false,
            format!("clusters walk through the light hierarchy instead of {why}"),
            tiles.bytes(),
        );
    }
    effect("light_lists", true, why, tiles.bytes())
}

fn clusters(plan: &Plan) -> Effect {
    let Some(clusters) = &plan.clusters else {
        return effect("clusters", false, without_lists(plan, "cuts no tiles into slices"), 0);
    };
    let why = format!(
        "at most {}, {} bounds, {} pairs with lights: {}",
        clusters.grid.capacity,
        clusters.bounds.name(),
        clusters.pairs,
        clusters.why
    );
    effect("clusters", true, why, clusters.bytes())
}

fn normal_maps(plan: &Plan, scene: &Scene, on_device: bool) -> Effect {
    let count = plan.materials.variants.iter().filter(|v| v.textures & NORMAL_MAP != 0).count();
    let tangents: usize = scene.meshes.iter().map(|m| m.tangents.len() * 16).sum();
    let why = format!("{count} of {} materials have a normal map", scene.materials.len());
    effect("normal_maps", count > 0 && on_device, why, tangents as u64)
}

fn parallax(plan: &Plan, scene: &Scene, on_device: bool) -> Effect {
    let count = plan.materials.variants.iter().filter(|v| v.textures & HEIGHT_MAP != 0).count();
    let why = format!("{count} of {} materials have a height map", scene.materials.len());
    effect("parallax", count > 0 && on_device, why, 0)
}

fn material_models(plan: &Plan, scene: &Scene) -> Effect {
    let own = |model: Model| scene.materials.iter().filter(|m| m.model.is_some_and(|own| own.model == model)).count();
    let counts = Model::ALL.map(|model| (model.name(), own(model)));
    let named: Vec<_> = counts.iter().filter(|c| c.1 > 0).map(|(name, count)| format!("{count} {name}")).collect();
    let gbuffer = plan.deferred.as_ref().map(|deferred| deferred.gbuffer);
    let stored = gbuffer.is_some_and(|gbuffer| gbuffer.material);
    let why = match (named.is_empty(), stored) {
        (true, _) => format!("none of {} materials names a shading model", scene.materials.len()),
        (false, true) => format!("{}: the G-buffer says which material is seen", named.join(", ")),
        (false, false) => format!("{}: a pipeline each", named.join(", ")),
    };
    let without = |gbuffer: Gbuffer| Gbuffer { material: false, ..gbuffer }.texel_bytes();
    let bytes = gbuffer.map_or(0, |gbuffer| gbuffer.texel_bytes() - without(gbuffer));
    effect("material_models", !named.is_empty(), why, bytes * plan.pixels())
}

fn alpha_mask(scene: &Scene) -> Effect {
    let count = scene.materials.iter().filter(|m| matches!(m.alpha, AlphaMode::Mask(_))).count();
    effect("alpha_mask", count > 0, format!("{count} of {} materials are masked", scene.materials.len()), 0)
}
