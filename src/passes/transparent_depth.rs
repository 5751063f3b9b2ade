//! Transparent depth: the nearest blended fragment of every pixel that no opaque surface hides, so that tiles know where blended surfaces
//! are.
//!
//! Reads: frame, instances, vertices, indices, opaque depth. Writes: a depth of its own, 0 where there is no such fragment. Limits: none
//! of its own; alpha is not asked for. CPU twin: `reference/render.rs` (hits in order).

use super::depth_prepass::COMPARE;
use super::resources::blended;
use super::{DEPTH_FORMAT, SceneHandles, nearest_sampler, one_sample, several_samples};
use crate::graph::access::{FragmentSampled, VertexStorageRead, VertexUniform};
use crate::graph::{Blend, DepthAttachment, DepthState, Draw, Graph, GraphicsPipeline, ImageHandle, Render, Work};
use crate::plan::Plan;
use crate::shaders::depth::transparent_depth;

/// Adds the pass; the image of depths.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, opaque: ImageHandle) -> ImageHandle {
    let extent = [plan.view.width, plan.view.height];
    let depth = graph.image_of_samples("transparent_depth", DEPTH_FORMAT, extent, plan.samples);
    let set = transparent_depth::Bindings {
        frame: VertexUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        // Of several samples the other binding is read.
        opaque_depth: FragmentSampled(one_sample(graph, scene, opaque), nearest_sampler()),
        opaque_samples: several_samples(graph, opaque).map(|image| FragmentSampled(image, nearest_sampler())),
    };
    let pipeline = GraphicsPipeline {
        program: &transparent_depth::PROGRAM,
        constants: transparent_depth::Spec { SAMPLES: plan.samples }.values(),
        colors: Vec::new(),
        blend: Blend::Replace,
        depth: Some(DepthState::write(DEPTH_FORMAT, COMPARE)),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    };
    let render = Render {
        colors: Vec::new(),
        depth: Some(DepthAttachment { image: depth, clear: Some(0.0) }),
        extent,
        bindings: set.list(),
        material_bindings: Vec::new(),
        pipelines: vec![pipeline],
        draws: of_one_pipeline(plan),
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("transparent_depth", Work::Render(render));
    depth
}

/// Draws of blended surfaces by the only pipeline of a scope, which asks no material.
pub(super) fn of_one_pipeline(plan: &Plan) -> Vec<Draw> {
    blended(plan).1.into_iter().map(|draw| Draw { pipeline: 0, material: None, ..draw }).collect()
}
