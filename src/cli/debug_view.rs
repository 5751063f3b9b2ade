//! Names of debug views.

use clap::ValueEnum;

/// `--debug-view`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DebugViewArg {
    /// Base colour.
    Albedo,
    /// View-space normal.
    Normals,
    /// Distance in false colour.
    Depth,
    /// The depth buffer's own value.
    DepthRaw,
    /// Nearest sample of each tile, metres.
    TileMin,
    /// Farthest sample of each tile, metres.
    TileMax,
    /// Length of the light list of each pixel's tile.
    TileLights,
    /// Occupied slots of each tile's 2.5D mask.
    TileMask,
    /// Which pixels share a cluster, each cluster in its colour.
    Clusters,
    /// Length of the light list of each pixel's cluster.
    ClusterLights,
    /// Slice that each pixel's sample lies in.
    Slices,
    /// Bounding rectangles of lights over the lit picture.
    Quads,
    /// Lights that reach a pixel and are not in its list, in green.
    Missed,
    /// Listed over reaching lights of each pixel.
    Waste,
    /// Lights that reach each pixel, by the f64 oracle.
    Lights,
    /// Base colour as the G-buffer stores it.
    GbufferAlbedo,
    /// View-space normal as the G-buffer stores it.
    GbufferNormal,
    /// Roughness, metalness and occlusion in the G-buffer.
    GbufferMaterial,
    /// Emission in the G-buffer.
    GbufferEmission,
}
