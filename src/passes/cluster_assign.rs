//! Light assignment: which lights of its tile touch a cluster, in id order (O. Olsson, M. Billeter, U. Assarsson, HPG 2012, section 3.4).
//!
//! Reads: tile grid, lights to cull, tile lists, tile edges, slices; keys and boxes of clusters, where there are any. Writes: cluster lists
//! and where each begins. Steps: cells (what is asked of each cluster, in one image), count, scan, fill; groups of 64, a thread a cluster.
//! Threads beyond the number of clusters, which only the device knows, do nothing. Limits: the plan sizes the lists for the most there can
//! be. CPU twin: `reference/cluster_assign.rs`.

use ash::vk;

use super::cluster_keys::{groups, words};
use super::tile_bin::cull_fetch;
use super::tile_cull::{Lists, list_fetch};
use super::{ClusterHandles, TileHandles, dispatch, nearest_sampler, scan};
use crate::graph::access::{
    ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform,
};
use crate::graph::{BufferHandle, Contents, Graph, ImageHandle, Lifetime, Work};
use crate::plan::{ClusterBounds, Clusters, Tiles};
use crate::shaders::cluster::{cluster_cells, cluster_count, cluster_fill};
use crate::shared::{ASSIGN_TILE, CELL_TEXELS, CELLS_WIDE};

/// Clusters that own samples.
#[derive(Debug, Clone, Copy)]
pub struct Keyed {
    /// u32 a cluster: its key.
    pub keys: BufferHandle,
    /// `BOX_WORDS` floats a cluster, where bounds are explicit.
    pub bounds: BufferHandle,
    /// One u32: how many there are.
    pub total: BufferHandle,
}

/// What the pass needs.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// The plan's tiles.
    pub tiles: &'a Tiles,
    /// Their static buffers.
    pub tile_handles: &'a TileHandles,
    /// The plan's clusters.
    pub clusters: &'a Clusters,
    /// Their static buffers.
    pub handles: &'a ClusterHandles,
    /// Candidates.
    pub tile_lists: Lists,
    /// `None` where every slice of every tile is a cluster.
    pub keyed: Option<Keyed>,
}

/// Adds the steps.
pub fn add(graph: &mut Graph, inputs: &Inputs) -> Lists {
    let capacity = inputs.clusters.grid.capacity;
    let total = inputs.keyed.map_or_else(|| every_cluster(graph, capacity), |keyed| keyed.total);
    let cells = cells(graph, inputs, total);
    let counts = words(graph, "cluster_counts", u64::from(capacity));
    count(graph, inputs, [total, counts], cells);
    let offsets = scan::add(graph, "cluster", counts, capacity);
    let lights = words(graph, "cluster_lights", inputs.clusters.pairs);
    fill(graph, inputs, total, cells, Lists { lights, offsets });
    Lists { lights, offsets }
}

/// The number of clusters where the plan knows it.
fn every_cluster(graph: &mut Graph, count: u32) -> BufferHandle {
    let total = words(graph, "cluster_total", 1);
    graph.add("fill_cluster_total", Work::Fill { buffer: total, word: count });
    total
}

fn explicit(clusters: &Clusters) -> bool {
    clusters.bounds == ClusterBounds::Explicit
}

fn cells(graph: &mut Graph, inputs: &Inputs, total: BufferHandle) -> ImageHandle {
    let capacity = inputs.clusters.grid.capacity;
    let size = [CELLS_WIDE * CELL_TEXELS, capacity.div_ceil(CELLS_WIDE).max(1)];
    let cells = graph.image("cluster_cells", vk::Format::R32G32B32A32_UINT, size, Lifetime::Transient);
    let offsets = inputs.tile_lists.offsets;
    let set = cluster_cells::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        clusters: ComputeUniform(inputs.handles.grid),
        cluster_total: ComputeTexel(total),
        cluster_slices: ComputeTexel(inputs.handles.slices),
        tile_offsets: ComputeStorageRead(offsets),
        // Not read where there are none; something has to be bound.
        cluster_keys: ComputeStorageRead(inputs.keyed.map_or(offsets, |keyed| keyed.keys)),
        cluster_bounds: ComputeStorageRead(inputs.keyed.map_or(offsets, |keyed| keyed.bounds)),
        cluster_cells: ComputeImageWrite(cells, Contents::Discarded),
    };
    let spec = cluster_cells::Spec { DENSE: inputs.keyed.is_none(), EXPLICIT: explicit(inputs.clusters) };
    graph.add("cluster_cells", dispatch(&cluster_cells::PROGRAM, spec.values(), set.list(), groups(capacity)));
    cells
}

fn count(graph: &mut Graph, inputs: &Inputs, [total, counts]: [BufferHandle; 2], cells: ImageHandle) {
    let set = cluster_count::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(inputs.tile_handles.lights),
        cull_lights_texel: ComputeTexel(inputs.tile_handles.lights),
        tile_lights_storage: ComputeStorageRead(inputs.tile_lists.lights),
        tile_lights_texel: ComputeTexel(inputs.tile_lists.lights),
        clusters: ComputeUniform(inputs.handles.grid),
        cluster_total: ComputeTexel(total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(inputs.tile_handles.edges),
        cluster_counts: ComputeStorageWrite(counts),
    };
    let spec = cluster_count::Spec {
        CULL_FETCH: cull_fetch(inputs.tiles),
        LIST_FETCH: list_fetch(inputs.tiles),
        EXPLICIT: explicit(inputs.clusters),
        ASSIGN: ASSIGN_TILE,
    };
    let threads = groups(inputs.clusters.grid.capacity);
    graph.add("cluster_count", dispatch(&cluster_count::PROGRAM, spec.values(), set.list(), threads));
}

fn fill(graph: &mut Graph, inputs: &Inputs, total: BufferHandle, cells: ImageHandle, lists: Lists) {
    let set = cluster_fill::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(inputs.tile_handles.lights),
        cull_lights_texel: ComputeTexel(inputs.tile_handles.lights),
        tile_lights_storage: ComputeStorageRead(inputs.tile_lists.lights),
        tile_lights_texel: ComputeTexel(inputs.tile_lists.lights),
        clusters: ComputeUniform(inputs.handles.grid),
        cluster_total: ComputeTexel(total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(inputs.tile_handles.edges),
        cluster_offsets: ComputeStorageRead(lists.offsets),
        cluster_lights: ComputeStorageWrite(lists.lights),
    };
    let spec = cluster_fill::Spec {
        CULL_FETCH: cull_fetch(inputs.tiles),
        LIST_FETCH: list_fetch(inputs.tiles),
        EXPLICIT: explicit(inputs.clusters),
        ASSIGN: ASSIGN_TILE,
    };
    let threads = groups(inputs.clusters.grid.capacity);
    graph.add("cluster_fill", dispatch(&cluster_fill::PROGRAM, spec.values(), set.list(), threads));
}
