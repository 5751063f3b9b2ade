//! Options of effects that a scene calls for.

use clap::{Args, ValueEnum};

use crate::plan::EffectName;

/// Options of effects.
#[derive(Debug, Clone, Args)]
pub struct EffectArgs {
    /// Samples a pixel; a number that the device lacks is replaced by the nearest.
    #[arg(long, value_name = "1|2|4|8", default_value = "1", value_parser = parse_samples)]
    pub msaa: u32,
    /// Run an effect that nothing calls for, with input that changes nothing; repeatable.
    #[arg(long, value_name = "EFFECT", value_parser = parse_effect)]
    pub force: Vec<EffectName>,
    /// Leave out an effect whatever calls for it; repeatable.
    #[arg(long, value_name = "EFFECT", value_parser = parse_effect)]
    pub forbid: Vec<EffectName>,
    /// Refuse a number of samples that the device lacks instead of replacing it.
    #[arg(long)]
    pub strict: bool,
    /// What light lists of blended surfaces know of depths [default: own where there are lists and depths].
    #[arg(long, value_enum)]
    pub transparent_bounds: Option<TransparentBoundsArg>,
    /// What of blended surfaces is put in order from back to front.
    #[arg(long, value_enum, default_value = "object")]
    pub transparent_sort: TransparentSortArg,
}

/// `--msaa`.
fn parse_samples(text: &str) -> Result<u32, String> {
    match text {
        "1" | "2" | "4" | "8" => text.parse().map_err(|_| "a pixel has 1, 2, 4 or 8 samples".into()),
        _ => Err("a pixel has 1, 2, 4 or 8 samples".into()),
    }
}

/// `--force` and `--forbid`.
fn parse_effect(text: &str) -> Result<EffectName, String> {
    let known = EffectName::ALL.map(EffectName::name).join(", ");
    let found = EffectName::ALL.into_iter().find(|effect| effect.name() == text);
    found.ok_or_else(|| format!("effects that can be overridden are {known}"))
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
