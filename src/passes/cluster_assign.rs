//! Light assignment: which lights touch a cluster, in id order (O. Olsson, M. Billeter, U. Assarsson, HPG 2012, section 3.4).
//!
//! Reads: tile grid, lights to cull, candidates (lists of tiles; `cluster_walk` has those from the light hierarchy), tile edges, slices
//! and directions; keys and boxes of clusters, where there are any. Writes: cluster lists and where each begins. Steps: cells (what is
//! asked of each cluster, in one image), count, scan, fill; groups of 64, a thread a cluster, as many groups as the device finds
//! clusters. Limits: the plan sizes the lists for the most there can be. CPU twin: `reference/cluster_assign.rs`.

use ash::vk;

use super::cluster_keys::words;
use super::group_count::{self, Counted};
use super::tile_bin::cull_fetch;
use super::tile_cull::{Lists, list_fetch};
use super::{ClusterHandles, TileHandles, cluster_walk, dispatch_groups, nearest_sampler, scan};
use crate::graph::access::{
    ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform,
};
use crate::graph::{BufferHandle, Contents, Graph, ImageHandle, Lifetime, Work};
use crate::plan::assign::TreeSource;
use crate::plan::{ClusterBounds, Clusters, Tiles};
use crate::shaders::cluster::{cluster_cells, cluster_count, cluster_fill};
use crate::shared::{ASSIGN_TILE, ASSIGN_TREE};

/// Clusters that own samples.
#[derive(Debug, Clone, Copy)]
pub struct Keyed {
    /// u32 a cluster: its key.
    pub keys: BufferHandle,
    /// `BOX_WORDS` floats a cluster, where bounds are explicit.
    pub bounds: BufferHandle,
    /// How many there are.
    pub counted: Counted,
}

/// Where candidates come from.
#[derive(Debug, Clone, Copy)]
pub enum Candidates<'a> {
    /// The lists of tiles.
    Tiles(Lists),
    /// The light hierarchy, and its header and entries.
    Tree(&'a TreeSource, BufferHandle),
}

impl Candidates<'_> {
    /// The light hierarchy, where it is the source.
    pub fn texels(self) -> Option<BufferHandle> {
        match self {
            Self::Tiles(_) => None,
            Self::Tree(_, texels) => Some(texels),
        }
    }

    /// The lists of tiles, where they are the source.
    pub fn lists(self) -> Option<Lists> {
        match self {
            Self::Tiles(lists) => Some(lists),
            Self::Tree(..) => None,
        }
    }
}

/// What the pass needs.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// What nodes and buffers are called.
    pub name: &'a str,
    /// The plan's tiles.
    pub tiles: &'a Tiles,
    /// Their static buffers.
    pub tile_handles: &'a TileHandles,
    /// The plan's clusters.
    pub clusters: &'a Clusters,
    /// Their static buffers.
    pub handles: &'a ClusterHandles,
    /// Candidates.
    pub candidates: Candidates<'a>,
    /// `None` where every slice of every tile is a cluster.
    pub keyed: Option<Keyed>,
}

/// Adds the steps.
pub fn add(graph: &mut Graph, inputs: &Inputs) -> Lists {
    let capacity = inputs.clusters.grid.capacity;
    let counted = inputs.keyed.map_or_else(|| every_cluster(graph, inputs.name, capacity), |keyed| keyed.counted);
    let cells = cells(graph, inputs, &counted);
    match inputs.candidates {
        Candidates::Tiles(tile_lists) => from_tiles(graph, inputs, tile_lists, &counted, cells),
        Candidates::Tree(source, texels) => {
            let walked = cluster_walk::Inputs { assign: inputs, source, texels, counted, cells };
            cluster_walk::add(graph, &walked)
        }
    }
}

/// The number of clusters where the plan knows it.
fn every_cluster(graph: &mut Graph, name: &str, count: u32) -> Counted {
    let total = words(graph, &format!("{name}_total"), 1);
    graph.add(&format!("fill_{name}_total"), Work::Fill { buffer: total, word: count });
    group_count::known(total, count, 1)
}

/// Value of EXPLICIT.
pub(super) fn explicit(clusters: &Clusters) -> bool {
    clusters.bounds == ClusterBounds::Explicit
}

