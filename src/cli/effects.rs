//! Options of effects that a scene calls for.

use clap::{Args, ValueEnum};

/// Options of effects.
#[derive(Debug, Clone, Args)]
pub struct EffectArgs {
    /// What light lists of blended surfaces know of depths [default: own where there are lists and depths].
    #[arg(long, value_enum)]
    pub transparent_bounds: Option<TransparentBoundsArg>,
    /// What of blended surfaces is put in order from back to front.
    #[arg(long, value_enum, default_value = "object")]
    pub transparent_sort: TransparentSortArg,
}

/// `--transparent-bounds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TransparentBoundsArg {
    /// Lists of their own, between the nearest blended fragment and the opaque sample behind it.
    Own,
    /// One list a tile for both kinds of surfaces, bounded by the samples of both.
    Merged,
    /// Lists of their own that know nothing of depths.
    None,
}

/// `--transparent-sort`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TransparentSortArg {
    /// Objects, by the middle of their box.
    Object,
    /// The triangles of all of them, by their middle.
    Triangle,
}
