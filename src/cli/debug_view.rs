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
    /// Length of each pixel's light list.
    TileLights,
    /// Occupied slots of each tile's 2.5D mask.
    TileMask,
    /// Bounding rectangles of lights over the lit picture.
    Quads,
    /// Lights that reach a pixel and are not in its list, in green.
    Missed,
    /// Listed over reaching lights of each pixel.
    Waste,
    /// Lights that reach each pixel, by the f64 oracle.
    Lights,
}
