//! Arguments of `bench`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{ShadingArg, parse_size};

/// Arguments of `bench`.
#[derive(Debug, Clone, Args)]
pub struct Bench {
    /// Which experiment.
    #[arg(value_enum)]
    pub name: BenchName,
    /// Device or driver whose name contains this; given more than once, the devices are measured side by side.
    #[arg(long, value_name = "SUBSTRING")]
    pub driver: Vec<String>,
    /// A .gltf or .glb file, or builtin:NAME[:key=value,...] [default: the experiment's own].
    #[arg(long)]
    pub scene: Option<String>,
    /// Picture size in pixels, of `resolution` the largest [default: the experiment's own].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Reflection model.
    #[arg(long, value_enum, default_value = "gltf")]
    pub shading: ShadingArg,
    /// Numbers of lights; experiments that draw one number take the largest [default: the experiment's own].
    #[arg(long, value_name = "N,...", value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub lights: Vec<u32>,
    /// Range of every light in metres, of `million` that of 4,096 lights [default: the experiment's own].
    #[arg(long, value_name = "R|inf", allow_hyphen_values = true)]
    pub light_range: Option<f64>,
    /// Seed of the scattered lights.
    #[arg(long, visible_alias = "seed", value_name = "S", default_value_t = 1)]
    pub light_seed: u64,
    /// About how many patches `radiosity` gathers between [default: 4096, with --quick 300].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32768))]
    pub patches: Option<u32>,
    /// Camera path of `path` [default: one through the atrium].
    #[arg(long, value_name = "FILE.json")]
    pub path: Option<PathBuf>,
    /// Most frames to time of each case, interleaved [default: 9, with --quick 3].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// Fewer cases and frames, smaller pictures.
    #[arg(long)]
    pub quick: bool,
    /// Write the experiment's figures into this folder, as NAME.svg and NAME.png.
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Write one page of all tables and figures into this folder, as index.html.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Experiments that have landed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BenchName {
    /// All of them, one after the other.
    All,
    /// Full-screen loop over N lights for each light fetch: the most that shading can reach on this driver.
    Ceiling,
    /// Every technique over the number of lights.
    Lights,
    /// No depth pre-pass, one, and one with depth bounds.
    Prepass,
    /// Tile size, depth bounds and technique, with the times of depth reduction, list building and shading.
    Tiles,
    /// Every technique over the size of the picture.
    Resolution,
    /// Every technique seen by a person and from above.
    Views,
    /// Frames a second along a camera path.
    Path,
    /// Up to a million lights, as many of them in each pixel.
    Million,
    /// Panes of glass, by what light lists of blended surfaces know of depths.
    Transparency,
    /// Each shading model on every material, and all of them side by side.
    Materials,
    /// Time, memory and depth reduction by samples a pixel.
    Msaa,
    /// Each effect forced where nothing calls for it, and left out.
    Effects,
    /// Bounced light by every codec, iteration and path to the matrix: bytes, time and error.
    Radiosity,
    /// What each step takes on this device; stored, so that `--technique auto` chooses by it.
    Profile,
}
