//! Surface probe: stores what the lights see (position, normal, base colour, roughness ...) in f32 instead of lighting it. Debug
//! views show it, and oracles are fed with it, so that a rasteriser's interpolation does not count as a shading error.
//!
//! Reads: as `forward`, without lights. Writes: four RGBA32F layers, and depth without a pre-pass.
//! Limits: exactly the four colour attachments that every driver grants. CPU twin: `reference/surface.rs`.

use super::forward::depth_state;
use super::resources::{draw, variants};
use super::{DEPTH_FORMAT, RADIANCE_FORMAT, SceneHandles};
use crate::graph::access::{GraphicsStorageRead, VertexStorageRead, VertexUniform};
use crate::graph::{
    Blend, ColorAttachment, DepthAttachment, Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work,
};
use crate::plan::Plan;
use crate::plan::materials::Variant;
use crate::shaders::shade::surface;

/// Names of the layers, in attachment order: position.xyz and roughness, normal.xyz and occlusion, base colour and metalness,
/// emission and a flag (0 nothing; 1 lit, 2 unlit, and four times the number of the material).
pub const LAYERS: [&str; 4] = ["position_roughness", "normal_occlusion", "base_metallic", "emissive_flags"];

/// Adds the pass; its layers and depth by name.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    prepass: Option<ImageHandle>,
) -> [(&'static str, ImageHandle); 5] {
    let extent = [plan.view.width, plan.view.height];
    let depth = prepass.unwrap_or_else(|| graph.image("depth", DEPTH_FORMAT, extent, Lifetime::Transient));
    let layers = LAYERS.map(|name| graph.image(name, RADIANCE_FORMAT, extent, Lifetime::Transient));
    let (distinct, of_draw) = variants(plan, |v| v);
    let set = surface::Bindings {
        frame: VertexUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        materials: GraphicsStorageRead(scene.materials),
    };
    let pipelines = distinct.iter().map(|v| GraphicsPipeline {
        program: &surface::PROGRAM,
        constants: constants(plan, *v),
        colors: vec![RADIANCE_FORMAT; LAYERS.len()],
        blend: Blend::Replace,
        depth: Some(depth_state(prepass.is_some())),
        depth_clamp: false,
        samples: 1,
        sample_mask: u32::MAX,
    });
    let render = Render {
        colors: layers.map(|image| ColorAttachment { image, clear: Some([0.0; 4]) }).to_vec(),
        depth: Some(DepthAttachment { image: depth, clear: prepass.is_none().then_some(0.0) }),
        extent,
        bindings: set.list(),
        material_bindings: scene.material_bindings.clone(),
        pipelines: pipelines.collect(),
        draws: plan.geometry.draws.iter().zip(&of_draw).map(|(d, &p)| draw(plan, d, p)).collect(),
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("surface", Work::Render(render));
    let [a, b, c, d] = layers;
    [(LAYERS[0], a), (LAYERS[1], b), (LAYERS[2], c), (LAYERS[3], d), ("depth", depth)]
}

fn constants(plan: &Plan, variant: Variant) -> Vec<(u32, u32)> {
    let spec = surface::Spec {
        TEXTURES: variant.textures,
        ALPHA_MASK: variant.masked,
        UV_SETS: variant.uv_sets,
        UV_TRANSFORMS: variant.uv_transforms,
        VERTEX_COLORS: variant.vertex_colors,
        UNLIT: variant.unlit,
        MIRRORED_LENS: plan.view.lens.mirrors(),
        PERSPECTIVE: plan.view.lens.is_perspective(),
        SAMPLES: 1,
    };
    spec.values()
}
