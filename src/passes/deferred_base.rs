//! Deferred base: ambient light, emission and directional lights of every pixel of the G-buffer, and 0 where it holds no surface; what light
//! volumes add to.
//!
//! Reads: frame, lights, G-buffer. Writes: radiance (RGBA32F, or RGBA16F with `--accumulation f16`; alpha 1 where a lit surface is). One
//! triangle over the picture.
//! Limits: as `forward`, for directional lights. CPU twin: `reference/shade.rs`.

use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::{SceneHandles, nearest_sampler, radiance_format};
use crate::graph::access::{FragmentSampled, FragmentStorageRead, FragmentTexel, FragmentUniform};
use crate::graph::{Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::deferred_base;

/// Adds the pass; the radiance.
pub fn add(graph: &mut Graph, plan: &Plan, planned: &Gbuffer, scene: &SceneHandles, layers: &Layers) -> ImageHandle {
    let extent = [plan.view.width, plan.view.height];
    let radiance = graph.image("radiance", radiance_format(plan), extent, Lifetime::Transient);
    let sampled = |image| FragmentSampled(image, nearest_sampler());
    let set = deferred_base::Bindings {
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
    let render = Render::full_screen(radiance, extent, layers.with_depth(set.list()), vec![pipeline(plan, planned)]);
    graph.add("deferred_base", Work::Render(render));
    radiance
}

fn pipeline(plan: &Plan, planned: &Gbuffer) -> GraphicsPipeline {
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(planned));
    let spec = deferred_base::Spec {
        LIGHT_FETCH: lights.fetch,
        LIGHT_KINDS: lights.kinds,
        LIGHT_TEXELS: lights.texels,
        LIGHT_UNIFORM_TEXELS: lights.uniform_texels,
        LIGHT_SEEK: false,
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
    GraphicsPipeline::full_screen(&deferred_base::PROGRAM, spec.values(), radiance_format(plan))
}
