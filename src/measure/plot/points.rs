//! Points and lines over two axes.

use plotters::element::PathElement;
use plotters::style::{Color, RGBColor};
use plotters_backend::DrawingBackend;

use super::axis::{Span, position};
use super::frame::{Area, Chart, Drawn, Side, Words, axes, caption, names, nothing, px, surround};
use super::marks::{Fill, colour, marker};
use super::{Plot, Point, Scale, Series};

/// A point in positions of the axes.
struct Placed {
    x: f64,
    y: f64,
    /// Minus infinity where the spread reaches below a logarithmic axis.
    low: f64,
    high: f64,
    fill: Fill,
}

/// Draws the whole figure.
pub(super) fn draw<B: DrawingBackend>(root: &Area<B>, plot: &Plot) -> Drawn<B> {
    let placed: Vec<Vec<Option<Placed>>> = plot.series.iter().map(|series| place_all(plot, series)).collect();
    let hidden = placed.iter().flatten().filter(|point| point.is_none()).count();
    let shown = || placed.iter().flatten().flatten();
    let heights = shown().flat_map(|point| [point.y, point.low, point.high]).filter(|y| y.is_finite());
    let x = Span::around(plot.x.scale, shown().map(|point| point.x), false);
    let y = Span::around(plot.y.scale, heights, false);
    let words = Words {
        title: &plot.title,
        caption: caption(&plot.caption, hidden),
        names: names(plot.series.iter().map(|series| series.name.as_str())),
    };
    let area = surround(root, &words, &|index, at| key(root, plot, index, at))?;
    let x = Side { span: x, label: &plot.x.label, ticks: true };
    let y = Side { span: y, label: &plot.y.label, ticks: true };
    let chart = axes(&area, &x, &y)?;
    if shown().next().is_none() {
        return nothing(root, &chart);
    }
    for (index, points) in placed.iter().enumerate() {
        join(root, &chart, points, (index, plot.series[index].line))?;
    }
    for (index, points) in placed.iter().enumerate() {
        for point in points.iter().flatten() {
            spread(root, &chart, point, colour(index))?;
        }
    }
    // What is marked lies on top.
    for ringed in [false, true] {
        for (index, points) in placed.iter().enumerate() {
            for point in points.iter().flatten().filter(|point| (point.fill == Fill::Ringed) == ringed) {
                marker(root, index, at(&chart, point.x, point.y), point.fill)?;
            }
        }
    }
    Ok(())
}

fn place_all(plot: &Plot, series: &Series) -> Vec<Option<Placed>> {
    let fill = |index: usize| match series.marked.get(index) {
        _ if series.marked.is_empty() => Fill::Solid,
        Some(true) => Fill::Ringed,
        _ => Fill::Hollow,
    };
    series.points.iter().enumerate().map(|(index, point)| place(plot, point, fill(index))).collect()
}

/// `None` where a coordinate has no place.
fn place(plot: &Plot, point: &Point, fill: Fill) -> Option<Placed> {
    let scale = plot.y.scale;
    let (x, y) = (position(plot.x.scale, point.x)?, position(scale, point.y)?);
    let low = if scale == Scale::Log && point.low <= 0.0 {
        f64::NEG_INFINITY
    } else {
        position(scale, point.low).map_or(y, |low| low.min(y))
    };
    let high = position(scale, point.high).map_or(y, |high| high.max(y));
    Some(Placed { x, y, low, high, fill })
}

/// A place of the root area.
fn at<B: DrawingBackend>(chart: &Chart<'_, B>, x: f64, y: f64) -> (i32, i32) {
    chart.plotting_area().map_coordinate(&(x, y))
}

fn segment<B: DrawingBackend>(
    root: &Area<B>,
    from: (i32, i32),
    to: (i32, i32),
    (color, width): (RGBColor, i32),
) -> Drawn<B> {
    if from == to {
        return Ok(());
    }
    root.draw(&PathElement::new(vec![from, to], color.stroke_width(width as u32)))
}

/// Lines between neighbours that are both shown.
fn join<B: DrawingBackend>(
    root: &Area<B>,
    chart: &Chart<'_, B>,
    points: &[Option<Placed>],
    (index, line): (usize, bool),
) -> Drawn<B> {
    if !line {
        return Ok(());
    }
    for pair in points.windows(2) {
        if let [Some(a), Some(b)] = pair {
            segment(root, at(chart, a.x, a.y), at(chart, b.x, b.y), (colour(index), px(2)))?;
        }
    }
    Ok(())
}

/// The error bar of a point.
fn spread<B: DrawingBackend>(root: &Area<B>, chart: &Chart<'_, B>, point: &Placed, color: RGBColor) -> Drawn<B> {
    let floor = chart.plotting_area().get_y_range().start;
    let (low, high) = (at(chart, point.x, point.low.max(floor)), at(chart, point.x, point.high));
    if low == high {
        return Ok(());
    }
    let style = (color, px(1));
    segment(root, low, high, style)?;
    for end in [low, high] {
        segment(root, (end.0 - px(5), end.1), (end.0 + px(5), end.1), style)?;
    }
    Ok(())
}

/// A series' mark in the legend.
fn key<B: DrawingBackend>(root: &Area<B>, plot: &Plot, index: usize, (x, y): (i32, i32)) -> Drawn<B> {
    if plot.series[index].line {
        segment(root, (x - px(13), y), (x + px(13), y), (colour(index), px(2)))?;
    }
    marker(root, index, (x, y), Fill::Solid)
}
