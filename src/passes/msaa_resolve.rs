//! MSAA resolve: the mean of each pixel's samples, once everything has been drawn.
//!
//! Reads: radiance of several samples. Writes: radiance of one. Limits: none of its own. CPU twin: `reference/render.rs`, which takes a ray
//! a sample.

use super::{RADIANCE_FORMAT, nearest_sampler, several_samples};
use crate::graph::access::FragmentSampled;
use crate::graph::{Blend, ColorAttachment, Draw, Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work};
use crate::shaders::shade::msaa_resolve;

/// Adds the pass; the picture. Nothing where `radiance` has one sample.
pub fn add(graph: &mut Graph, radiance: ImageHandle) -> ImageHandle {
    let Some(samples) = several_samples(graph, radiance) else { return radiance };
    let info = graph.image_info(samples);
    let (extent, count) = ([info.width, info.height], info.samples);
    let resolved = graph.image("radiance", RADIANCE_FORMAT, extent, Lifetime::Transient);
    let set = msaa_resolve::Bindings { radiance_samples: Some(FragmentSampled(samples, nearest_sampler())) };
    let pipeline = GraphicsPipeline {
        program: &msaa_resolve::PROGRAM,
        constants: msaa_resolve::Spec { SAMPLES: count }.values(),
        colors: vec![RADIANCE_FORMAT],
        samples: 1,
        sample_mask: u32::MAX,
        blend: Blend::Replace,
        depth: None,
        depth_clamp: false,
    };
    let render = Render {
        colors: vec![ColorAttachment { image: resolved, clear: Some([0.0; 4]) }],
        depth: None,
        extent,
        bindings: set.list(),
        material_bindings: Vec::new(),
        pipelines: vec![pipeline],
        draws: vec![Draw::full_screen(0)],
        vertices: None,
        indices: None,
    };
    graph.add("msaa_resolve", Work::Render(render));
    resolved
}
