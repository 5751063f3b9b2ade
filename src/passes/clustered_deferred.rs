//! Clustered deferred shading (O. Olsson, M. Billeter, U. Assarsson, HPG 2012): every pixel of the G-buffer loops over the lights of its
//! cluster, in a compute pass.
//!
//! Reads: frame, lights, tile grid, cluster grid, lists, the cluster of each sample where there is a pre-pass, G-buffer. Writes: radiance,
//! every pixel of it (0 where no lit surface is seen). Groups of 8x8 threads, a thread a pixel. Limits: the plan's. CPU twin:
//! `reference/shade.rs`; equal to `tiled_deferred` and the forms of `deferred` bit for bit.

use super::cluster_lists::{ClusterLists, Parts};
use super::clustered_forward::list_fetch;
use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::{SceneHandles, dispatch, nearest_sampler, one_sample, sample_edges};
use crate::graph::access::{ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeTexel, ComputeUniform};
use crate::graph::{Binding, Contents, Graph, ImageHandle};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::clustered_deferred;

/// What the pass needs beside the scene.
pub struct Inputs<'a> {
    /// Tiles and clusters of the plan.
    pub parts: Parts<'a>,
    /// Their lists.
    pub made: ClusterLists,
    /// The plan's G-buffer.
    pub planned: &'a Gbuffer,
    /// Its images.
    pub layers: &'a Layers,
}

/// Adds the pass; the radiance.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, inputs: &Inputs) -> ImageHandle {
    let size = [plan.view.width, plan.view.height];
    let radiance = sample_edges::target(graph, plan);
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(inputs.planned));
    let spec = clustered_deferred::Spec {
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
        TILE: inputs.parts.tiles.tile,
        LIST_FETCH: list_fetch(inputs.parts.clusters),
        // Most listed lights reach their samples (plan/tiles.rs, `list_seek`).
        LIST_SEEK: false,
        CLUSTER_OF: inputs.made.lookup,
        GBUFFER: gbuffer.layout,
        NORMAL_BITS: gbuffer.normal_bits,
        EMISSION: gbuffer.emission,
        STORED_MATERIAL: gbuffer.material,
        SAMPLES: plan.samples,
        SPREAD: plan.spreads_samples(),
    };
    let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
    let bindings = bindings(graph, scene, inputs, radiance);
    graph.add("clustered_deferred", dispatch(&clustered_deferred::PROGRAM, spec.values(), bindings, groups));
    radiance
}

fn bindings(graph: &Graph, scene: &SceneHandles, inputs: &Inputs, radiance: ImageHandle) -> Vec<Binding> {
    let (parts, lists, layers) = (&inputs.parts, inputs.made.lists, inputs.layers);
    let sampled = |image| ComputeSampled(image, nearest_sampler());
    let set = clustered_deferred::Bindings {
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
        grid: ComputeUniform(parts.tile_handles.grid),
        list_offsets_storage: ComputeStorageRead(lists.offsets),
        list_offsets_texel: ComputeTexel(lists.offsets),
        list_lights_storage: ComputeStorageRead(lists.lights),
        list_lights_texel: ComputeTexel(lists.lights),
        clusters: ComputeUniform(parts.handles.grid),
        // A texel that nothing reads stands in where clusters have no index.
        cluster_index: sampled(inputs.made.index.unwrap_or(parts.tile_handles.no_bounds)),
        // Either layout: without an index the slice comes from it.
        materials: ComputeStorageRead(scene.materials),
        gbuffer_depth: sampled(one_sample(graph, scene, layers.depth)),
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
        radiance: ComputeImageWrite(radiance, Contents::Discarded),
    };
    set.list()
}
