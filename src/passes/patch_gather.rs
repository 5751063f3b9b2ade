//! Patch gather: light of all patches at each of them, a product with the exchange matrix, and a step of Chebyshev's iteration with it (G. Golub,
//! R. Varga, "Chebyshev semi-iterative methods", 1961). A node a step.
//!
//! Reads: the matrix, patches, light as the step before left it. Writes: light as this one leaves it.
//! Group shape: as many threads as run in step, 32 at most, for four rows; their sums are added in a fixed order. Limits: a matrix that is bound at once; the plan refuses others.
//! CPU twins: `radiosity/codec/`, `radiosity/solve.rs`.

use ash::vk;
use bytemuck::bytes_of;

use super::nearest_sampler;
use super::resources::{BouncedHandles, SceneHandles};
use super::{patch_light, patch_product};
use crate::graph::access::{ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel};
use crate::graph::{BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::plan::bounced::Carried;
use crate::plan::bounced::matrix::{MatrixFormat, Parts};
use crate::plan::{Bounced, Plan};
use crate::shaders::radiosity::patch_gather;
use crate::shared::{GatherPush, MOST_GROUPS, PatchLight};

/// Adds all steps, and before them what patches send at first, where the plan has bounced light; what shading reads stands in `scene`.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &mut SceneHandles) {
    let Some(bounced) = &plan.bounced else { return };
    let fixed = Lifetime::Static;
    let light_bytes = (bounced.patches.len() * size_of::<PatchLight>()) as u64;
    let carries = bounced.carried != Carried::Nothing;
    let two = bounced.steps.len() > 1 || !carries;
    let names: &[&str] = if two { &["patch_light", "patch_light_2"] } else { &["patch_light"] };
    let mut lights: Vec<BufferHandle> =
        names.iter().map(|name| graph.buffer(name, light_bytes, Lifetime::Transient)).collect();
    let kept = carries.then(|| graph.buffer("patch_light_kept", light_bytes, Lifetime::Kept));
    let mut of = BouncedHandles {
        places: graph.buffer("bounced_places", bounced.places.len() as u64 * 16, fixed),
        words: graph.word_buffer("bounced_words", bounced.bake.transfer.words.len() as u64 * 4, fixed),
        patches: graph.buffer("patches", size_of_val(bounced.patches.as_slice()) as u64, fixed),
        points: graph.buffer("patch_points", bounced.points.len() as u64 * 24, fixed),
        matrix: graph.word_buffer("patch_matrix", bounced.matrix.words.len() as u64 * 4, fixed),
        matrix_image: bounced
            .matrix
            .image
            .as_ref()
            .map(|image| graph.image("patch_matrix_image", image_format(image.format), [image.side; 2], fixed)),
        light: lights[0],
    };
    patch_light::add(graph, plan, scene, &of, (lights[0], kept));
    for (step, &[share, weight]) in bounced.steps.iter().enumerate() {
        let last = step + 1 == bounced.steps.len();
        let after = kept.filter(|_| last).unwrap_or_else(|| lights[lights.len() - 1]);
        let ends = [lights[0], after];
        let work = match bounced.matrix.parts {
            Parts::Gather(push) => gather(bounced, &of, ends, GatherPush { step: share, weight, ..push }),
            Parts::Product(push) => patch_product::work(bounced, &of, ends, push),
        };
        let name = match bounced.matrix.parts {
            Parts::Gather(_) => format!("patch_gather_{step}"),
            Parts::Product(_) => "patch_product".into(),
        };
        graph.add(&name, work);
        lights.reverse();
    }
    of.light = kept.unwrap_or(lights[0]);
    scene.bounced = Some(of);
}

fn image_format(format: MatrixFormat) -> vk::Format {
    match format {
        MatrixFormat::Float => vk::Format::R32_SFLOAT,
        MatrixFormat::Bc1 => vk::Format::BC1_RGB_UNORM_BLOCK,
        MatrixFormat::Bc4 => vk::Format::BC4_UNORM_BLOCK,
    }
}

fn gather(bounced: &Bounced, of: &BouncedHandles, [before, after]: [BufferHandle; 2], push: GatherPush) -> Work {
    let matrix = &bounced.matrix;
    let set = patch_gather::Bindings {
        words: ComputeStorageRead(of.matrix),
        patches: ComputeStorageRead(of.patches),
        before: ComputeStorageRead(before),
        after: ComputeStorageWrite(after),
        bounced_matrix_texels: Some(ComputeTexel(of.matrix)),
        bounced_sent: Some(ComputeTexel(before)),
        bounced_matrix_image: of.matrix_image.map(|image| ComputeSampled(image, nearest_sampler())),
    };
    let spec = patch_gather::Spec {
        CODEC: matrix.codec,
        MATRIX_PATH: matrix.path,
        THREAD_ROWS: bounced.thread_rows,
        GROUP_SIZE: bounced.lanes,
        GREY: bounced.grey,
    };
    let groups = push.count.div_ceil(if bounced.thread_rows { bounced.lanes } else { 4 });
    Work::Dispatch {
        pipeline: ComputePipeline { program: &patch_gather::PROGRAM, constants: spec.values() },
        bindings: set.list(),
        push: bytes_of(&push).to_vec(),
        groups: Groups::Fixed([groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]),
    }
}
