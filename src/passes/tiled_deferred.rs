//! Tiled deferred shading (Andersson, "Parallel Graphics in Frostbite", SIGGRAPH 2009): every pixel of the G-buffer loops over the lights
//! of its tile, in a compute pass.
//!
//! Reads: frame, lights, tile grid, lists, G-buffer. Writes: radiance, every pixel of it (0 where no lit surface is seen). Groups of 8x8
//! threads, a thread a pixel, or four below each other, which read each light once. Limits: the plan's. CPU twin: `reference/shade.rs`;
//! equal to the forms of `deferred` bit for bit.

use super::depth_reduce::bounds_constant;
use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::tile_cull::{Lists, list_fetch};
use super::{SceneHandles, TileHandles, dispatch, nearest_sampler, sample_edges};
use crate::graph::access::{ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeTexel, ComputeUniform};
use crate::graph::{Contents, Graph, ImageHandle};
use crate::plan::{DepthBounds, Gbuffer, Plan, Tiles};
use crate::shaders::shade::tiled_deferred;

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
    /// The plan's G-buffer.
    pub planned: &'a Gbuffer,
    /// Its images.
    pub layers: &'a Layers,
    /// 1 or 4.
    pub pixels_a_thread: u32,
}

/// Adds the pass; the radiance.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, inputs: &Inputs) -> ImageHandle {
    let size = [plan.view.width, plan.view.height];
    let radiance = sample_edges::target(graph, plan);
    let layers = inputs.layers;
    let sampled = |image| ComputeSampled(image, nearest_sampler());
    let set = tiled_deferred::Bindings {
        frame: ComputeUniform(scene.frame),
        lights_storage: ComputeStorageRead(scene.lights),
        lights_uniform: ComputeUniform(scene.lights),
        lights_texel: ComputeTexel(scene.lights),
        shadow_atlas: scene.shadow_atlas_of_compute(),
        shadow_maps: scene.shadow_maps_of_compute(),
        bounced_places: scene.bounced_places_of_compute(),
        bounced_words: scene.bounced_words_of_compute(),
        bounced_words_storage: scene.bounced_word_storage_of_compute(),
        bounced_light: scene.bounced_light_of_compute(),
        grid: ComputeUniform(inputs.handles.grid),
        list_offsets_storage: ComputeStorageRead(inputs.lists.offsets),
        list_offsets_texel: ComputeTexel(inputs.lists.offsets),
        list_lights_storage: ComputeStorageRead(inputs.lists.lights),
        list_lights_texel: ComputeTexel(inputs.lists.lights),
        materials: ComputeStorageRead(scene.materials),
        gbuffer_depth: sampled(layers.sampled_depth),
        gbuffer_base_color: sampled(layers.base_color),
        gbuffer_normals: sampled(layers.normals),
        gbuffer_material: sampled(layers.material),
        gbuffer_emission: sampled(layers.emission),
        gbuffer_position_roughness: sampled(layers.position_roughness),
        gbuffer_normal_occlusion: sampled(layers.normal_occlusion),
        gbuffer_base_metallic: sampled(layers.base_metallic),
        gbuffer_specular_flag: sampled(layers.specular_flag),
        gbuffer_ambient_emission: sampled(layers.ambient_emission),
        depth_samples: layers.of_sample(0),
        base_color_samples: layers.of_sample(1),
        normals_samples: layers.of_sample(2),
        material_samples: layers.of_sample(3),
        emission_samples: layers.of_sample(4),
        sample_edges: sampled(layers.edges_or(scene)),
        tile_bounds: sampled(inputs.bounds.unwrap_or(inputs.handles.no_bounds)),
        radiance: ComputeImageWrite(radiance, Contents::Discarded),
    };
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(inputs.planned));
    let pixels = inputs.pixels_a_thread;
    let spec = tiled_deferred::Spec {
        LIGHT_FETCH: lights.fetch,
        LIGHT_KINDS: lights.kinds,
        LIGHT_TEXELS: lights.texels,
        LIGHT_UNIFORM_TEXELS: lights.uniform_texels,
        LIGHT_SEEK: lights.seek,
        INVERSE_SQUARE: lights.inverse_square,
        SHADOW_KINDS: lights.shadow_kinds,
        SHADOW_FILTER: lights.shadow_filter,
        BOUNCED: lights.bounced,
        BOUNCED_STORAGE: lights.bounced_storage,
        SHADING: lights.shading,
        TILE: inputs.tiles.tile,
        DEPTH_BOUNDS: bounds_constant(inputs.bounds.map_or(DepthBounds::Off, |_| inputs.tiles.bounds)),
        DEPTH_SLOTS: inputs.tiles.slots,
        PIXELS_A_THREAD: pixels,
        LIST_FETCH: list_fetch(inputs.tiles),
        LIST_SEEK: inputs.tiles.list_seek && lights.seek,
        GBUFFER: gbuffer.layout,
        NORMAL_BITS: gbuffer.normal_bits,
        EMISSION: gbuffer.emission,
        STORED_MATERIAL: gbuffer.material,
        SAMPLES: plan.samples,
        SPREAD: plan.spreads_samples(),
    };
    let groups = [size[0].div_ceil(8), size[1].div_ceil(8 * pixels), 1];
    graph.add("tiled_deferred", dispatch(&tiled_deferred::PROGRAM, spec.values(), set.list(), groups));
    radiance
}
