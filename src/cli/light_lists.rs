//! Options of light lists.

use clap::ValueEnum;

/// `--cull`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CullArg {
    /// Lights whose screen rectangle, from tangents, touches the tile.
    Bounds,
    /// The same with rectangles from the textbook's divisions, which lose lights.
    BoundsTextbook,
    /// Lights that reach between the tile's planes.
    Frustum,
    /// Lights that reach between the tile's planes and touch its view-space box.
    FrustumAabb,
}

/// `--depth-bounds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DepthBoundsArg {
    /// Nothing is known.
    Off,
    /// Nearest and farthest sample.
    Minmax,
    /// These, and which slots between them hold samples.
    #[value(name = "2.5d")]
    Mask,
}

/// `--cluster-bounds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ClusterBoundsArg {
    /// Its tile and slice.
    Implicit,
    /// The box of its samples.
    Explicit,
}

/// `--assign`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AssignArg {
    /// The plan chooses.
    Auto,
    /// In the lists of their tiles.
    Tiles,
    /// In a hierarchy of lights, which each cluster walks through.
    Tree,
}

/// `--slices-per-octave`.
pub(super) fn parse_slices(text: &str) -> Result<u32, String> {
    let power = text.parse().ok().filter(|slices: &u32| slices.is_power_of_two() && *slices <= 64);
    power.ok_or_else(|| "slices an octave are a power of two from 1 to 64".into())
}

/// `--tile`.
pub(super) fn parse_tile(text: &str) -> Result<u32, String> {
    match text {
        "8" | "16" | "32" | "64" => text.parse().map_err(|_| "a tile is 8, 16, 32 or 64 pixels wide".into()),
        _ => Err("a tile is 8, 16, 32 or 64 pixels wide".into()),
    }
}

/// `--depth-reduce`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DepthReduceArg {
    /// One thread walks through it.
    Thread,
    /// A group of threads shares it.
    Group,
}
