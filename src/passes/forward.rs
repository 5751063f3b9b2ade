//! Forward shading: every fragment loops over all lights, in several passes where a driver's loops go round less often. The definition of
//! the picture.
//!
//! Reads: frame, instances, materials, lights (by the planned fetch), material textures, vertices, indices; depth of the
//! pre-pass, where there is one (tested for equality, not written).
//! Writes: radiance (RGBA32F, scene-linear; alpha 1 where a surface is), and depth without a pre-pass.
//! Limits: lights as the plan's fetch allows; past them the plan takes another fetch or refuses. CPU twin: `reference/shade.rs`.

use super::depth_prepass::COMPARE;
use super::light_parts::{self, Part};
use super::resources::{draw, variants};
use super::{DEPTH_FORMAT, RADIANCE_FORMAT, SceneHandles, transparent};
use crate::graph::access::{
    FragmentStorageRead, FragmentTexel, FragmentUniform, GraphicsStorageRead, GraphicsUniform, VertexStorageRead,
};
use crate::graph::{
    Binding, Blend, ColorAttachment, DepthAttachment, DepthState, Graph, GraphicsPipeline, ImageHandle, Render,
};
use crate::plan::materials::Variant;
use crate::plan::{Fetch, Plan};
use crate::scene::lighting::Attenuation;
use crate::shaders::shade::forward;

/// What the pass leaves.
pub struct Io {
    /// Scene-linear RGBA32F.
    pub radiance: ImageHandle,
    /// D32F, reversed.
    pub depth: ImageHandle,
}

/// Adds the pass; `prepass` is the depth that is there already.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, prepass: Option<ImageHandle>) -> Io {
    let extent = [plan.view.width, plan.view.height];
    let depth = prepass.unwrap_or_else(|| graph.image_of_samples("depth", DEPTH_FORMAT, extent, plan.samples));
    let (distinct, of_draw) = variants(plan, |v| v);
    let radiance = light_parts::add(graph, plan, scene, "forward", |part| Render {
        colors: vec![ColorAttachment { image: part.target, clear: Some([0.0; 4]) }],
        depth: Some(DepthAttachment { image: depth, clear: prepass.is_none().then_some(0.0) }),
        extent,
        bindings: bindings(scene, part),
        material_bindings: scene.material_bindings.clone(),
        pipelines: distinct.iter().map(|&v| pipeline(plan, v, part, prepass.is_some())).collect(),
        draws: plan.geometry.draws.iter().zip(&of_draw).map(|(d, &p)| draw(plan, d, p)).collect(),
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    });
    Io { radiance, depth }
}

/// Set 0 of the pass.
pub(super) fn bindings(scene: &SceneHandles, part: &Part) -> Vec<Binding> {
    let set = forward::Bindings {
        frame: GraphicsUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        materials: GraphicsStorageRead(scene.materials),
        lights_storage: FragmentStorageRead(scene.lights),
        lights_uniform: FragmentUniform(scene.lights),
        lights_texel: FragmentTexel(scene.lights),
        shadow_atlas: scene.shadow_atlas_of_fragments(),
        shadow_maps: scene.shadow_maps_of_fragments(),
        bounced_places: scene.bounced_places_of_fragments(),
        bounced_words: scene.bounced_words_of_fragments(),
        bounced_words_storage: scene.bounced_word_storage_of_fragments(),
        bounced_light: scene.bounced_light_of_fragments(),
        radiance_before: part.before,
    };
    set.list()
}

/// Depth state of a pass that shades, after a pre-pass or without one.
pub fn depth_state(after_prepass: bool) -> DepthState {
    if after_prepass {
        DepthState::read(DEPTH_FORMAT, ash::vk::CompareOp::EQUAL)
    } else {
        DepthState::write(DEPTH_FORMAT, COMPARE)
    }
}

/// The same for one surface: blended ones are tested against what is there, pre-pass or not, and write nothing.
pub(super) fn shaded_depth(variant: Variant, after_prepass: bool) -> DepthState {
    if variant.blended { DepthState { write: false, ..depth_state(false) } } else { depth_state(after_prepass) }
}

/// How a surface meets the picture.
pub(super) fn blend_of(variant: Variant) -> Blend {
    if variant.blended { Blend::Over } else { Blend::Replace }
}

