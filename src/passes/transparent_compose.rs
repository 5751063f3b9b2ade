//! Transparent compose: mixes the layer that blended surfaces were drawn into with the picture, on devices that do not blend 32-bit floats; of
//! several samples a pixel it leaves the mean.
//!
//! Reads: radiance, layer (premultiplied by alpha). Writes: radiance in a second image. Limits: the layer holds 11 bits of a colour and at
//! most 65504. CPU twin: `reference/render.rs`.

use super::{RADIANCE_FORMAT, SceneHandles, nearest_sampler, one_sample, several_samples};
use crate::graph::access::FragmentSampled;
use crate::graph::{Graph, GraphicsPipeline, ImageHandle, Lifetime, Render, Work};
use crate::plan::Plan;
use crate::shaders::shade::transparent_compose;

/// Adds the pass; the mixed picture.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    radiance: ImageHandle,
    layer: ImageHandle,
) -> ImageHandle {
    let extent = [plan.view.width, plan.view.height];
    let mixed = graph.image("radiance_mixed", RADIANCE_FORMAT, extent, Lifetime::Transient);
    let sampled = |image| FragmentSampled(image, nearest_sampler());
    let set = transparent_compose::Bindings {
        radiance: sampled(one_sample(graph, scene, radiance)),
        transparent_layer: sampled(one_sample(graph, scene, layer)),
        radiance_samples: several_samples(graph, radiance).map(sampled),
        layer_samples: several_samples(graph, layer).map(sampled),
    };
    let pipeline = GraphicsPipeline::full_screen(
        &transparent_compose::PROGRAM,
        transparent_compose::Spec { SAMPLES: plan.samples }.values(),
        RADIANCE_FORMAT,
    );
    let render = Render::full_screen(mixed, extent, set.list(), vec![pipeline]);
    graph.add("transparent_compose", Work::Render(render));
    mixed
}
