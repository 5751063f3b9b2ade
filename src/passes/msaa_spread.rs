//! MSAA spread: samples that a compute pass left side by side become those of an image of several samples, so that something can be drawn over
//! them: a draw a sample, each of which writes its own.
//!
//! Reads: samples side by side. Writes: radiance of several samples. Limits: none of its own. CPU twin: none, it moves texels.

use super::{RADIANCE_FORMAT, nearest_sampler};
use crate::graph::access::FragmentSampled;
use crate::graph::{Graph, GraphicsPipeline, ImageHandle, Render, Work};
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
    let pipelines = (0..plan.samples).map(|sample| {
        let spec = msaa_spread::Spec { SAMPLES: plan.samples, SAMPLE: sample };
        let pipeline = GraphicsPipeline::full_screen(&msaa_spread::PROGRAM, spec.values(), RADIANCE_FORMAT);
        GraphicsPipeline { samples: plan.samples, sample_mask: 1 << sample, ..pipeline }
    });
    let render = Render::full_screen(samples, extent, set.list(), pipelines.collect());
    graph.add("msaa_spread", Work::Render(render));
    samples
}
