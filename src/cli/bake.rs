//! Options of `bake`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Bake the exchange of light between patches of a scene.
#[derive(Debug, Clone, Args)]
pub struct Bake {
    /// A .gltf or .glb file, or builtin:NAME[:key=value,...].
    pub scene: String,
    /// Folder to write; a bake that is there is replaced.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// About how many patches [default: 1000].
    #[arg(long, value_name = "N", conflicts_with = "patch_size", value_parser = clap::value_parser!(u32).range(1..=32768))]
    pub patches: Option<u32>,
    /// How wide a patch is, metres.
    #[arg(long, value_name = "METRES", value_parser = parse_metres)]
    pub patch_size: Option<f64>,
    /// What patches are made from.
    #[arg(long, value_enum, default_value = "triangles")]
    pub patches_from: PatchesFromArg,
    /// How the matrix is stored.
    #[arg(long, value_enum, default_value = "zero-block")]
    pub codec: CodecArg,
    /// Elements whose residual is stored beside the blocks of zero-block, per cent [default: 2].
    #[arg(long, value_name = "PERCENT", value_parser = parse_percent)]
    pub extract: Option<f64>,
    /// Bounces that a codec sums beforehand, or inf [default: 3 for thesis and thesis-filled, inf for the others].
    #[arg(long, value_name = "K|inf", value_parser = parse_bounces)]
    pub bounces: Option<Bounces>,
    /// Order of rows and columns of codecs that sum bounces [default: rows-columns for thesis and thesis-filled, landmarks for bc1 and bc4-chroma].
    #[arg(long, value_enum)]
    pub order: Option<OrderArg>,
    /// Who looks what stands between patches: auto lets both try on a few rows and takes the quicker one. The bake has the same bytes either way.
    #[arg(long, value_enum, default_value = "auto")]
    pub bake_on: BakeOnArg,
    /// Device or driver whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub driver: Option<String>,
    /// Run the device under validation and synchronization validation.
    #[arg(long)]
    pub validate: bool,
    /// Seed of rays and points.
    #[arg(long, value_name = "S", default_value = "1")]
    pub seed: u64,
    /// Bake only a part of the rows, to be merged with the others: I from 1 to N.
    #[arg(long, value_name = "I/N", value_parser = parse_shard, conflicts_with = "merge")]
    pub shard: Option<(u32, u32)>,
    /// Make the bake of rows that shards have left; none is computed here.
    #[arg(long)]
    pub merge: bool,
    /// Write figures of the matrix, its orders and what blocks make of it into this folder, with a page of all.
    #[arg(long, value_name = "DIR", conflicts_with = "shard")]
    pub report: Option<PathBuf>,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `--patches-from`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PatchesFromArg {
    /// Pieces of the triangles, with their true areas and directions.
    Triangles,
    /// Sides of the cubes of a grid that surfaces pass through (A. Shcherbakov, 2017).
    Voxels,
}

/// `--bake-on`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BakeOnArg {
    /// The quicker one.
    Auto,
    /// All cores, in 64 bits.
    Cpu,
    /// A compute pass in 32 bits, and the CPU where these cannot tell.
    Device,
}

/// `--codec`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CodecArg {
    /// Form factors of 32 bits, gathered as often as light bounces.
    Classical,
    /// Bounces summed beforehand, 16 bits an element and channel.
    DenseF16,
    /// Three bounces summed beforehand, 8-bit logarithms in BC1 blocks, the largest 4 % apart (A. Shcherbakov, 2017).
    Thesis,
    /// The same with holes filled.
    ThesisFilled,
    /// Bounces summed beforehand, BC1 blocks fitted to what they decode to, 2 % of residuals.
    Bc1,
    /// Bounces summed beforehand, luminance in BC4 blocks, two bytes of chroma a block, 2 % of residuals.
    Bc4Chroma,
    /// Form factors in blocks of eight bytes, 3 bits an element of which one value is exactly 0, and a sparse residual.
    ZeroBlock,
}

/// `--order`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OrderArg {
    /// As patches come.
    None,
    /// Rows, greedily by how alike they are.
    Rows,
    /// Rows, then columns.
    RowsColumns,
    /// Both, by 128 of their values.
    Landmarks,
}

/// `--bounces`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounces {
    /// So many.
    Some(u32),
    /// All.
    All,
}

fn parse_bounces(text: &str) -> Result<Bounces, String> {
    match (text, text.parse::<u32>()) {
        ("inf", _) => Ok(Bounces::All),
        (_, Ok(count)) if (1..=1000).contains(&count) => Ok(Bounces::Some(count)),
        _ => Err("bounces are 1 to 1000, or inf".into()),
    }
}

fn parse_metres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(metres) if metres.is_finite() && metres > 0.0 => Ok(metres),
        _ => Err("a patch is a positive number of metres wide".into()),
    }
}

fn parse_percent(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(percent) if (0.0..=100.0).contains(&percent) => Ok(percent),
        _ => Err("per cent from 0 to 100".into()),
    }
}

fn parse_shard(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((i, n)) if i >= 1 && i <= n => Ok((i, n)),
        _ => Err("a shard is I/N, I from 1 to N".into()),
    }
}
