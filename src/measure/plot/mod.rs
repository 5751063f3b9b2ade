//! Figures: one description of a plot or of bars, drawn by plotters as SVG and as PNG, the same picture in both.
//!
//! Everything is drawn on a grid three times finer than the size asked: coordinates are integers in plotters, and the
//! bitmap's averages are its anti-aliasing. No font of the system is needed (`assets/font/`).

mod axis;
mod bars;
mod canvas;
mod frame;
pub mod legend;
mod marks;
mod points;
#[cfg(test)]
mod tests;

use std::fmt;

use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;
use plotters_backend::DrawingBackend;

use self::frame::{Area, Drawn};
use crate::error::{Error, Result};

pub use self::axis::number;

/// Drawing units a pixel.
const FINE: i32 = 3;

/// Smallest and largest size of a figure in pixels: below, the words leave no room; above, the fine bitmap outgrows memory.
const SIZES: [(u32, u32); 2] = [(480, 300), (3840, 2160)];

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences, equal lengths.
    #[default]
    Linear,
    /// Equal ratios, equal lengths; only positive values have a place.
    Log,
}

/// An axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
}

/// A measured point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Point {
    /// Place along the x axis.
    pub x: f64,
    /// Place along the y axis.
    pub y: f64,
    /// Lower end of the spread in y; `y` where there is none.
    pub low: f64,
    /// Upper end of the spread in y; `y` where there is none.
    pub high: f64,
}

/// Points that belong together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; a single series without a name has no legend.
    pub name: String,
    /// The points, joined in this order.
    pub points: Vec<Point>,
    /// Whether neighbours are joined by a line; one that is not shown leaves a gap.
    pub line: bool,
    /// Points to stand out, for example a Pareto front: filled and ringed, the others hollow. Empty: all are filled.
    pub marked: Vec<bool>,
}

/// Points over two axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plot {
    /// Title, above the data.
    pub title: String,
    /// What the figure shows, below the data.
    pub caption: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The data.
    pub series: Vec<Series>,
}

/// Bars in groups, beside one another or stacked.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bars {
    /// Title, above the data.
    pub title: String,
    /// What the figure shows, below the data.
    pub caption: String,
    /// The vertical axis. Stacked bars have a linear one whatever its scale says: on any other, heights do not add.
    pub y: Axis,
    /// Names of the groups, from left to right.
    pub groups: Vec<String>,
    /// Name of each series and its value in each group; `None` was not measured: a gap with `n/a`.
    pub series: Vec<(String, Vec<Option<f64>>)>,
    /// Whether the series of a group stand on one another, the first lowest.
    pub stacked: bool,
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// Points over two axes.
    Plot(Plot),
    /// Bars in groups.
    Bars(Bars),
}

impl Figure {
    /// Its title.
    pub fn title(&self) -> &str {
        match self {
            Self::Plot(plot) => &plot.title,
            Self::Bars(bars) => &bars.title,
        }
    }

    /// Its caption.
    pub fn caption(&self) -> &str {
        match self {
            Self::Plot(plot) => &plot.caption,
            Self::Bars(bars) => &bars.caption,
        }
    }

    /// An SVG document of `size` (width, height) pixels.
    ///
    /// # Errors
    /// A size below 480 x 300 or above 3840 x 2160.
    pub fn svg(&self, size: (u32, u32)) -> Result<String> {
        let fine = fine_size(size)?;
        canvas::register_font()?;
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, fine).into_drawing_area();
            self.draw(&root).and_then(|()| root.present()).map_err(failed)?;
        }
        // The view box stays fine; only the size to show it at is in pixels.
        let attributes = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
        Ok(text.replacen(&attributes(fine), &attributes(size), 1))
    }

    /// A PNG file of `size` (width, height) pixels with text entries (keyword, text).
    ///
    /// # Errors
    /// A size below 480 x 300 or above 3840 x 2160; a keyword that PNG does not allow.
    pub fn png(&self, size: (u32, u32), notes: &[(String, String)]) -> Result<Vec<u8>> {
        let fine = fine_size(size)?;
        canvas::register_font()?;
        let mut pixels = vec![0; fine.0 as usize * fine.1 as usize * 3];
        {
            let root = canvas::Bitmap::new(&mut pixels, fine)?.into_drawing_area();
            self.draw(&root).and_then(|()| root.present()).map_err(failed)?;
        }
        let image =
            image::RgbImage::from_raw(fine.0, fine.1, pixels).ok_or_else(|| failed("a bitmap of another size"))?;
        encode(size, image::imageops::thumbnail(&image, size.0, size.1).as_raw(), notes).map_err(failed)
    }

    fn draw<B: DrawingBackend>(&self, root: &Area<B>) -> Drawn<B> {
        match self {
            Self::Plot(plot) => points::draw(root, plot),
            Self::Bars(bars) => bars::draw(root, bars),
        }
    }
}

fn fine_size(size: (u32, u32)) -> Result<(u32, u32)> {
    let [least, most] = SIZES;
    if !(least.0..=most.0).contains(&size.0) || !(least.1..=most.1).contains(&size.1) {
        return Err(Error::new(format!(
            "a figure of {}x{} pixels cannot be drawn: from {}x{} to {}x{} can",
            size.0, size.1, least.0, least.1, most.0, most.1
        )));
    }
    Ok((size.0 * FINE as u32, size.1 * FINE as u32))
}

fn failed(error: impl fmt::Display) -> Error {
    Error::new(format!("the figure could not be drawn: {error}"))
}

/// RGB rows as a PNG file, notes as iTXt chunks like those of every other picture.
fn encode(
    size: (u32, u32),
    rgb: &[u8],
    notes: &[(String, String)],
) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    for (keyword, text) in notes {
        encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(bytes)
}
