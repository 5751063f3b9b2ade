//! Unlit surfaces (`KHR_materials_unlit`) over a deferred picture: their base colour, drawn forward against the same depth.
//!
//! Reads: frame, instances, materials, material textures, vertices, indices; depth, tested for equality after a pre-pass that has drawn
//! them, tested and written without one. Writes: radiance where they are nearest. Limits: none of its own. CPU twin:
//! `reference/shade.rs`.

use super::forward::{Io, depth_state};
use super::resources::chosen;
use super::{SceneHandles, radiance_format};
use crate::graph::access::{GraphicsStorageRead, VertexStorageRead, VertexUniform};
use crate::graph::{Blend, ColorAttachment, DepthAttachment, Graph, GraphicsPipeline, Render, Work};
use crate::plan::Plan;
use crate::plan::materials::Variant;
use crate::shaders::shade::unlit;

/// Adds the pass; nothing where every surface is lit.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, target: &Io) {
    let (distinct, draws) = chosen(plan, |v| v.unlit);
    if draws.is_empty() {
        return;
    }
    let set = unlit::Bindings {
        frame: VertexUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        materials: GraphicsStorageRead(scene.materials),
    };
    let render = Render {
        colors: vec![ColorAttachment { image: target.radiance, clear: None }],
        depth: Some(DepthAttachment { image: target.depth, clear: None }),
        extent: [plan.view.width, plan.view.height],
        bindings: set.list(),
        material_bindings: scene.material_bindings.clone(),
        pipelines: distinct.iter().map(|&v| pipeline(plan, v)).collect(),
        draws,
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("unlit", Work::Render(render));
}

fn pipeline(plan: &Plan, variant: Variant) -> GraphicsPipeline {
    let spec = unlit::Spec {
        TEXTURES: variant.textures,
        ALPHA_MASK: variant.masked,
        UV_SETS: variant.uv_sets,
        UV_TRANSFORMS: variant.uv_transforms,
        VERTEX_COLORS: variant.vertex_colors,
        UNLIT: true,
        MIRRORED_LENS: plan.view.lens.mirrors(),
        PERSPECTIVE: plan.view.lens.is_perspective(),
        SAMPLES: plan.samples,
    };
    GraphicsPipeline {
        program: &unlit::PROGRAM,
        constants: spec.values(),
        colors: vec![radiance_format(plan)],
        blend: Blend::Replace,
        depth: Some(depth_state(plan.prepass)),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}
