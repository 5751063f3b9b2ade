//! MSAA spread: samples that a compute pass left side by side become those of an image of several samples, so that something can be drawn over
//! them: a draw a sample, each of which writes its own.
//!
//! Reads: samples side by side. Writes: radiance of several samples. Limits: none of its own. CPU twin: none, it moves texels.

use super::{RADIANCE_FORMAT, nearest_sampler};
use crate::graph::access::FragmentSampled;
use crate::graph::{Blend, ColorAttachment, Draw, Graph, GraphicsPipeline, ImageHandle, Render, Work};
use crate::plan::Plan;
use crate::shaders::shade::msaa_spread;

/// Adds the pass; the image of several samples. Nothing where nothing is drawn over the picture.
pub fn add(graph: &mut Graph, plan: &Plan, texels: ImageHandle) -> ImageHandle {
    if !plan.spreads_samples() {
        return texels;
    }
    let extent = [plan.view.width, plan.view.height];
    let samples = graph.image_of_samples("radiance_samples", RADIANCE_FORMAT, extent, plan.samples);
    let set = msaa_spread::Bindings { radiance_texels: FragmentSampled(texels, nearest_sampler()) };
    let pipeline = |sample: u32| GraphicsPipeline {
        program: &msaa_spread::PROGRAM,
        constants: msaa_spread::Spec { SAMPLES: plan.samples, SAMPLE: sample }.values(),
        colors: vec![RADIANCE_FORMAT],
        samples: plan.samples,
        sample_mask: 1 << sample,
        blend: Blend::Replace,
        depth: None,
        depth_clamp: false,
    };
    let render = Render {
        colors: vec![ColorAttachment { image: samples, clear: Some([0.0; 4]) }],
        depth: None,
        extent,
        bindings: set.list(),
        material_bindings: Vec::new(),
        pipelines: (0..plan.samples).map(pipeline).collect(),
        draws: (0..plan.samples as usize).map(Draw::full_screen).collect(),
        vertices: None,
        indices: None,
    };
    graph.add("msaa_spread", Work::Render(render));
    samples
}