/// Format that a surface is drawn into.
pub(super) fn shaded_format(plan: &Plan, variant: Variant) -> ash::vk::Format {
    if variant.blended { transparent::format(plan) } else { RADIANCE_FORMAT }
}

/// Values of the constants that every light loop shares.
pub struct LightConstants {
    /// LIGHT_FETCH.
    pub fetch: u32,
    /// LIGHT_KINDS.
    pub kinds: u32,
    /// LIGHT_TEXELS.
    pub texels: u32,
    /// LIGHT_UNIFORM_TEXELS: exact, so that the block is as large as its buffer.
    pub uniform_texels: u32,
    /// LIGHT_SEEK.
    pub seek: bool,
    /// INVERSE_SQUARE.
    pub inverse_square: bool,
    /// SHADING of passes that light a G-buffer.
    pub shading: u32,
    /// SHADOW_KINDS.
    pub shadow_kinds: u32,
    /// SHADOW_FILTER.
    pub shadow_filter: u32,
    /// BOUNCED.
    pub bounced: bool,
    /// BOUNCED_STORAGE.
    pub bounced_storage: bool,
}

impl LightConstants {
    /// LIGHT_SEEK for one surface: what is blended loops once over everything.
    pub(super) fn seek_for(&self, plan: &Plan, variant: Variant) -> bool {
        match &plan.transparency {
            Some(planned) if variant.blended => planned.seek,
            _ => self.seek,
        }
    }
}

/// The plan's light constants.
pub fn light_constants(plan: &Plan) -> LightConstants {
    let lights = &plan.lights;
    LightConstants {
        fetch: lights.fetch.constant(),
        kinds: lights.kinds,
        texels: lights.texels_each,
        uniform_texels: if lights.fetch == Fetch::Uniform { lights.texels.len().max(1) as u32 } else { 1 },
        seek: plan.lights.seek,
        inverse_square: plan.lighting.attenuation == Attenuation::PHYSICAL,
        shading: plan.deferred_shading(),
        shadow_kinds: plan.shadows.as_ref().map_or(0, |shadows| shadows.kinds),
        shadow_filter: plan.shadows.as_ref().map_or(0, |shadows| shadows.filter),
        bounced: plan.bounced.is_some(),
        bounced_storage: plan.bounced.as_ref().is_some_and(|bounced| bounced.words_in_storage),
    }
}

/// The pipeline of a variant; blended surfaces are mixed with what is there.
pub(super) fn pipeline(plan: &Plan, variant: Variant, part: &Part, after_prepass: bool) -> GraphicsPipeline {
    let constants = light_constants(plan);
    let spec = forward::Spec {
        LIGHT_FETCH: constants.fetch,
        LIGHT_KINDS: constants.kinds,
        LIGHT_TEXELS: constants.texels,
        LIGHT_UNIFORM_TEXELS: constants.uniform_texels,
        LIGHT_SEEK: constants.seek_for(plan, variant),
        INVERSE_SQUARE: constants.inverse_square,
        SHADOW_KINDS: constants.shadow_kinds,
        SHADOW_FILTER: constants.shadow_filter,
        BOUNCED: constants.bounced,
        BOUNCED_STORAGE: constants.bounced_storage,
        SHADING: variant.model,
        TEXTURES: variant.textures,
        ALPHA_MASK: variant.masked,
        UV_SETS: variant.uv_sets,
        UV_TRANSFORMS: variant.uv_transforms,
        VERTEX_COLORS: variant.vertex_colors,
        UNLIT: variant.unlit,
        MIRRORED_LENS: plan.view.lens.mirrors(),
        PERSPECTIVE: plan.view.lens.is_perspective(),
        SAMPLES: plan.samples,
        BLENDED: variant.blended,
        HALF_LAYER: variant.blended && plan.transparency.as_ref().is_some_and(|planned| planned.layer),
        FIRST_PART: part.first,
        LAST_PART: part.last,
        PART_LIGHTS: part.lights,
    };
    GraphicsPipeline {
        program: &forward::PROGRAM,
        constants: spec.values(),
        colors: vec![shaded_format(plan, variant)],
        blend: blend_of(variant),
        depth: Some(shaded_depth(variant, after_prepass)),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}
