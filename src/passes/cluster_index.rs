//! Cluster index: the cluster of each sample and, for explicit bounds, the view-space box of each cluster's samples (O. Olsson,
//! M. Billeter, U. Assarsson, HPG 2012, sections 3.2 and 3.3).
//!
//! Reads: tile grid, cluster grid, depth, codes of normals where clusters tell directions, entries. Writes: an R32_UINT image of a texel
//! a sample (`NO_CLUSTER` for the sky), and `BOX_WORDS` floats a cluster. Groups of 64, a thread a block, which owns its entries; where
//! tiles have several blocks a second step, a thread a cluster, takes the least and greatest of its entries, in any order the same. A box
//! holds the pixels' squares at the distances that their stored depths may mean, so the position that is shaded lies inside. Limits: none
//! of its own. CPU twin: `reference/cluster_index.rs`.

use ash::vk;

use super::cluster_keys::{Entries, Inputs, words};
use super::cluster_unique::Merged;
use super::group_count::rows;
use super::{dispatch, dispatch_groups, nearest_sampler};
use crate::graph::access::{
    ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform,
};
use crate::graph::{BufferHandle, Contents, Graph, ImageHandle, Lifetime};
use crate::plan::ClusterBounds;
use crate::shaders::cluster::{cluster_bounds, cluster_index};
use crate::shared::BOX_WORDS;

/// What the pass leaves.
#[derive(Debug, Clone, Copy)]
pub struct Indexed {
    /// u32 a sample: its cluster.
    pub index: ImageHandle,
    /// `BOX_WORDS` floats a cluster; one word where bounds are implicit.
    pub bounds: BufferHandle,
}

/// Adds the pass; `merged` where tiles have several blocks.
pub fn add(graph: &mut Graph, inputs: &Inputs, entries: &Entries, merged: Option<&Merged>) -> Indexed {
    let (clusters, grid) = (inputs.clusters, &inputs.clusters.grid);
    let explicit = clusters.bounds == ClusterBounds::Explicit;
    let size = [graph.image_info(inputs.depth).width, graph.image_info(inputs.depth).height];
    let index = graph.image("cluster_index", vk::Format::R32_UINT, size, Lifetime::Transient);
    let box_words = |count: u32| if explicit { u64::from(count) * u64::from(BOX_WORDS) } else { 1 };
    let entry_bounds = words(graph, "entry_bounds", box_words(grid.entry_capacity));
    let set = cluster_index::Bindings {
        grid: ComputeUniform(inputs.tile_grid),
        clusters: ComputeUniform(inputs.cluster_grid),
        depth: ComputeSampled(inputs.depth, nearest_sampler()),
        block_keys: ComputeStorageRead(entries.block_keys),
        block_offsets: ComputeStorageRead(entries.block_offsets),
        // Not read where entries are clusters; something has to be bound.
        entry_clusters: ComputeStorageRead(merged.map_or(entries.block_offsets, |m| m.entry_clusters)),
        entry_bounds: ComputeStorageWrite(entry_bounds),
        cluster_index: ComputeImageWrite(index, Contents::Discarded),
        cluster_normals: ComputeSampled(inputs.normals, nearest_sampler()),
    };
    let spec = cluster_index::Spec { EXPLICIT: explicit, MERGED: merged.is_some(), BY_NORMAL: clusters.by_normal() };
    let work = dispatch(&cluster_index::PROGRAM, spec.values(), set.list(), rows(grid.block_count));
    graph.add("cluster_index", work);
    let Some(merged) = merged.filter(|_| explicit) else { return Indexed { index, bounds: entry_bounds } };
    let bounds = words(graph, "cluster_bounds", box_words(grid.capacity));
    let set = cluster_bounds::Bindings {
        cluster_total: ComputeTexel(merged.counted.total),
        cluster_first: ComputeStorageRead(merged.first),
        sorted_origins: ComputeStorageRead(merged.sorted_origins),
        entry_bounds: ComputeStorageRead(entry_bounds),
        cluster_bounds: ComputeStorageWrite(bounds),
    };
    let groups = merged.counted.groups;
    graph.add("cluster_bounds", dispatch_groups(&cluster_bounds::PROGRAM, Vec::new(), set.list(), groups));
    Indexed { index, bounds }
}
