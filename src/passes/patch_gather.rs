//! Patch gather: light of all patches at each of them, a product with the exchange matrix, and a step of Chebyshev's iteration with it (G. Golub,
//! R. Varga, "Chebyshev semi-iterative methods", 1961). A node a step.
//!
//! Reads: the matrix, patches, light as the step before left it. Writes: light as this one leaves it.
//! Group shape: 32 threads for four rows, whose sums are added in a fixed order. Limits: a matrix that is bound at once; the plan refuses others.
//! CPU twins: `radiosity/codec/`, `radiosity/solve.rs`.

use bytemuck::bytes_of;

use super::patch_light;
use super::resources::{BouncedHandles, SceneHandles};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::{ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::plan::{Bounced, Plan};
use crate::shaders::radiosity::patch_gather;
use crate::shared::{GatherPush, MOST_GROUPS, PatchLight};

/// Adds all steps, and before them what patches send at first, where the plan has bounced light; what shading reads stands in `scene`.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &mut SceneHandles) {
    let Some(bounced) = &plan.bounced else { return };
    let fixed = Lifetime::Static;
    let light_bytes = (bounced.patches.len() * size_of::<PatchLight>()) as u64;
    let mut lights = ["patch_light", "patch_light_2"].map(|name| graph.buffer(name, light_bytes, Lifetime::Transient));
    let mut of = BouncedHandles {
        places: graph.buffer("bounced_places", bounced.places.len() as u64 * 16, fixed),
        words: graph.word_buffer("bounced_words", bounced.bake.transfer.words.len() as u64 * 4, fixed),
        patches: graph.buffer("patches", size_of_val(bounced.patches.as_slice()) as u64, fixed),
        points: graph.buffer("patch_points", bounced.points.len() as u64 * 12, fixed),
        matrix: graph.buffer("patch_matrix", bounced.matrix.len() as u64 * 4, fixed),
        light: lights[0],
    };
    patch_light::add(graph, plan, scene, &of, lights[0]);
    for (step, &[share, weight]) in bounced.steps.iter().enumerate() {
        let set = patch_gather::Bindings {
            words: ComputeStorageRead(of.matrix),
            patches: ComputeStorageRead(of.patches),
            before: ComputeStorageRead(lights[0]),
            after: ComputeStorageWrite(lights[1]),
        };
        graph.add(&format!("patch_gather_{step}"), gather(bounced, set.list(), [share, weight]));
        lights.swap(0, 1);
    }
    of.light = lights[0];
    scene.bounced = Some(of);
}

fn gather(bounced: &Bounced, bindings: Vec<crate::graph::Binding>, [step, weight]: [f32; 2]) -> Work {
    let spec = patch_gather::Spec { CODEC: bounced.codec };
    let push = GatherPush { step, weight, ..bounced.push };
    let groups = bounced.push.count.div_ceil(4);
    Work::Dispatch {
        pipeline: ComputePipeline { program: &patch_gather::PROGRAM, constants: spec.values() },
        bindings,
        push: bytes_of(&push).to_vec(),
        groups: Groups::Fixed([groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]),
    }
}
