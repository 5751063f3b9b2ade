//! Debug views: pictures of intermediate values, in display-linear RGB so that an exposure of 0 shows them as they are.

use std::borrow::Cow;

use super::exposure::false_color;
use super::picture::Picture;
use crate::error::{Error, Result};
use crate::math::srgb;

/// How a layer is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// Layer's RGB as it is.
    Color(&'static str),
    /// Layer's XYZ from -1..1.
    Direction(&'static str),
    /// Distance from a position layer's -z, false colour between nearest and farthest, logarithmic.
    Distance(&'static str),
    /// One value a pixel, scaled so that the largest is white.
    Raw(&'static str),
}

/// A view's picture, display-linear.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown<'a> {
    /// Rows from the top.
    pub pixels: Cow<'a, [[f32; 4]]>,
    /// What the first and the last colour stand for, where colours stand for numbers.
    pub range: Option<[f64; 2]>,
}

/// Draws the view.
///
/// # Errors
/// A layer that the frame did not leave.
pub fn draw(picture: &Picture, view: View) -> Result<Shown<'_>> {
    let missing = |name: &str| Error::new(format!("the frame has no layer {name} to show"));
    match view {
        View::Color(name) => {
            Ok(Shown { pixels: Cow::Borrowed(picture.rgba(name).ok_or_else(|| missing(name))?), range: None })
        }
        View::Direction(name) => {
            let rgba = picture.rgba(name).ok_or_else(|| missing(name))?;
            let shown = |p: &[f32; 4]| {
                let covered = p[0] != 0.0 || p[1] != 0.0 || p[2] != 0.0;
                if covered { linear([0, 1, 2].map(|i| f64::from(p[i]) * 0.5 + 0.5)) } else { [0.0; 4] }
            };
            Ok(Shown { pixels: rgba.iter().map(shown).collect(), range: None })
        }
        View::Distance(name) => {
            let rgba = picture.rgba(name).ok_or_else(|| missing(name))?;
            let distances: Vec<f64> = rgba.iter().map(|p| -f64::from(p[2])).collect();
            let covered = || distances.iter().copied().filter(|d| *d > 0.0);
            let (near, far) = (covered().fold(f64::INFINITY, f64::min), covered().fold(0.0, f64::max));
            let span = (far / near).ln().max(1e-9);
            let shown = |d: &f64| {
                if *d > 0.0 {
                    linear(false_color((d / near).ln() / span).map(|c| f64::from(c) / 255.0))
                } else {
                    [0.0; 4]
                }
            };
            Ok(Shown { pixels: distances.iter().map(shown).collect(), range: (far > 0.0).then_some([near, far]) })
        }
        View::Raw(name) => {
            let values = picture.layer(name).ok_or_else(|| missing(name))?;
            let most = f64::from(values.iter().copied().fold(0.0f32, f32::max));
            let scale = if most > 0.0 { 1.0 / most } else { 0.0 };
            let pixels = values.iter().map(|&v| linear([f64::from(v) * scale; 3])).collect();
            Ok(Shown { pixels, range: Some([0.0, most]) })
        }
    }
}

/// A display value as the linear value that the encoder turns back into it.
fn linear(display: [f64; 3]) -> [f32; 4] {
    let [r, g, b] = display.map(|x| srgb::decode(x.clamp(0.0, 1.0)) as f32);
    [r, g, b, 1.0]
}
