//! `resolution`: every technique over the size of the picture.

use serde_json::json;

use super::output::{About, Outcome};
use super::run::{Runner, contenders};
use super::sweep::{Place, Shown, Sweep, log_axis};
use crate::error::Result;
use crate::measure::plot::{self, Scale};

const LIGHTS: u32 = 1024;

/// Metres.
const RANGE: f64 = 1.0;

/// Quarters of the largest width and height.
const QUARTERS: &[u64] = &[1, 2, 3, 4];
const QUICK_QUARTERS: &[u64] = &[2, 4];

fn sizes((width, height): (u32, u32), quarters: &[u64]) -> Vec<(u32, u32)> {
    let part = |whole: u32, quarter: u64| (u64::from(whole) * quarter / 4).max(1) as u32;
    let mut sizes: Vec<_> = quarters.iter().map(|&q| (part(width, q), part(height, q))).collect();
    sizes.dedup();
    sizes
}

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load("builtin:atrium")?;
    let (count, range) = (runner.count(LIGHTS), runner.range(RANGE));
    let largest = runner.size((1920, 1080), (960, 540));
    let sizes = sizes(largest, runner.either(QUARTERS, QUICK_QUARTERS));
    runner.light(&mut loaded, count)?;
    let mut session = runner.session("resolution", sizes.len() * contenders().len());
    let mut sweep = Sweep::new("size");
    for (width, height) in sizes {
        let pixels = f64::from(width) * f64::from(height);
        let cases = runner.sized(contenders(), (width, height), range);
        let cells = session.group(&loaded.scene, &cases, Some(pixels))?;
        let facts = json!({ "width": width, "height": height, "lights": count, "light_range": range });
        sweep.places.push(Place { name: format!("{width}x{height}"), x: pixels, facts, cells });
    }
    drop(session);
    let about = About {
        name: "resolution",
        title: format!("resolution: {}, {count} lights", loaded.spec),
        lights: format!("lights of range {} m", plot::number(range)),
        size: largest,
        scenes: vec![loaded.facts],
    };
    let figure = sweep.plot(runner, &about.title, log_axis("pixels"), (Shown::Milliseconds, Scale::Log));
    Ok(Outcome::of_sweep(runner, &sweep, about, vec![figure]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_the_aspect_and_have_a_pixel() {
        assert_eq!(sizes((1920, 1080), QUARTERS), [(480, 270), (960, 540), (1440, 810), (1920, 1080)]);
        assert_eq!(sizes((1, 1), QUARTERS), [(1, 1)]);
        assert_eq!(sizes((u32::MAX, 4), &[4]), [(u32::MAX, 4)]);
    }
}
