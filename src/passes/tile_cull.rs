//! Light culling a tile: which lights of its bin reach it, in id order.
//!
//! Reads: tile grid, lights to cull, bin lists, tile edges, tile bounds (where depths are known). Writes: tile lists and where each
//! begins. Three steps: count a run of 8192 entries for each tile, scan, fill; a workgroup a bin and run, a thread a tile. Limits: the
//! plan sizes the lists for the most there can be. CPU twin: `reference/tile_cull.rs`.

use super::depth_reduce::bounds_constant;
use super::tile_bin::{Bins, cull_fetch};
use super::{TileHandles, dispatch, nearest_sampler, scan};
use crate::graph::access::{ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform};
use crate::graph::{BufferHandle, Graph, ImageHandle, Lifetime};
use crate::plan::{CullTest, DepthBounds, Tiles};
use crate::shaders::tile::{tile_count, tile_fill};
use crate::shared;

/// Lists of cells, ready for shading.
#[derive(Debug, Clone, Copy)]
pub struct Lists {
    /// u32 a pair: id of the light.
    pub lights: BufferHandle,
    /// u32 a tile and run, and one more: where it begins.
    pub offsets: BufferHandle,
}

/// Value of CULL.
pub fn cull_constant(cull: CullTest) -> u32 {
    match cull {
        CullTest::Bounds | CullTest::BoundsTextbook => shared::CULL_RECTANGLE,
        CullTest::Frustum => shared::CULL_PLANES,
        CullTest::FrustumAabb => shared::CULL_PLANES_BOX,
    }
}

/// Value of LIST_FETCH.
pub fn list_fetch(tiles: &Tiles) -> u32 {
    if tiles.words_by_texel { shared::WORDS_TEXEL } else { shared::WORDS_STORAGE }
}

/// Adds the three steps under `name`; `bounds` where depths are known.
pub fn add(
    graph: &mut Graph,
    name: &str,
    tiles: &Tiles,
    handles: &TileHandles,
    bins: Bins,
    bounds: Option<ImageHandle>,
) -> Lists {
    let counts_len = tiles.count_tiles() * tiles.grid.list_chunks;
    let counts = graph.word_buffer(&format!("{name}_counts"), u64::from(counts_len) * 4, Lifetime::Transient);
    let known = bounds.map_or(DepthBounds::Off, |_| tiles.bounds);
    // A texel that nothing reads stands in where depths are not known.
    let bounds = bounds.unwrap_or(handles.no_bounds);
    let groups = [tiles.count_bins(), tiles.grid.list_chunks, 1];
    let set = tile_count::Bindings {
        grid: ComputeUniform(handles.grid),
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        bin_lights_storage: ComputeStorageRead(bins.lights),
        bin_lights_texel: ComputeTexel(bins.lights),
        bin_ranges: ComputeTexel(bins.ranges),
        tile_edges: ComputeTexel(handles.edges),
        tile_bounds: ComputeSampled(bounds, nearest_sampler()),
        tile_counts: ComputeStorageWrite(counts),
    };
    let spec = tile_count::Spec {
        CULL_FETCH: cull_fetch(tiles),
        CULL_CONES: !tiles.cones.is_empty(),
        LIST_FETCH: list_fetch(tiles),
        CULL: cull_constant(tiles.cull),
        DEPTH_BOUNDS: bounds_constant(known),
        DEPTH_SLOTS: tiles.slots,
    };
    let constants = spec.values();
    graph.add(&format!("{name}_count"), dispatch(&tile_count::PROGRAM, constants.clone(), set.list(), groups));
    let offsets = scan::add(graph, name, counts, counts_len);
    let lights = graph.word_buffer(&format!("{name}_lights"), tiles.tile_pairs.max(1) * 4, Lifetime::Transient);
    let set = tile_fill::Bindings {
        grid: ComputeUniform(handles.grid),
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        bin_lights_storage: ComputeStorageRead(bins.lights),
        bin_lights_texel: ComputeTexel(bins.lights),
        bin_ranges: ComputeTexel(bins.ranges),
        tile_edges: ComputeTexel(handles.edges),
        tile_bounds: ComputeSampled(bounds, nearest_sampler()),
        tile_offsets: ComputeStorageRead(offsets),
        tile_lights: ComputeStorageWrite(lights),
    };
    graph.add(&format!("{name}_fill"), dispatch(&tile_fill::PROGRAM, constants, set.list(), groups));
    Lists { lights, offsets }
}
