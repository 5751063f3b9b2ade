//! Deferred samples: all lights on every pixel of a G-buffer of several samples, sample by sample where they differ, in a compute pass.
//!
//! Reads: frame, lights, materials, G-buffer, edges. Writes: radiance, every pixel of it (0 where no lit surface is seen), or its samples side by
//! side. Groups of 8x8, a thread a pixel. Limits: the plan's. CPU twin: `reference/shade.rs`.

use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::{SceneHandles, dispatch, nearest_sampler, sample_edges};
use crate::graph::access::{ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeTexel, ComputeUniform};
use crate::graph::{Contents, Graph, ImageHandle};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::deferred_samples;

/// Adds the pass; the radiance. With `branch` lights out of range are stepped over.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    planned: &Gbuffer,
    scene: &SceneHandles,
    layers: &Layers,
    branch: bool,
) -> ImageHandle {
    let radiance = sample_edges::target(graph, plan);
    let sampled = |image| ComputeSampled(image, nearest_sampler());
    let set = deferred_samples::Bindings {
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
        materials: ComputeStorageRead(scene.materials),
        sample_edges: sampled(layers.edges_or(scene)),
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
        radiance: ComputeImageWrite(radiance, Contents::Discarded),
    };
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(planned));
    let spec = deferred_samples::Spec {
        LIGHT_FETCH: lights.fetch,
        LIGHT_KINDS: lights.kinds,
        LIGHT_TEXELS: lights.texels,
        LIGHT_UNIFORM_TEXELS: lights.uniform_texels,
        LIGHT_SEEK: branch,
        INVERSE_SQUARE: lights.inverse_square,
        SHADOW_KINDS: lights.shadow_kinds,
        SHADOW_FILTER: lights.shadow_filter,
        BOUNCED: lights.bounced,
        BOUNCED_STORAGE: lights.bounced_storage,
        SHADING: lights.shading,
        GBUFFER: gbuffer.layout,
        NORMAL_BITS: gbuffer.normal_bits,
        EMISSION: gbuffer.emission,
        STORED_MATERIAL: gbuffer.material,
        SAMPLES: plan.samples,
        SPREAD: plan.spreads_samples(),
    };
    let groups = [plan.view.width.div_ceil(8), plan.view.height.div_ceil(8), 1];
    graph.add("deferred_samples", dispatch(&deferred_samples::PROGRAM, spec.values(), set.list(), groups));
    radiance
}
