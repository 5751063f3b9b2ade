//! Light markers (`--show-lights`): a small sphere of each light's colour where it stands, drawn forward over any technique's picture.
//!
//! Reads: frame, markers, the mesh's corners. Reads and writes: depth, so that markers hide each other. Writes: radiance. Limits: none of
//! its own. CPU twin: none, the reference draws no markers.

use super::depth_prepass::COMPARE;
use super::forward::Io;
use super::{DEPTH_FORMAT, SceneHandles, radiance_format};
use crate::graph::access::{VertexStorageRead, VertexUniform};
use crate::graph::{
    Blend, ColorAttachment, Cull, DepthAttachment, DepthState, Draw, Graph, GraphicsPipeline, Render, Work,
};
use crate::plan::Plan;
use crate::shaders::shade::light_markers;
use crate::shared::ICOSPHERE_CORNERS;

/// Adds the pass; nothing where no marker is wanted.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, target: &Io) {
    let (Some(markers), Some(corners)) = (scene.light_markers, scene.corners) else { return };
    let set = light_markers::Bindings {
        frame: VertexUniform(scene.frame),
        light_markers: VertexStorageRead(markers),
        corners: VertexUniform(corners),
    };
    let pipeline = GraphicsPipeline {
        program: &light_markers::PROGRAM,
        constants: Vec::new(),
        colors: vec![radiance_format(plan)],
        blend: Blend::Replace,
        depth: Some(DepthState::write(DEPTH_FORMAT, COMPARE)),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    };
    let count = plan.markers.len() as u32;
    let draw = Draw::procedural(0, ICOSPHERE_CORNERS, count, Cull::Back);
    let render = Render {
        colors: vec![ColorAttachment { image: target.radiance, clear: None }],
        depth: Some(DepthAttachment { image: target.depth, clear: None }),
        extent: [plan.view.width, plan.view.height],
        bindings: set.list(),
        material_bindings: Vec::new(),
        pipelines: vec![pipeline],
        draws: vec![Draw { mirrored: plan.view.lens.mirrors(), ..draw }],
        vertices: None,
        indices: None,
    };
    graph.add("light_markers", Work::Render(render));
}
