//! Merging of keys that several blocks of a tile have: entries sorted by key, and each key once.
//!
//! Reads: entries and their number. Writes: key of each cluster, first of its entries among the sorted ones, cluster of each entry, number
//! of clusters. Steps: radix sort, heads (keys that differ from the one before), scan, gather. Groups of 64, a thread an entry, as many
//! groups as the device finds entries. Limits: the plan's. Not added where a tile is one block: keys are ascending and distinct already.
//! CPU twin: `reference/cluster_keys.rs`.

use super::cluster_keys::{Entries, add_total, words};
use super::group_count::{self, Counted};
use super::{dispatch_groups, radix_sort, scan};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite, ComputeTexel};
use crate::graph::{BufferHandle, Graph};
use crate::plan::Clusters;
use crate::shaders::cluster::{cluster_heads, cluster_origin, cluster_unique};

/// What the pass leaves.
#[derive(Debug, Clone, Copy)]
pub struct Merged {
    /// u32 a cluster: its key.
    pub keys: BufferHandle,
    /// u32 a cluster and one more: its first entry among the sorted ones.
    pub first: BufferHandle,
    /// u32 a sorted entry: its number before.
    pub sorted_origins: BufferHandle,
    /// u32 an entry: its cluster.
    pub entry_clusters: BufferHandle,
    /// How many clusters there are.
    pub counted: Counted,
}

/// Adds the steps.
pub fn add(graph: &mut Graph, clusters: &Clusters, entries: &Entries) -> Merged {
    let capacity = clusters.grid.entry_capacity;
    let Counted { total: entry_total, groups, .. } = entries.counted;
    let (sorted_keys, sorted_origins) = radix_sort::add_counted(
        graph,
        "cluster",
        entries.keys,
        entries.origins,
        capacity,
        entry_total,
        clusters.key_bits,
    );
    let heads = words(graph, "cluster_heads", u64::from(capacity));
    let set = cluster_heads::Bindings {
        entry_total: ComputeTexel(entry_total),
        sorted_keys: ComputeStorageRead(sorted_keys),
        heads: ComputeStorageWrite(heads),
    };
    graph.add("cluster_heads", dispatch_groups(&cluster_heads::PROGRAM, Vec::new(), set.list(), groups));
    let head_offsets = scan::add_counted(graph, "cluster_head", heads, capacity, &entries.counted);
    let total = add_total(graph, "cluster_total", head_offsets, capacity, Some(entry_total));
    let counted = group_count::add(graph, "cluster", total, clusters.grid.capacity, 1);
    let keys = words(graph, "cluster_keys", u64::from(clusters.grid.capacity));
    let first = words(graph, "cluster_first", u64::from(clusters.grid.capacity) + 1);
    let set = cluster_unique::Bindings {
        entry_total: ComputeTexel(entry_total),
        head_offsets: ComputeStorageRead(head_offsets),
        sorted_keys: ComputeStorageRead(sorted_keys),
        cluster_keys: ComputeStorageWrite(keys),
        cluster_first: ComputeStorageWrite(first),
    };
    graph.add("cluster_unique", dispatch_groups(&cluster_unique::PROGRAM, Vec::new(), set.list(), groups));
    let entry_clusters = words(graph, "entry_clusters", u64::from(capacity));
    let set = cluster_origin::Bindings {
        entry_total: ComputeTexel(entry_total),
        head_offsets: ComputeStorageRead(head_offsets),
        sorted_origins: ComputeStorageRead(sorted_origins),
        entry_clusters: ComputeStorageWrite(entry_clusters),
    };
    graph.add("cluster_origin", dispatch_groups(&cluster_origin::PROGRAM, Vec::new(), set.list(), groups));
    Merged { keys, first, sorted_origins, entry_clusters, counted }
}
