//! Options of `accuracy`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{ShadingArg, parse_size};

/// Arguments of `accuracy`.
#[derive(Debug, Clone, Args)]
pub struct Accuracy {
    /// A .gltf or .glb file, or builtin:NAME[:key=value,...].
    #[arg(default_value = "builtin:atrium")]
    pub scene: String,
    /// Knobs to turn [default: every one].
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    pub knob: Vec<KnobName>,
    /// Device or driver whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub driver: Option<String>,
    /// Picture size in pixels; the reference traces as many rays [default: 320x180, with --quick 160x90].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Reflection model.
    #[arg(long, value_enum, default_value = "gltf")]
    pub shading: ShadingArg,
    /// Scatter N coloured point lights, in place of the scene's own.
    #[arg(long, value_name = "N")]
    pub lights: Option<u32>,
    /// Range of every light in metres, or inf for no range and no window; light-cutoff sets its own.
    #[arg(long, value_name = "R|inf", allow_hyphen_values = true)]
    pub light_range: Option<f64>,
    /// Seed of the scattered lights.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub light_seed: u64,
    /// Most frames to time of each setting, interleaved [default: 9, with --quick 3].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub rounds: Option<u32>,
    /// Fewer frames, a smaller picture.
    #[arg(long)]
    pub quick: bool,
    /// Write two figures of each knob into this folder, as NAME.svg and NAME.png, and NAME-2.
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Write one page of all tables and figures into this folder, as index.html.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Knobs that have landed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum KnobName {
    /// Pixels along a tile's side.
    Tile,
    /// Which lights a tile takes.
    Cull,
    /// What culling knows of a tile's depths.
    DepthBounds,
    /// What the G-buffer stores, and in how many bits it keeps normals.
    Gbuffer,
    /// Where light ends: the cut-off from which ranges are solved.
    LightCutoff,
    /// What light volumes add in.
    Accumulation,
    /// How deep clusters are, and with it the bits of their keys.
    Slices,
    /// Whether clusters tell normals apart.
    ClusterNormals,
    /// Samples a pixel.
    Msaa,
    /// Columns and rows of shadow maps.
    ShadowSize,
    /// Texels that edges of shadows are spread over.
    ShadowFilter,
    /// What light lists of blended surfaces know of depths; of scenes that have some.
    TransparentBounds,
    /// What of blended surfaces is put in order; of scenes that have some.
    TransparentSort,
    /// Gathers of bounced light; only where it is asked for, as the following.
    GiGathers,
    /// Share of light that bounced light may leave out.
    GiTolerance,
    /// How gathers of bounced light are put together.
    GiIteration,
    /// What the matrix of bounced light is read from.
    GiPath,
    /// Patches of bounced light.
    GiPatches,
    /// How the matrix of bounced light is stored.
    GiCodec,
}
