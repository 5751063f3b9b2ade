//! Depth pre-pass: the nearest depth of every pixel, so that shading runs once a pixel (Akenine-Möller et al., Real-Time Rendering,
//! 4th ed., section 18.4.5).
//!
//! Reads: frame, instances, vertices, indices; materials and base colour maps where a material is masked.
//! Writes: depth, cleared to 0 (reversed: 0 is infinitely far).
//! Opaque surfaces have no fragment stage. Limits: none of its own. CPU twin: `reference/render.rs` (nearest hit).

use ash::vk;

use super::resources::{draw, variants};
use super::{DEPTH_FORMAT, SceneHandles};
use crate::graph::access::{GraphicsStorageRead, VertexStorageRead, VertexUniform};
use crate::graph::{Blend, DepthAttachment, DepthState, Graph, GraphicsPipeline, ImageHandle, Render, Work};
use crate::plan::Plan;
use crate::plan::materials::Variant;
use crate::shaders::depth::{depth_prepass, depth_prepass_masked};
use crate::shared;

/// Later draws win ties, with and without a pre-pass.
pub const COMPARE: vk::CompareOp = vk::CompareOp::GREATER_OR_EQUAL;

/// Adds the pass; the depth image.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles) -> ImageHandle {
    let extent = [plan.view.width, plan.view.height];
    let depth = graph.image_of_samples("depth", DEPTH_FORMAT, extent, plan.samples);
    // Only holes matter for depth: every opaque material shares one pipeline.
    let (distinct, of_draw) = variants(plan, |v| if v.masked { alpha_only(v) } else { Variant::default() });
    let any_masked = distinct.iter().any(|v| v.masked);
    let bindings = if any_masked {
        let set = depth_prepass_masked::Bindings {
            frame: VertexUniform(scene.frame),
            instances: VertexStorageRead(scene.instances),
            materials: GraphicsStorageRead(scene.materials),
        };
        set.list()
    } else {
        let set = depth_prepass::Bindings {
            frame: VertexUniform(scene.frame),
            instances: VertexStorageRead(scene.instances),
        };
        set.list()
    };
    let draws = plan.geometry.draws.iter().zip(&of_draw).map(|(d, &p)| draw(plan, d, p)).collect();
    let render = Render {
        colors: Vec::new(),
        depth: Some(DepthAttachment { image: depth, clear: Some(0.0) }),
        extent,
        bindings,
        material_bindings: if any_masked { scene.material_bindings.clone() } else { Vec::new() },
        pipelines: distinct.iter().map(|&v| pipeline(plan, v)).collect(),
        draws,
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("depth_prepass", Work::Render(render));
    depth
}

/// What decides whether a masked fragment exists.
pub(super) fn alpha_only(variant: Variant) -> Variant {
    Variant {
        textures: variant.textures & (shared::TEXTURE_BASE_COLOR | shared::TEXTURE_HEIGHT),
        unlit: false,
        model: 0,
        ..variant
    }
}

fn pipeline(plan: &Plan, variant: Variant) -> GraphicsPipeline {
    let depth = Some(DepthState::write(DEPTH_FORMAT, COMPARE));
    let (program, constants) = if variant.masked {
        let spec = depth_prepass_masked::Spec {
            TEXTURES: variant.textures,
            ALPHA_MASK: true,
            UV_SETS: variant.uv_sets,
            UV_TRANSFORMS: variant.uv_transforms,
            VERTEX_COLORS: variant.vertex_colors,
            UNLIT: true,
            MIRRORED_LENS: plan.view.lens.mirrors(),
            PERSPECTIVE: plan.view.lens.is_perspective(),
            SAMPLES: plan.samples,
        };
        (&depth_prepass_masked::PROGRAM, spec.values())
    } else {
        (&depth_prepass::PROGRAM, Vec::new())
    };
    GraphicsPipeline {
        program,
        constants,
        colors: Vec::new(),
        blend: Blend::Replace,
        depth,
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}
