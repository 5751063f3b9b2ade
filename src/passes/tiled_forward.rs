//! Tiled forward shading ("Forward+", Harada, McKee, Yang, Eurographics 2012): every fragment loops over the lights of its tile.
//!
//! Reads: what `forward` reads, tile grid, lists and offsets. Writes: radiance, and depth without a pre-pass.
//! Limits: the plan's. CPU twin: `reference/shade.rs`; equal to `forward` bit for bit.

use super::depth_reduce::bounds_constant;
use super::forward::{Io, blend_of, light_constants, shaded_depth, shaded_format};
use super::light_parts::{self, Part};
use super::resources::{draw, variants};
use super::tile_cull::{Lists, list_fetch};
use super::{DEPTH_FORMAT, SceneHandles, TileHandles, nearest_sampler};
use crate::graph::access::{
    FragmentSampled, FragmentStorageRead, FragmentTexel, FragmentUniform, GraphicsStorageRead, GraphicsUniform,
    VertexStorageRead,
};
use crate::graph::{Binding, ColorAttachment, DepthAttachment, Graph, GraphicsPipeline, ImageHandle, Render};
use crate::plan::materials::Variant;
use crate::plan::{DepthBounds, Plan, Tiles};
use crate::shaders::shade::tiled_forward;

/// What the pass needs beside the scene.
pub struct Inputs<'a> {
    /// The plan's tiles.
    pub tiles: &'a Tiles,
    /// Their static buffers.
    pub handles: &'a TileHandles,
    /// Their lists.
    pub lists: Lists,
    /// What these know of depths.
    pub bounds: Option<ImageHandle>,
    /// Depth that is there already.
    pub prepass: Option<ImageHandle>,
}

/// Adds the pass.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, inputs: &Inputs) -> Io {
    let extent = [plan.view.width, plan.view.height];
    let prepass = inputs.prepass;
    let depth = prepass.unwrap_or_else(|| graph.image_of_samples("depth", DEPTH_FORMAT, extent, plan.samples));
    let (distinct, of_draw) = variants(plan, |v| v);
    let radiance = light_parts::add(graph, plan, scene, "tiled_forward", |part| Render {
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
    let set = tiled_forward::Bindings {
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
        grid: FragmentUniform(inputs.handles.grid),
        list_offsets_storage: FragmentStorageRead(inputs.lists.offsets),
        list_offsets_texel: FragmentTexel(inputs.lists.offsets),
        list_lights_storage: FragmentStorageRead(inputs.lists.lights),
        list_lights_texel: FragmentTexel(inputs.lists.lights),
        tile_bounds: FragmentSampled(inputs.bounds.unwrap_or(inputs.handles.no_bounds), nearest_sampler()),
        radiance_before: part.before,
    };
    set.list()
}

/// The pipeline of a variant; blended surfaces are mixed with what is there.
pub(super) fn pipeline(plan: &Plan, inputs: &Inputs, variant: Variant, part: &Part) -> GraphicsPipeline {
    let (constants, tiles) = (light_constants(plan), inputs.tiles);
    let spec = tiled_forward::Spec {
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
        DEPTH_BOUNDS: bounds_constant(inputs.bounds.map_or(DepthBounds::Off, |_| tiles.bounds)),
        DEPTH_SLOTS: tiles.slots,
        LIST_FETCH: list_fetch(tiles),
        LIST_SEEK: tiles.list_seek && constants.seek_for(plan, variant),
        BLENDED: variant.blended,
        HALF_LAYER: variant.blended && plan.transparency.as_ref().is_some_and(|planned| planned.layer),
        FIRST_PART: part.first,
        LAST_PART: part.last,
        PART_LIGHTS: part.lights,
    };
    GraphicsPipeline {
        program: &tiled_forward::PROGRAM,
        constants: spec.values(),
        colors: vec![shaded_format(plan, variant)],
        blend: blend_of(variant),
        depth: Some(shaded_depth(variant, inputs.prepass.is_some())),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}
