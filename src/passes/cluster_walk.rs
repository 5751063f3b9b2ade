//! Light assignment through the light hierarchy: each cluster walks with its own box below each root; what it takes is put into the order
//! of ids afterwards (O. Olsson, M. Billeter, U. Assarsson, HPG 2012, section 3.4).
//!
//! Reads: tile grid, lights to cull, tile edges, cells, the hierarchy. Writes: cluster lists and where each begins, the same as those whose
//! candidates come from lists of tiles without depth bounds. Steps: count, scan, fill, where there are several roots the first of each
//! cluster's offsets, sort; groups of 64, a thread a cluster and root, as many groups as the device finds clusters. Limits: the plan bounds
//! lists, walks and counts. CPU twin: `reference/cluster_assign.rs` over the lists of `reference/tile_cull.rs`.

use super::cluster_assign::{self, explicit};
use super::cluster_keys::words;
use super::group_count::{self, Counted};
use super::light_tree::tree_fetch;
use super::tile_bin::cull_fetch;
use super::tile_cull::{Lists, cull_constant};
use super::{dispatch_groups, list_sort, nearest_sampler, scan};
use crate::graph::access::{ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform};
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::plan::assign::TreeSource;
use crate::shaders::cluster::{cluster_walk_count, cluster_walk_fill, cluster_walk_offsets};

/// What the pass needs.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// What every assignment has.
    pub assign: &'a cluster_assign::Inputs<'a>,
    /// The plan's hierarchy and sort.
    pub source: &'a TreeSource,
    /// Header and entries of the hierarchy.
    pub texels: BufferHandle,
    /// How many clusters there are.
    pub counted: Counted,
    /// What is asked of each of them.
    pub cells: ImageHandle,
}

/// Adds the steps.
pub fn add(graph: &mut Graph, inputs: &Inputs) -> Lists {
    let (clusters, source) = (inputs.assign.clusters, inputs.source);
    let (capacity, walks) = (clusters.grid.capacity, source.tree.walk_count());
    let (total, name) = (inputs.counted.total, inputs.assign.name);
    let each_walk = match (walks, inputs.assign.keyed) {
        (1, _) => inputs.counted,
        (_, None) => group_count::known(total, capacity, walks),
        (_, Some(_)) => group_count::add(graph, &format!("{name}_walk"), total, capacity, walks),
    };
    let counts = words(graph, &format!("{name}_walk_counts"), u64::from(capacity) * u64::from(walks));
    count(graph, inputs, &each_walk, counts);
    // The plan has checked that they are fewer than a scan takes.
    let walk_offsets =
        scan::add_counted(graph, &format!("{name}_walk"), counts, capacity.saturating_mul(walks), &each_walk);
    let lights = words(graph, &format!("{name}_lights"), clusters.pairs);
    fill(graph, inputs, &each_walk, Lists { lights, offsets: walk_offsets });
    let offsets = if walks == 1 { walk_offsets } else { offsets(graph, inputs, walk_offsets) };
    list_sort::add_counted(graph, name, &source.sort, Lists { lights, offsets }, &inputs.counted);
    Lists { lights, offsets }
}

fn count(graph: &mut Graph, inputs: &Inputs, each_walk: &Counted, counts: BufferHandle) {
    let Inputs { assign, source, texels, cells, .. } = *inputs;
    let set = cluster_walk_count::Bindings {
        grid: ComputeUniform(assign.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(assign.tile_handles.lights),
        cull_lights_texel: ComputeTexel(assign.tile_handles.lights),
        cluster_total: ComputeTexel(each_walk.total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(assign.tile_handles.edges),
        walk_counts: ComputeStorageWrite(counts),
        light_tree_storage: ComputeStorageRead(texels),
        light_tree_texel: ComputeTexel(texels),
    };
    let spec = cluster_walk_count::Spec {
        CULL_FETCH: cull_fetch(assign.tiles),
        CULL_CONES: !assign.tiles.cones.is_empty(),
        EXPLICIT: explicit(assign.clusters),
        CULL: cull_constant(assign.tiles.cull),
        TREE_FETCH: tree_fetch(&source.tree),
        BY_NORMAL: assign.clusters.by_normal(),
    };
    let work = dispatch_groups(&cluster_walk_count::PROGRAM, spec.values(), set.list(), each_walk.groups);
    graph.add(&format!("{}_walk_count", assign.name), work);
}

fn fill(graph: &mut Graph, inputs: &Inputs, each_walk: &Counted, lists: Lists) {
    let Inputs { assign, source, texels, cells, .. } = *inputs;
    let set = cluster_walk_fill::Bindings {
        grid: ComputeUniform(assign.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(assign.tile_handles.lights),
        cull_lights_texel: ComputeTexel(assign.tile_handles.lights),
        cluster_total: ComputeTexel(each_walk.total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(assign.tile_handles.edges),
        walk_offsets: ComputeStorageRead(lists.offsets),
        cluster_lights: ComputeStorageWrite(lists.lights),
        light_tree_storage: ComputeStorageRead(texels),
        light_tree_texel: ComputeTexel(texels),
    };
    let spec = cluster_walk_fill::Spec {
        CULL_FETCH: cull_fetch(assign.tiles),
        CULL_CONES: !assign.tiles.cones.is_empty(),
        EXPLICIT: explicit(assign.clusters),
        CULL: cull_constant(assign.tiles.cull),
        TREE_FETCH: tree_fetch(&source.tree),
        BY_NORMAL: assign.clusters.by_normal(),
    };
    let work = dispatch_groups(&cluster_walk_fill::PROGRAM, spec.values(), set.list(), each_walk.groups);
    graph.add(&format!("{}_walk_fill", assign.name), work);
}

/// Where the list of each cluster begins: with the part of its first walk.
fn offsets(graph: &mut Graph, inputs: &Inputs, walk_offsets: BufferHandle) -> BufferHandle {
    let counted = &inputs.counted;
    let name = inputs.assign.name;
    let offsets = words(graph, &format!("{name}_offsets"), u64::from(inputs.assign.clusters.grid.capacity) + 1);
    let set = cluster_walk_offsets::Bindings {
        cluster_total: ComputeTexel(counted.total),
        walk_offsets: ComputeStorageRead(walk_offsets),
        cluster_offsets: ComputeStorageWrite(offsets),
    };
    let spec = cluster_walk_offsets::Spec { WALKS: inputs.source.tree.walk_count() };
    let work = dispatch_groups(&cluster_walk_offsets::PROGRAM, spec.values(), set.list(), counted.groups);
    graph.add(&format!("{name}_walk_offsets"), work);
    offsets
}
