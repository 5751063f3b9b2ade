//! Light volumes: adds one light after the other to what `deferred_base` left, each where its volume meets the G-buffer (after Arvo and
//! Kirk's bounding of influence as deferred shading uses it; Akenine-Möller et al., Real-Time Rendering, 4th ed., section 20.1).
//!
//! Reads: frame, lights, G-buffer, volumes, the mesh's corners; depth, tested and not written. Reads and writes: radiance, by blending.
//! Back faces of meshes, and rectangles where `plan/light_volumes.rs` (with the proof) prefers them. Primitives blend in the order of
//! instances, so lights are added in the order of ids and each sum is rounded to f32: bit for bit what the loops of the other techniques
//! do, but for their last step: they clamp sums past f32 once (`MAX_RADIANCE`), which blending cannot, so here such a sum is infinite.
//! With `--accumulation f16` each sum is rounded to 11 bits instead, and to infinity past 65504.
//! Limits: a device that cannot blend into RGBA32F gets `deferred_fullscreen` from the plan. CPU twin: `reference/shade.rs`.

use ash::vk;

use super::forward::light_constants;
use super::gbuffer::{Layers, gbuffer_constants};
use super::{DEPTH_FORMAT, SceneHandles, nearest_sampler, radiance_format};
use crate::graph::access::{
    FragmentSampled, FragmentStorageRead, FragmentTexel, FragmentUniform, GraphicsUniform, VertexStorageRead,
    VertexUniform,
};
use crate::graph::{
    Blend, ColorAttachment, Cull, DepthAttachment, DepthState, Draw, Graph, GraphicsPipeline, ImageHandle, Render, Work,
};
use crate::plan::light_volumes::{LightVolumes, Run};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::light_volumes;
use crate::shared::ICOSPHERE_CORNERS;

/// Index of the pipelines.
const MESHES: usize = 0;
/// See [`MESHES`].
const RECTANGLES: usize = 1;

/// What the pass needs beside the scene.
pub struct Inputs<'a> {
    /// The plan's volumes.
    pub volumes: &'a LightVolumes,
    /// The plan's G-buffer.
    pub planned: &'a Gbuffer,
    /// Its images.
    pub layers: &'a Layers,
    /// What lights are added to.
    pub radiance: ImageHandle,
}

/// Adds the pass; nothing where no light is seen.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, inputs: &Inputs) {
    let (Some(volumes), Some(corners)) = (scene.light_volumes, scene.corners) else { return };
    if inputs.volumes.runs.is_empty() {
        return;
    }
    let layers = inputs.layers;
    let sampled = |image| FragmentSampled(image, nearest_sampler());
    let set = light_volumes::Bindings {
        frame: GraphicsUniform(scene.frame),
        light_volumes: VertexStorageRead(volumes),
        corners: VertexUniform(corners),
        lights_storage: FragmentStorageRead(scene.lights),
        lights_uniform: FragmentUniform(scene.lights),
        lights_texel: FragmentTexel(scene.lights),
        shadow_atlas: scene.shadow_atlas_of_fragments(),
        shadow_maps: scene.shadow_maps_of_fragments(),
        bounced_places: None,
        bounced_words: None,
        bounced_words_storage: None,
        bounced_light: None,
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
    let render = Render {
        colors: vec![ColorAttachment { image: inputs.radiance, clear: None }],
        depth: Some(DepthAttachment { image: layers.depth, clear: None }),
        extent: [plan.view.width, plan.view.height],
        bindings: layers.with_depth(set.list()),
        material_bindings: Vec::new(),
        // In the order of MESHES and RECTANGLES.
        pipelines: Vec::from([false, true].map(|rectangles| pipeline(plan, inputs.planned, rectangles))),
        draws: inputs.volumes.runs.iter().map(|run| draw(plan, run)).collect(),
        vertices: None,
        indices: None,
    };
    graph.add("light_volumes", Work::Render(render));
}

fn draw(plan: &Plan, run: &Run) -> Draw {
    let shape = if run.rectangles {
        Draw::procedural(RECTANGLES, 6, run.count, Cull::None)
    } else {
        Draw::procedural(MESHES, ICOSPHERE_CORNERS, run.count, Cull::Front)
    };
    // A lens that mirrors turns the faces round.
    Draw { instance_offset: run.first, mirrored: plan.view.lens.mirrors(), ..shape }
}

fn pipeline(plan: &Plan, planned: &Gbuffer, rectangles: bool) -> GraphicsPipeline {
    let (lights, gbuffer) = (light_constants(plan), gbuffer_constants(planned));
    let spec = light_volumes::Spec {
        LIGHT_FETCH: lights.fetch,
        LIGHT_KINDS: lights.kinds,
        LIGHT_TEXELS: lights.texels,
        LIGHT_UNIFORM_TEXELS: lights.uniform_texels,
        LIGHT_SEEK: false,
        INVERSE_SQUARE: lights.inverse_square,
        SHADOW_KINDS: lights.shadow_kinds,
        SHADOW_FILTER: lights.shadow_filter,
        BOUNCED: false,
        BOUNCED_STORAGE: false,
        SHADING: lights.shading,
        GBUFFER: gbuffer.layout,
        NORMAL_BITS: gbuffer.normal_bits,
        EMISSION: gbuffer.emission,
        STORED_MATERIAL: gbuffer.material,
        SAMPLES: 1,
        RECTANGLE: rectangles,
    };
    // Reversed: a back face passes where it is as far as what is stored, or farther.
    let compare = if rectangles { vk::CompareOp::ALWAYS } else { vk::CompareOp::LESS_OR_EQUAL };
    GraphicsPipeline {
        program: &light_volumes::PROGRAM,
        constants: spec.values(),
        colors: vec![radiance_format(plan)],
        blend: Blend::Add,
        depth: Some(DepthState::read(DEPTH_FORMAT, compare)),
        depth_clamp: false,
        samples: 1,
        sample_mask: u32::MAX,
    }
}
