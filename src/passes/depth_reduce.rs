//! Depth reduction: nearest and farthest distance of each tile's samples, and which slots between them hold samples (Harada, "A 2.5D
//! culling for Forward+", SIGGRAPH Asia 2012).
//!
//! Reads: tile grid, depth, nearest blended fragments where bounds hold them. Writes: tile bounds, an RGBA32_UINT image of a texel a tile:
//! two distances as bits, then a mask of 64 bits. Groups of 8x8 threads, a thread a tile, because serial runs are what CPU drivers are
//! fastest at, or a group a tile, because GPUs want the opposite; the profile says which (`plan/tiles.rs`). Sky never enters opaque bounds,
//! and a tile of nothing but sky has its nearest distance beyond its farthest; behind blended fragments it counts as far as anything is
//! drawn. Limits: none. CPU twin: `reference/depth_reduce.rs`.

use ash::vk;

use super::{TileHandles, dispatch, nearest_sampler, several_samples};
use crate::graph::access::{ComputeImageWrite, ComputeSampled, ComputeUniform};
use crate::graph::{Contents, Graph, ImageHandle, Lifetime};
use crate::plan::{DepthBounds, Tiles};
use crate::shaders::tile::depth_reduce;
use crate::shared;

/// Texels of [`add`]'s image.
pub const BOUNDS_FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;

/// Value of DEPTH_BOUNDS.
pub fn bounds_constant(bounds: DepthBounds) -> u32 {
    match bounds {
        DepthBounds::Off => shared::BOUNDS_OFF,
        DepthBounds::MinMax => shared::BOUNDS_MIN_MAX,
        DepthBounds::Mask => shared::BOUNDS_MASK,
    }
}

/// What bounds hold.
#[derive(Debug, Clone, Copy)]
pub enum Samples {
    /// Opaque samples.
    Opaque,
    /// Of each pixel what lies between its nearest blended fragment, which this image holds, and the opaque sample.
    Blended(ImageHandle),
    /// Both.
    Both(ImageHandle),
}

/// Adds the pass; the tile bounds.
pub fn add(
    graph: &mut Graph,
    tiles: &Tiles,
    handles: &TileHandles,
    depth: ImageHandle,
    samples: Samples,
) -> ImageHandle {
    let size = [tiles.grid.columns, tiles.grid.rows];
    let (constant, blended, names) = match samples {
        Samples::Opaque => (shared::HELD_OPAQUE, depth, ["tile_bounds", "depth_reduce"]),
        Samples::Blended(image) => (shared::HELD_BLENDED, image, ["transparent_bounds", "transparent_depth_reduce"]),
        Samples::Both(image) => (shared::HELD_BOTH, image, ["tile_bounds", "depth_reduce"]),
    };
    let bounds = graph.image(names[0], BOUNDS_FORMAT, size, Lifetime::Transient);
    // Of several samples the other bindings are read.
    let one = |graph: &Graph, image| if graph.image_info(image).samples == 1 { image } else { handles.no_bounds };
    let set = depth_reduce::Bindings {
        grid: ComputeUniform(handles.grid),
        depth: ComputeSampled(one(graph, depth), nearest_sampler()),
        tile_bounds: ComputeImageWrite(bounds, Contents::Discarded),
        transparent_depth: ComputeSampled(one(graph, blended), nearest_sampler()),
        depth_samples: several_samples(graph, depth).map(|image| ComputeSampled(image, nearest_sampler())),
        transparent_samples: several_samples(graph, blended).map(|image| ComputeSampled(image, nearest_sampler())),
    };
    let spec = depth_reduce::Spec {
        TILE: tiles.tile,
        DEPTH_BOUNDS: bounds_constant(tiles.bounds),
        DEPTH_SLOTS: tiles.slots,
        GROUP_A_TILE: tiles.group_a_tile,
        HELD: constant,
        SAMPLES: graph.image_info(depth).samples,
    };
    let tiles_a_group = if tiles.group_a_tile { 1 } else { 8 };
    let groups = [size[0].div_ceil(tiles_a_group), size[1].div_ceil(tiles_a_group), 1];
    graph.add(names[1], dispatch(&depth_reduce::PROGRAM, spec.values(), set.list(), groups));
    bounds
}
