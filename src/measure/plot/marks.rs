//! Colours and markers that stay apart for every kind of colour vision, and in grey by their shape.

use plotters::element::{Circle, Polygon};
use plotters::style::{Color, RGBColor, WHITE};
use plotters_backend::DrawingBackend;

use super::FINE;
use super::frame::{Area, Drawn, px};

/// Palette of Okabe and Ito ("Color Universal Design", 2008) without its yellow, which is too light on white.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// Shapes of markers. Their number shares no factor with the palette's: 35 series differ in colour or shape.
const SHAPES: usize = 5;

/// Distance of each shape's sides from its centre, for radius 1.
const INNER: [f64; SHAPES] = [1.0, 0.89, 0.6, 0.85, 0.6];

/// Colour of a series; every second round of the palette is lighter.
pub(super) fn colour(index: usize) -> RGBColor {
    let color = PALETTE[index % PALETTE.len()];
    let lighter = |part: u8| part / 2 + 127;
    match index / PALETTE.len() % 2 {
        0 => color,
        _ => RGBColor(lighter(color.0), lighter(color.1), lighter(color.2)),
    }
}

/// How a marker is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fill {
    /// Filled.
    Solid,
    /// Its outline.
    Hollow,
    /// Filled, with a ring around it.
    Ringed,
}

/// Draws the marker of series `index` at a place of the root area.
pub(super) fn marker<B: DrawingBackend>(root: &Area<B>, index: usize, at: (i32, i32), fill: Fill) -> Drawn<B> {
    let (color, radius) = (colour(index), f64::from(px(5)));
    if fill == Fill::Ringed {
        root.draw(&Circle::new(at, px(9), color.filled()))?;
        root.draw(&Circle::new(at, px(9) - 5, WHITE.filled()))?;
    }
    shape(root, index, at, radius, color)?;
    if fill == Fill::Hollow {
        let stroke = 1.6 * f64::from(FINE);
        shape(root, index, at, radius - stroke / INNER[index % SHAPES], WHITE)?;
    }
    Ok(())
}

/// A filled shape; shapes of one radius have about one area.
fn shape<B: DrawingBackend>(root: &Area<B>, index: usize, at: (i32, i32), radius: f64, color: RGBColor) -> Drawn<B> {
    let corner = |x: f64, y: f64| (at.0 + (x * radius).round() as i32, at.1 + (y * radius).round() as i32);
    let corners = match index % SHAPES {
        0 => return root.draw(&Circle::new(at, radius.round() as i32, color.filled())),
        1 => vec![corner(-0.89, -0.89), corner(0.89, -0.89), corner(0.89, 0.89), corner(-0.89, 0.89)],
        2 => vec![corner(0.0, -1.2), corner(1.04, 0.6), corner(-1.04, 0.6)],
        3 => vec![corner(0.0, -1.2), corner(1.2, 0.0), corner(0.0, 1.2), corner(-1.2, 0.0)],
        _ => vec![corner(0.0, 1.2), corner(1.04, -0.6), corner(-1.04, -0.6)],
    };
    root.draw(&Polygon::new(corners, color.filled()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_differ_in_colour_or_shape() {
        let looks: std::collections::BTreeSet<_> =
            (0..35).map(|i| (colour(i).0, colour(i).1, colour(i).2, i % SHAPES)).collect();
        assert_eq!(looks.len(), 35);
    }
}
