//! Options of bounced light.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::plan::bounced::MOST_GATHERS;

/// Options of bounced light.
#[derive(Debug, Clone, Args)]
pub struct GiArgs {
    /// Diffuse light that did not come straight from a punctual light: off, radiosity between patches (baked to the cache, or a folder of `bake`),
    /// path (on the CPU, by --technique reference).
    #[arg(long, value_name = "off|radiosity[:DIR]|path", default_value = "off", value_parser = parse_gi)]
    pub gi: GiArg,
    /// Gathers of --gi radiosity [default: as many as --gi-tolerance needs].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_GATHERS)))]
    pub gi_gathers: Option<u32>,
    /// Share of all light that --gi radiosity may leave out, of bounced light where surfaces emit [default: 0.005].
    #[arg(long, value_name = "E", value_parser = parse_tolerance)]
    pub gi_tolerance: Option<f64>,
    /// How gathers of --gi radiosity are put together [default: chebyshev].
    #[arg(long, value_enum)]
    pub gi_iteration: Option<IterationArg>,
    /// Each frame of --gi radiosity goes on from the light of the frame before, with one gather or --gi-gathers.
    #[arg(long)]
    pub gi_feedback: bool,
    /// What the matrix of --gi radiosity is read from [default: auto].
    #[arg(long, value_enum)]
    pub gi_path: Option<MatrixPathArg>,
    /// Paths a pixel of --gi path [default: 64].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub spp: Option<u32>,
    /// Seed of the paths of --gi path [default: 1].
    #[arg(long, value_name = "S")]
    pub gi_seed: Option<u64>,
}

/// `--gi-iteration`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum IterationArg {
    /// By Chebyshev's polynomials.
    Chebyshev,
    /// Bounce by bounce.
    Neumann,
}

/// `--gi-path`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MatrixPathArg {
    /// What is quickest on the device.
    Auto,
    /// Words of a storage buffer.
    Buffer,
    /// Words of a texel buffer.
    Texel,
    /// Texels of an image, which a sampler decompresses.
    Sampled,
}

/// `--gi`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GiArg {
    /// None.
    Off,
    /// Between patches, from this folder or from the cache.
    Radiosity(Option<PathBuf>),
    /// Paths on the CPU, of --technique reference.
    Path,
}

fn parse_gi(text: &str) -> Result<GiArg, String> {
    match text.split_once(':') {
        None if text == "off" => Ok(GiArg::Off),
        None if text == "path" => Ok(GiArg::Path),
        None if text == "radiosity" => Ok(GiArg::Radiosity(None)),
        Some(("radiosity", folder)) if !folder.is_empty() => Ok(GiArg::Radiosity(Some(folder.into()))),
        _ => Err("bounced light is off, radiosity, radiosity:DIR or path".into()),
    }
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("a share between 0 and 1".into()),
    }
}
