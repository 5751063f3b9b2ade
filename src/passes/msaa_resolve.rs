//! MSAA resolve: the mean of each pixel's samples, once everything has been drawn.
//!
//! Reads: radiance of several samples. Writes: radiance of one. Limits: none of its own. CPU twin: `reference/render.rs`, which takes a ray
//! a sample.

use super::{RADIANCE_FORMAT, nearest_sampler, several_samples};
use crate::graph::access::FragmentSampled;
use crate::graph::{Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work};
use crate::shaders::shade::msaa_resolve;

/// Adds the pass; the picture. Nothing where `radiance` has one sample.
pub fn add(graph: &mut Graph, radiance: ImageHandle) -> ImageHandle {
    let Some(samples) = several_samples(graph, radiance) else { return radiance };
    let info = graph.image_info(samples);
    let (extent, count) = ([info.width, info.height], info.samples);
    let resolved = graph.image("radiance", RADIANCE_FORMAT, extent, Lifetime::Transient);
    let set = msaa_resolve::Bindings { radiance_samples: Some(FragmentSampled(samples, nearest_sampler())) };
    let pipeline = GraphicsPipeline::full_screen(
        &msaa_resolve::PROGRAM,
        msaa_resolve::Spec { SAMPLES: count }.values(),
        RADIANCE_FORMAT,
    );
    let render = Render::full_screen(resolved, extent, set.list(), vec![pipeline]);
    graph.add("msaa_resolve", Work::Render(render));
    resolved
}
