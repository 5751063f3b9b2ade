//! Cluster keys: the clusters that own samples, in ascending order of tile, slice and, where asked for, direction (O. Olsson, M.
//! Billeter, U. Assarsson, "Clustered Deferred and Forward Shading", HPG 2012, section 3).
//!
//! Reads: tile grid, cluster grid, depth, codes of normals where clusters tell directions. Writes: keys of each block and where they lie
//! among those of all blocks, all of them side by side, their number. Steps: sort the keys of each block, each once (groups of 64, a
//! thread a block of at most 256 samples: a serial run is what CPU drivers are fastest at), scan, compact. Sky has no key. Limits: the
//! plan sizes a block for a key a sample, or a slice and direction. CPU twin: `reference/cluster_keys.rs`.

use super::group_count::{self, Counted, rows};
use super::{dispatch, nearest_sampler, scan};
use crate::graph::access::{
    ComputeSampled, ComputeStorageRead, ComputeStorageReadWrite, ComputeStorageWrite, ComputeUniform,
};
use crate::graph::{BufferHandle, Graph, ImageHandle, Lifetime};
use crate::plan::Clusters;
use crate::shaders::cluster::{cluster_compact, cluster_keys, cluster_total};

/// What the pass needs.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// The plan's clusters.
    pub clusters: &'a Clusters,
    /// One `TileGrid`.
    pub tile_grid: BufferHandle,
    /// One `ClusterGrid`.
    pub cluster_grid: BufferHandle,
    /// D32F, reversed.
    pub depth: ImageHandle,
    /// Codes of normals where the plan's clusters tell directions; else any image of integers, which is not read.
    pub normals: ImageHandle,
}

/// Entries: a key that a block has. They lie in the order of blocks.
#[derive(Debug, Clone, Copy)]
pub struct Entries {
    /// u32 a key, `block_keys` of the grid a block.
    pub block_keys: BufferHandle,
    /// u32 a block and one more: its first entry.
    pub block_offsets: BufferHandle,
    /// u32 an entry: its key.
    pub keys: BufferHandle,
    /// u32 an entry: its own number; one word where nothing sorts them.
    pub origins: BufferHandle,
    /// How many there are.
    pub counted: Counted,
}

/// Declares an array of words.
pub(super) fn words(graph: &mut Graph, name: &str, count: u64) -> BufferHandle {
    graph.word_buffer(name, count.max(1) * 4, Lifetime::Transient)
}

/// Adds the node that takes the total of offsets of `most` items into a buffer of its own; of as many as `count` says, where there is one.
pub(super) fn add_total(
    graph: &mut Graph,
    name: &str,
    offsets: BufferHandle,
    most: u32,
    count: Option<BufferHandle>,
) -> BufferHandle {
    let total = words(graph, name, 1);
    let set = cluster_total::Bindings {
        offsets: ComputeStorageRead(offsets),
        // Not read where their number is known; something has to be bound.
        count: ComputeStorageRead(count.unwrap_or(offsets)),
        total: ComputeStorageWrite(total),
    };
    let spec = cluster_total::Spec { AT: most, COUNTED: count.is_some() };
    graph.add(name, dispatch(&cluster_total::PROGRAM, spec.values(), set.list(), [1, 1, 1]));
    total
}

/// Adds the steps.
pub fn add(graph: &mut Graph, inputs: &Inputs) -> Entries {
    let (clusters, grid) = (inputs.clusters, &inputs.clusters.grid);
    let blocks = grid.block_count;
    let block_keys = words(graph, "block_keys", u64::from(blocks) * u64::from(grid.block_keys));
    let counts = words(graph, "block_counts", u64::from(blocks));
    let set = cluster_keys::Bindings {
        grid: ComputeUniform(inputs.tile_grid),
        clusters: ComputeUniform(inputs.cluster_grid),
        depth: ComputeSampled(inputs.depth, nearest_sampler()),
        block_keys: ComputeStorageReadWrite(block_keys),
        block_counts: ComputeStorageWrite(counts),
        cluster_normals: ComputeSampled(inputs.normals, nearest_sampler()),
    };
    let spec = cluster_keys::Spec { BY_NORMAL: clusters.by_normal() };
    graph.add("cluster_keys", dispatch(&cluster_keys::PROGRAM, spec.values(), set.list(), rows(blocks)));
    let block_offsets = scan::add(graph, "block", counts, blocks);
    let total = add_total(graph, "entry_total", block_offsets, blocks, None);
    let counted = group_count::add(graph, "entry", total, grid.entry_capacity, 1);
    let keys = words(graph, "entry_keys", u64::from(grid.entry_capacity));
    let origins = words(graph, "entry_origins", if clusters.merged { u64::from(grid.entry_capacity) } else { 1 });
    let set = cluster_compact::Bindings {
        clusters: ComputeUniform(inputs.cluster_grid),
        block_keys: ComputeStorageRead(block_keys),
        block_offsets: ComputeStorageRead(block_offsets),
        entry_keys: ComputeStorageWrite(keys),
        entry_origins: ComputeStorageWrite(origins),
    };
    let spec = cluster_compact::Spec { KEEP_ORIGIN: clusters.merged };
    graph.add("cluster_compact", dispatch(&cluster_compact::PROGRAM, spec.values(), set.list(), rows(blocks)));
    Entries { block_keys, block_offsets, keys, origins, counted }
}
