//! Options of bounced light.

use clap::{Args, ValueEnum};

/// Options of bounced light.
#[derive(Debug, Clone, Args)]
pub struct GiArgs {
    /// Diffuse light that did not come straight from a punctual light.
    #[arg(long, value_enum, default_value = "off")]
    pub gi: GiArg,
    /// Paths a pixel of --gi path [default: 64].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub spp: Option<u32>,
    /// Seed of the paths of --gi path [default: 1].
    #[arg(long, value_name = "S")]
    pub gi_seed: Option<u64>,
}

/// `--gi`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum GiArg {
    /// None.
    Off,
    /// Paths on the CPU, of --technique reference.
    Path,
}
