//! `diff`: how far two pictures are apart, as numbers, as a heat map, and as a check.

use std::process::ExitCode;

use serde_json::json;

use super::report;
use crate::cli::Diff;
use crate::error::{Error, Result};
use crate::measure::color_map::viridis;
use crate::measure::{file, metrics, read};

/// Runs the command.
///
/// # Errors
/// Pictures that cannot be compared, or `--max` passed.
pub fn run(args: &Diff) -> Result<ExitCode> {
    if let Some(most) = args.max.filter(|m| !(m.is_finite() && *m >= 0.0)) {
        return Err(Error::usage(format!("--max {most} is not a difference from 0 on")));
    }
    if let Some(path) = args.output.as_deref().filter(|p| p.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")))
    {
        return Err(Error::usage(format!("{}: a heat map is written as .png", path.display())));
    }
    let (a, b) = (read::load(&args.a)?, read::load(&args.b)?);
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Error::new(format!(
            "{} is {}x{}, {} is {}x{}: they cannot be compared",
            args.a.display(),
            a.width,
            a.height,
            args.b.display(),
            b.width,
            b.height
        )));
    }
    if a.linear != b.linear {
        return Err(Error::new(
            "one picture is scene-linear (EXR), the other is for display (PNG): they cannot be compared",
        ));
    }
    let d = metrics::compare(&a.rgba, &b.rgba);
    if !report::json_on_stdout(args.json.as_deref()) {
        report::print(&format!(
            "rmse {:.6e}\nmax {:.6e}\nmean relative {:.6e}\nmax relative {:.6e}\ndiffering pixels {} of {}\n",
            d.rmse, d.max_abs, d.mean_relative, d.max_relative, d.differing_pixels, d.pixels
        ))?;
    }
    if let Some(path) = &args.output {
        write_heat_map(path, &a, &b, d.max_abs)?;
    }
    if let Some(path) = &args.json {
        // JSON has no infinity: a picture with a NaN in it compares as null.
        let value = json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "rmse": d.rmse, "max": d.max_abs, "mean_relative": d.mean_relative, "max_relative": d.max_relative,
            "differing_pixels": d.differing_pixels, "pixels": d.pixels,
        });
        report::write_json(path, &value)?;
    }
    match args.max {
        Some(most) if d.max_abs.is_nan() || d.max_abs > most => {
            Err(Error::new(format!("the largest difference is {:e}, more than --max {most:e}", d.max_abs)))
        }
        _ => Ok(ExitCode::SUCCESS),
    }
}

fn write_heat_map(path: &std::path::Path, a: &read::Loaded, b: &read::Loaded, most: f64) -> Result<()> {
    let scale = if most.is_finite() && most > 0.0 { 1.0 / most } else { 1.0 };
    let pixel = |(p, q): (&[f64; 4], &[f64; 4])| {
        let largest =
            (0..3).map(|i| (p[i] - q[i]).abs()).fold(0.0f64, |m, d| if d.is_nan() { f64::INFINITY } else { m.max(d) });
        let [r, g, b] = if largest == 0.0 { [0; 3] } else { viridis(largest * scale) };
        [r, g, b, 255]
    };
    let bytes: Vec<u8> = a.rgba.iter().zip(&b.rgba).flat_map(pixel).collect();
    file::write_png(path, [a.width as u32, a.height as u32], &bytes, &[])
}
