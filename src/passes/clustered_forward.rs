//! Clustered forward shading (O. Olsson, M. Billeter, U. Assarsson, HPG 2012): every fragment loops over the lights of its cluster.
//!
//! Reads: what `forward` reads, tile grid, cluster grid, lists and offsets, the cluster of each sample where there is a pre-pass. Writes:
//! radiance, and depth without a pre-pass. Limits: the plan's. CPU twin: `reference/shade.rs`; equal to `forward` bit for bit.

use super::cluster_lists::{ClusterLists, Parts};
use super::forward::{Io, blend_of, light_constants, shaded_depth, shaded_format};
use super::light_parts::{self, Part};
use super::resources::{draw, variants};
use super::{DEPTH_FORMAT, SceneHandles, nearest_sampler};
use crate::graph::access::{
    FragmentSampled, FragmentStorageRead, FragmentTexel, FragmentUniform, GraphicsStorageRead, GraphicsUniform,
    VertexStorageRead,
};
use crate::graph::{Binding, ColorAttachment, DepthAttachment, Graph, GraphicsPipeline, ImageHandle, Render};
use crate::plan::materials::Variant;
use crate::plan::{Clusters, Plan};
use crate::shaders::shade::clustered_forward;
use crate::shared;

/// What the pass needs beside the scene.
pub struct Inputs<'a> {
    /// Tiles and clusters of the plan.
    pub parts: Parts<'a>,
    /// Their lists.
    pub made: ClusterLists,
    /// Depth that is there already.
    pub prepass: Option<ImageHandle>,
}

/// Value of LIST_FETCH for lists of clusters.
pub fn list_fetch(clusters: &Clusters) -> u32 {
    if clusters.words_by_texel { shared::WORDS_TEXEL } else { shared::WORDS_STORAGE }
}

/// Adds the pass.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, inputs: &Inputs) -> Io {
    let extent = [plan.view.width, plan.view.height];
    let prepass = inputs.prepass;
    let depth = prepass.unwrap_or_else(|| graph.image_of_samples("depth", DEPTH_FORMAT, extent, plan.samples));
    let (distinct, of_draw) = variants(plan, |v| v);
    let radiance = light_parts::add(graph, plan, scene, "clustered_forward", |part| Render {
        colors: vec![ColorAttachment { image: part.target, clear: Some([0.0; 4]) }],
        depth: Some(DepthAttachment { image: depth, clear: prepass.is_none().then_some(0.0) }),
        extent,
        bindings: bindings(scene, inputs, part),
        material_bindings: scene.material_bindings.clone(),
        pipelines: distinct.iter().map(|&v| pipeline(plan, inputs, v, part)).collect(),
        draws: plan.geometry.draws.iter().zip(&of_draw).map(|(d, &p)| draw(plan, d, p)).collect(),
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    });
    Io { radiance, depth }
}

/// Set 0 of the pass.
pub(super) fn bindings(scene: &SceneHandles, inputs: &Inputs, part: &Part) -> Vec<Binding> {
    let (parts, lists) = (&inputs.parts, inputs.made.lists);
    // A texel that nothing reads stands in where clusters have no index.
    let index = inputs.made.index.unwrap_or(parts.tile_handles.no_bounds);
    let set = clustered_forward::Bindings {
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
        grid: FragmentUniform(parts.tile_handles.grid),
        list_offsets_storage: FragmentStorageRead(lists.offsets),
        list_offsets_texel: FragmentTexel(lists.offsets),
        list_lights_storage: FragmentStorageRead(lists.lights),
        list_lights_texel: FragmentTexel(lists.lights),
        clusters: FragmentUniform(parts.handles.grid),
        cluster_index: FragmentSampled(index, nearest_sampler()),
        radiance_before: part.before,
    };
    set.list()
}

/// The pipeline of a variant; blended surfaces are mixed with what is there.
pub(super) fn pipeline(plan: &Plan, inputs: &Inputs, variant: Variant, part: &Part) -> GraphicsPipeline {
    let constants = light_constants(plan);
    let Parts { tiles, clusters, .. } = inputs.parts;
    let spec = clustered_forward::Spec {
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
        TILE: tiles.tile,
        LIST_FETCH: list_fetch(clusters),
        // Most listed lights reach their samples (plan/tiles.rs, `list_seek`).
        LIST_SEEK: false,
        CLUSTER_OF: inputs.made.lookup,
        BLENDED: variant.blended,
        HALF_LAYER: variant.blended && plan.transparency.as_ref().is_some_and(|planned| planned.layer),
        FIRST_PART: part.first,
        LAST_PART: part.last,
        PART_LIGHTS: part.lights,
    };
    GraphicsPipeline {
        program: &clustered_forward::PROGRAM,
        constants: spec.values(),
        colors: vec![shaded_format(plan, variant)],
        blend: blend_of(variant),
        depth: Some(shaded_depth(variant, inputs.prepass.is_some())),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}
