//! Options of effects that a scene calls for.

use clap::{Args, ValueEnum};

use crate::plan::EffectName;
use crate::plan::shadows::{DEFAULT_FILTER, DEFAULT_SIZE, LEAST_SIZE, MOST_FILTER, MOST_SIZE};

/// Options of effects.
#[derive(Debug, Clone, Args)]
pub struct EffectArgs {
    /// Samples a pixel; a number that the device lacks is replaced by the nearest.
    #[arg(long, value_name = "1|2|4|8", default_value = "1", value_parser = parse_samples)]
    pub msaa: u32,
    /// Shadows of the N lights that matter most in the picture [default: of those that ask by extras.lampyris.shadow].
    #[arg(long, value_name = "N")]
    pub shadows: Option<u32>,
    /// Columns and rows of a shadow map: a power of two from 64 to 8192.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_SIZE, value_parser = parse_shadow_size)]
    pub shadow_size: u32,
    /// Texels that the edge of a shadow is spread over, 0 (it follows the map's texels) to 8.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_FILTER,
        value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_FILTER)))]
    pub shadow_filter: u32,
    /// When shadow maps are drawn.
    #[arg(long, value_enum, default_value = "once")]
    pub shadow_update: ShadowUpdateArg,
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

/// `--shadow-size`.
fn parse_shadow_size(text: &str) -> Result<u32, String> {
    let fits = |size: &u32| size.is_power_of_two() && (LEAST_SIZE..=MOST_SIZE).contains(size);
    text.parse()
        .ok()
        .filter(fits)
        .ok_or_else(|| format!("a map has a power of two from {LEAST_SIZE} to {MOST_SIZE} columns"))
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

/// `--shadow-update`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShadowUpdateArg {
    /// Before the first frame: nothing moves.
    Once,
    /// In every frame, as if something had moved.
    Frame,
}
