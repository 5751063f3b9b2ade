//! Light parts: a sum over more lights than a driver's loops go round, as passes that continue it (plan/light_parts.rs). Not by blending:
//! each pass reads what the one before it left and writes the other of two images, so every sum is added up in id order and clamped once,
//! whatever the number of passes.
//!
//! Reads: what the technique reads, and the sum so far. Writes: the sum with the number of its lights in alpha; the last pass writes
//! radiance. Depth is tested, and without a pre-pass cleared and written, by each pass alike. Limits: the plan's. CPU twin: as the technique.

use super::{RADIANCE_FORMAT, SceneHandles, nearest_sampler};
use crate::graph::access::FragmentSampled;
use crate::graph::{Graph, ImageHandle, Lifetime, Render, Work};
use crate::plan::Plan;

/// One pass of a sum.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// FIRST_PART: nothing has been added up yet.
    pub first: bool,
    /// LAST_PART: it writes the picture.
    pub last: bool,
    /// PART_LIGHTS.
    pub lights: u32,
    /// What it writes.
    pub target: ImageHandle,
    /// As the shader's `radiance_before`; a texel that nothing reads ahead of the first pass.
    pub before: FragmentSampled,
}

/// Adds a node for each part, `name` where there is one and else with its number behind; the radiance.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    name: &str,
    render: impl Fn(&Part) -> Render,
) -> ImageHandle {
    let (extent, parts) = ([plan.view.width, plan.view.height], plan.light_parts);
    let name_of = if plan.samples > 1 { "radiance_samples" } else { "radiance" };
    let radiance = graph.image_of_samples(name_of, RADIANCE_FORMAT, extent, plan.samples);
    let other = (parts.count > 1).then(|| graph.image("radiance_before", RADIANCE_FORMAT, extent, Lifetime::Transient));
    let other = other.unwrap_or(radiance);
    let nothing = scene.textures.last().copied().unwrap_or(radiance);
    for index in 0..parts.count {
        let left = parts.count - 1 - index;
        let [target, before] = if left % 2 == 0 { [radiance, other] } else { [other, radiance] };
        let first = index == 0;
        let before = FragmentSampled(if first { nothing } else { before }, nearest_sampler());
        let part = Part { first, last: left == 0, lights: parts.lights, target, before };
        let name = if parts.count == 1 { name.to_string() } else { format!("{name}_{index}") };
        graph.add(&name, Work::Render(render(&part)));
    }
    radiance
}