fn cells(graph: &mut Graph, inputs: &Inputs, counted: &Counted) -> ImageHandle {
    let [wide, texels] = inputs.clusters.cells();
    let size = [wide * texels, inputs.clusters.grid.capacity.div_ceil(wide).max(1)];
    let cells =
        graph.image(&format!("{}_cells", inputs.name), vk::Format::R32G32B32A32_UINT, size, Lifetime::Transient);
    let (assign, offsets) = match inputs.candidates {
        Candidates::Tiles(lists) => (ASSIGN_TILE, Some(lists.offsets)),
        Candidates::Tree(..) => (ASSIGN_TREE, None),
    };
    // Stands in for what is not there and not read; something has to be bound.
    let any = offsets.unwrap_or(counted.total);
    let set = cluster_cells::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        clusters: ComputeUniform(inputs.handles.grid),
        cluster_total: ComputeTexel(counted.total),
        cluster_slices: ComputeTexel(inputs.handles.slices),
        tile_offsets: ComputeStorageRead(any),
        cluster_keys: ComputeStorageRead(inputs.keyed.map_or(any, |keyed| keyed.keys)),
        cluster_bounds: ComputeStorageRead(inputs.keyed.map_or(any, |keyed| keyed.bounds)),
        cluster_cells: ComputeImageWrite(cells, Contents::Discarded),
    };
    let spec = cluster_cells::Spec {
        DENSE: inputs.keyed.is_none(),
        EXPLICIT: explicit(inputs.clusters),
        ASSIGN: assign,
        BY_NORMAL: inputs.clusters.by_normal(),
    };
    let work = dispatch_groups(&cluster_cells::PROGRAM, spec.values(), set.list(), counted.groups);
    graph.add(&format!("{}_cells", inputs.name), work);
    cells
}

fn from_tiles(graph: &mut Graph, inputs: &Inputs, tile_lists: Lists, counted: &Counted, cells: ImageHandle) -> Lists {
    let capacity = inputs.clusters.grid.capacity;
    let name = inputs.name;
    let counts = words(graph, &format!("{name}_counts"), u64::from(capacity));
    let set = cluster_count::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(inputs.tile_handles.lights),
        cull_lights_texel: ComputeTexel(inputs.tile_handles.lights),
        tile_lights_storage: ComputeStorageRead(tile_lists.lights),
        tile_lights_texel: ComputeTexel(tile_lists.lights),
        cluster_total: ComputeTexel(counted.total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(inputs.tile_handles.edges),
        cluster_counts: ComputeStorageWrite(counts),
    };
    let spec = cluster_count::Spec {
        CULL_FETCH: cull_fetch(inputs.tiles),
        CULL_CONES: !inputs.tiles.cones.is_empty(),
        LIST_FETCH: list_fetch(inputs.tiles),
        EXPLICIT: explicit(inputs.clusters),
        BY_NORMAL: inputs.clusters.by_normal(),
    };
    let constants = spec.values();
    let work = dispatch_groups(&cluster_count::PROGRAM, constants.clone(), set.list(), counted.groups);
    graph.add(&format!("{name}_count"), work);
    let offsets = scan::add_counted(graph, name, counts, capacity, counted);
    let lights = words(graph, &format!("{name}_lights"), inputs.clusters.pairs);
    let set = cluster_fill::Bindings {
        grid: ComputeUniform(inputs.tile_handles.grid),
        cull_lights_storage: ComputeStorageRead(inputs.tile_handles.lights),
        cull_lights_texel: ComputeTexel(inputs.tile_handles.lights),
        tile_lights_storage: ComputeStorageRead(tile_lists.lights),
        tile_lights_texel: ComputeTexel(tile_lists.lights),
        cluster_total: ComputeTexel(counted.total),
        cluster_cells: ComputeSampled(cells, nearest_sampler()),
        tile_edges: ComputeTexel(inputs.tile_handles.edges),
        cluster_offsets: ComputeStorageRead(offsets),
        cluster_lights: ComputeStorageWrite(lights),
    };
    let work = dispatch_groups(&cluster_fill::PROGRAM, constants, set.list(), counted.groups);
    graph.add(&format!("{name}_fill"), work);
    Lists { lights, offsets }
}
