//! Deferred, full screen: every pixel of the G-buffer loops over all lights, with a range test that skips (`fullscreen-branch`) or without
//! (`fullscreen`): what light volumes and tiles are measured against.
//!
//! Reads: frame, lights, G-buffer. Writes: radiance (RGBA32F; alpha 1 where a lit surface is). One triangle over the picture.
//! Limits: as `forward`. CPU twin: `reference/shade.rs`.

use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::{RADIANCE_FORMAT, SceneHandles, nearest_sampler};
use crate::graph::access::{FragmentSampled, FragmentStorageRead, FragmentTexel, FragmentUniform};
use crate::graph::{Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::deferred_fullscreen;

/// Adds the pass; the radiance. With `branch` lights out of range are stepped over.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    planned: &Gbuffer,
    scene: &SceneHandles,
    layers: &Layers,
    branch: bool,
) -> ImageHandle {
    let extent = [plan.view.width, plan.view.height];
    let radiance = graph.image("radiance", RADIANCE_FORMAT, extent, Lifetime::Transient);
    let sampled = |image| FragmentSampled(image, nearest_sampler());
    let set = deferred_fullscreen::Bindings {
        frame: FragmentUniform(scene.frame),
        lights_storage: FragmentStorageRead(scene.lights),
        lights_uniform: FragmentUniform(scene.lights),
        lights_texel: FragmentTexel(scene.lights),
        shadow_atlas: scene.shadow_atlas_of_fragments(),
        shadow_maps: scene.shadow_maps_of_fragments(),
        bounced_places: scene.bounced_places_of_fragments(),
        bounced_words: scene.bounced_words_of_fragments(),
        bounced_words_storage: scene.bounced_word_storage_of_fragments(),
        bounced_light: scene.bounced_light_of_fragments(),
        materials: FragmentStorageRead(scene.materials),
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
        depth_samples: None,
        base_color_samples: None,
        normals_samples: None,
        material_samples: None,
        emission_samples: None,
    };
    let render =
        Render::full_screen(radiance, extent, layers.with_depth(set.list()), vec![pipeline(plan, planned, branch)]);
    graph.add("deferred_fullscreen", Work::Render(render));
    radiance
}

fn pipeline(plan: &Plan, planned: &Gbuffer, branch: bool) -> GraphicsPipeline {
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(planned));
    let spec = deferred_fullscreen::Spec {
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
        SAMPLES: 1,
    };
    GraphicsPipeline::full_screen(&deferred_fullscreen::PROGRAM, spec.values(), RADIANCE_FORMAT)
}
