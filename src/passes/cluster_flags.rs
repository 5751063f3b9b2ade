//! Cluster flags: the slices of tiles that hold blended fragments which no opaque surface hides, or samples where a pixel has several, as
//! clusters in ascending order (O. Olsson, M. Billeter, U. Assarsson, HPG 2012, section 6.1: transparent surfaces flag their clusters in a
//! pass of their own).
//!
//! Reads: frame, instances, vertices, indices, depth (tested), tile grid, cluster grid. Writes: keys of flagged clusters, their number, an
//! R32_UINT image of the place of each slice of a tile among them (`NO_CLUSTER` where none). Steps: fill, draw (fragments store 1, all of them the
//! same), scan, compact; groups of 64, a thread a slice. Limits: fragment shaders that write buffers, else the plan has no flags. CPU twin:
//! `reference/cluster_keys.rs` over the same fragments.

use ash::vk;

use super::cluster_assign::Keyed;
use super::cluster_keys::{add_total, words};
use super::cluster_lists::Parts;
use super::group_count::{self, rows};
use super::transparent_depth::of_one_pipeline;
use super::{SceneHandles, dispatch, nearest_sampler, scan};
use crate::graph::access::{
    ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeUniform, FragmentStorageWrite,
    FragmentUniform, VertexStorageRead, VertexUniform,
};
use crate::graph::{
    Blend, BufferHandle, Contents, DepthAttachment, DepthState, Graph, GraphicsPipeline, ImageHandle, Lifetime, Render,
    Work,
};
use crate::plan::Plan;
use crate::shaders::cluster::{cluster_flags, cluster_ranks, cluster_sample_flags};
use crate::shared::CELLS_WIDE;

/// Adds the steps for the clusters of blended surfaces in `parts`; the flagged ones, and the image of their places.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    parts: &Parts,
    depth: ImageHandle,
) -> (Keyed, ImageHandle) {
    let flags = cleared(graph, "transparent_flags", parts);
    graph.add("cluster_flags", Work::Render(render(plan, scene, parts, depth, flags)));
    flagged(graph, "transparent_", parts, flags)
}

/// Adds the steps for the clusters of samples, where `depth` has several a pixel.
pub fn add_samples(graph: &mut Graph, parts: &Parts, depth: ImageHandle) -> (Keyed, ImageHandle) {
    let flags = cleared(graph, "flags", parts);
    let info = graph.image_info(depth);
    let groups = [info.width.div_ceil(8), info.height.div_ceil(8), 1];
    let spec = cluster_sample_flags::Spec { TILE: parts.tiles.tile, SAMPLES: info.samples };
    let set = cluster_sample_flags::Bindings {
        grid: ComputeUniform(parts.tile_handles.grid),
        clusters: ComputeUniform(parts.handles.grid),
        depth_samples: Some(ComputeSampled(depth, nearest_sampler())),
        cluster_flags: ComputeStorageWrite(flags),
    };
    let work = dispatch(&cluster_sample_flags::PROGRAM, spec.values(), set.list(), groups);
    graph.add("cluster_sample_flags", work);
    flagged(graph, "", parts, flags)
}

fn cleared(graph: &mut Graph, name: &str, parts: &Parts) -> BufferHandle {
    let flags = words(graph, name, u64::from(parts.clusters.grid.capacity));
    graph.add(&format!("fill_{name}"), Work::Fill { buffer: flags, word: 0 });
    flags
}

/// Adds the steps from flags to clusters; names begin with `prefix`.
fn flagged(graph: &mut Graph, prefix: &str, parts: &Parts, flags: BufferHandle) -> (Keyed, ImageHandle) {
    let capacity = parts.clusters.grid.capacity;
    let offsets = scan::add(graph, &format!("{prefix}flag"), flags, capacity);
    let total = add_total(graph, &format!("{prefix}cluster_total"), offsets, capacity, None);
    let counted = group_count::add(graph, &format!("{prefix}cluster"), total, capacity, 1);
    let keys = words(graph, &format!("{prefix}cluster_keys"), u64::from(capacity));
    let size = [CELLS_WIDE, capacity.div_ceil(CELLS_WIDE).max(1)];
    let name = format!("{prefix}cluster_ranks");
    let ranks = graph.image(&name, vk::Format::R32_UINT, size, Lifetime::Transient);
    let set = cluster_ranks::Bindings {
        grid: ComputeUniform(parts.tile_handles.grid),
        clusters: ComputeUniform(parts.handles.grid),
        flag_offsets: ComputeStorageRead(offsets),
        cluster_keys: ComputeStorageWrite(keys),
        cluster_ranks: ComputeImageWrite(ranks, Contents::Discarded),
    };
    graph.add(&name, dispatch(&cluster_ranks::PROGRAM, Vec::new(), set.list(), rows(capacity)));
    // Bounds are those of slices: nothing reads boxes.
    (Keyed { keys, bounds: keys, counted }, ranks)
}

fn render(plan: &Plan, scene: &SceneHandles, parts: &Parts, depth: ImageHandle, flags: BufferHandle) -> Render {
    let set = cluster_flags::Bindings {
        frame: VertexUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        grid: FragmentUniform(parts.tile_handles.grid),
        clusters: FragmentUniform(parts.handles.grid),
        cluster_flags: FragmentStorageWrite(flags),
    };
    let spec = cluster_flags::Spec { TILE: parts.tiles.tile };
    let pipeline = GraphicsPipeline {
        program: &cluster_flags::PROGRAM,
        constants: spec.values(),
        colors: Vec::new(),
        blend: Blend::Replace,
        depth: Some(DepthState { write: false, ..super::forward::depth_state(false) }),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    };
    Render {
        colors: Vec::new(),
        depth: Some(DepthAttachment { image: depth, clear: None }),
        extent: [plan.view.width, plan.view.height],
        bindings: set.list(),
        material_bindings: Vec::new(),
        pipelines: vec![pipeline],
        draws: of_one_pipeline(plan),
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    }
}
