//! Coarse binning: which lights touch which 8x8 tiles, by integer rectangles, in id order. It keeps tile culling from testing every
//! light in every tile.
//!
//! Reads: tile grid, lights to cull. Writes: bin lists and their ranges. Three steps: count a run of 512 lights for each bin, scan, fill;
//! a thread a bin and run, groups of 64. Limits: the plan sizes the lists exactly. CPU twin: `reference/tile_cull.rs`.

use super::{TileHandles, dispatch, scan};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite, ComputeTexel, ComputeUniform};
use crate::graph::{BufferHandle, Graph, Lifetime};
use crate::plan::Tiles;
use crate::shaders::tile::{tile_bin_count, tile_bin_fill};
use crate::shared;

/// What the pass leaves.
#[derive(Debug, Clone, Copy)]
pub struct Bins {
    /// u32 a pair: index among the culled lights.
    pub lights: BufferHandle,
    /// u32 a bin and one more: where its list begins.
    pub ranges: BufferHandle,
}

/// Adds the three steps.
pub fn add(graph: &mut Graph, tiles: &Tiles, handles: &TileHandles) -> Bins {
    let bins = tiles.count_bins();
    let counts_len = bins * tiles.grid.light_chunks;
    let counts = graph.word_buffer("bin_counts", u64::from(counts_len) * 4, Lifetime::Transient);
    let groups = [bins.div_ceil(64), tiles.grid.light_chunks, 1];
    let cull_fetch = cull_fetch(tiles);
    let set = tile_bin_count::Bindings {
        grid: ComputeUniform(handles.grid),
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        bin_counts: ComputeStorageWrite(counts),
    };
    let spec = tile_bin_count::Spec { CULL_FETCH: cull_fetch };
    graph.add("tile_bin_count", dispatch(&tile_bin_count::PROGRAM, spec.values(), set.list(), groups));
    let offsets = scan::add(graph, "bin", counts, counts_len);
    let lights = graph.word_buffer("bin_lights", tiles.bin_pairs.max(1) * 4, Lifetime::Transient);
    let ranges = graph.word_buffer("bin_ranges", u64::from(bins + 1) * 4, Lifetime::Transient);
    let set = tile_bin_fill::Bindings {
        grid: ComputeUniform(handles.grid),
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        bin_offsets: ComputeStorageRead(offsets),
        bin_lights: ComputeStorageWrite(lights),
        bin_ranges: ComputeStorageWrite(ranges),
    };
    let spec = tile_bin_fill::Spec { CULL_FETCH: cull_fetch };
    graph.add("tile_bin_fill", dispatch(&tile_bin_fill::PROGRAM, spec.values(), set.list(), groups));
    Bins { lights, ranges }
}

/// Value of CULL_FETCH.
pub fn cull_fetch(tiles: &Tiles) -> u32 {
    if tiles.lights_by_texel { shared::WORDS_TEXEL } else { shared::WORDS_STORAGE }
}
