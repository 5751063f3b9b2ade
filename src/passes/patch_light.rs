//! Patch light: what each patch sends at first, by emission and by the direct light at its points past the shadow maps.
//!
//! Reads: frame, patches, their points, lights (by the planned fetch), shadow maps. Writes: `patch_light`.
//! Group shape: 64 threads, one a point. Limits: as `forward`, for lights. CPU twin: `radiosity/solve.rs`.

use bytemuck::bytes_of;

use super::forward::light_constants;
use super::{SceneHandles, resources::BouncedHandles};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform};
use crate::graph::{BufferHandle, ComputePipeline, Graph, Groups, Work};
use crate::plan::bounced::Carried;
use crate::plan::{Bounced, Plan};
use crate::shaders::radiosity::patch_light;
use crate::shared::{
    CARRIED_CHANGES, CARRIED_LIGHT, CARRIED_NOTHING, MOST_GROUPS, PATCH_POINTS, PatchPush, SHADING_LAMBERT,
};

fn carried(bounced: Option<&Bounced>) -> u32 {
    match bounced.map_or(Carried::Nothing, |bounced| bounced.carried) {
        Carried::Nothing => CARRIED_NOTHING,
        Carried::Light => CARRIED_LIGHT,
        Carried::Changes => CARRIED_CHANGES,
    }
}

/// Adds the pass; `kept` is the light of the frame before, where gathers go on from it.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    of: &BouncedHandles,
    (light, kept): (BufferHandle, Option<BufferHandle>),
) {
    let constants = light_constants(plan);
    let count = plan.bounced.as_ref().map_or(0, |bounced| bounced.patches.len() as u32);
    let points = plan.bounced.as_ref().map_or(PATCH_POINTS, |bounced| bounced.points_each);
    let afresh = plan.bounced.as_ref().is_some_and(|bounced| bounced.afresh);
    let set = patch_light::Bindings {
        frame: ComputeUniform(scene.frame),
        patches: ComputeStorageRead(of.patches),
        patch_points: ComputeStorageRead(of.points),
        light: ComputeStorageWrite(light),
        bounced_kept: kept.map(ComputeStorageRead),
        lights_storage: ComputeStorageRead(scene.lights),
        lights_uniform: ComputeUniform(scene.lights),
        lights_texel: ComputeTexel(scene.lights),
        shadow_atlas: scene.shadow_atlas_of_compute(),
        shadow_maps: scene.shadow_maps_of_compute(),
        bounced_places: None,
        bounced_words: None,
        bounced_words_storage: None,
        bounced_light: None,
    };
    let spec = patch_light::Spec {
        POINTS: points,
        CARRIED: carried(plan.bounced.as_ref()),
        LIGHT_FETCH: constants.fetch,
        LIGHT_KINDS: constants.kinds,
        LIGHT_TEXELS: constants.texels,
        LIGHT_UNIFORM_TEXELS: constants.uniform_texels,
        LIGHT_SEEK: constants.seek,
        INVERSE_SQUARE: constants.inverse_square,
        SHADOW_KINDS: constants.shadow_kinds,
        // Points of a patch are their own filter.
        SHADOW_FILTER: 0,
        BOUNCED: false,
        BOUNCED_STORAGE: false,
        SHADING: SHADING_LAMBERT,
    };
    let groups = count.div_ceil(64 / points);
    let work = Work::Dispatch {
        pipeline: ComputePipeline { program: &patch_light::PROGRAM, constants: spec.values() },
        bindings: set.list(),
        push: bytes_of(&PatchPush { count, afresh: u32::from(afresh) }).to_vec(),
        groups: Groups::Fixed([groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]),
    };
    graph.add("patch_light", work);
}
