//! Options of deferred techniques.

use clap::ValueEnum;

/// `--deferred-lights`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeferredLightsArg {
    /// Each light blends into the pixels that its volume covers.
    Volumes,
    /// Every pixel loops over all lights in one pass.
    Fullscreen,
    /// The same with a range test that skips.
    FullscreenBranch,
}

/// `--gbuffer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum GbufferArg {
    /// Position, normal, albedo, specular and ambient in 32-bit floats: 80 bytes a pixel.
    Fat,
    /// Position from depth, the rest in 10 to 20 bytes a pixel.
    Compact,
}

/// `--accumulation`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AccumulationArg {
    /// 32-bit floats.
    F32,
    /// 16-bit floats: half the bytes, rounded after each light.
    F16,
}

/// `--normal-bits`.
pub(super) fn parse_normal_bits(text: &str) -> Result<u32, String> {
    match text {
        "8" => Ok(8),
        "10" => Ok(10),
        "16" => Ok(16),
        _ => Err("a code of a normal has 8, 10 or 16 bits".into()),
    }
}

/// `--pixels-a-thread`.
pub(super) fn parse_pixels_a_thread(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        _ => Err("a thread shades 1 or 4 pixels".into()),
    }
}
