//! Bars in groups, beside one another or stacked.

use plotters::element::Rectangle;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform};
use plotters_backend::DrawingBackend;

use super::axis::{Span, position};
use super::canvas::text;
use super::frame::{
    Area, Chart, DIM, Drawn, INK, Side, Words, axes, caption, lines, names, nothing, put, px, surround,
};
use super::marks::colour;
use super::{Bars, Scale};

/// What a series has in a group.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cell {
    /// Not measured.
    Missing,
    /// Measured, but without a place on the axis.
    Hidden,
    /// A height, in positions of the axis.
    Height(f64),
}

impl Cell {
    fn height(self) -> Option<f64> {
        match self {
            Self::Height(height) => Some(height),
            _ => None,
        }
    }
}

/// Draws the whole figure.
pub(super) fn draw<B: DrawingBackend>(root: &Area<B>, bars: &Bars) -> Drawn<B> {
    let scale = if bars.stacked { Scale::Linear } else { bars.y.scale };
    let groups: Vec<Vec<Cell>> = (0..bars.groups.len()).map(|group| cells(bars, scale, group)).collect();
    let hidden = groups.iter().flatten().filter(|cell| **cell == Cell::Hidden).count();
    let tops: Vec<f64> = if bars.stacked {
        groups.iter().map(|group| group.iter().filter_map(|cell| cell.height()).sum()).collect()
    } else {
        groups.iter().flatten().filter_map(|cell| cell.height()).collect()
    };
    let words = Words {
        title: &bars.title,
        caption: caption(&bars.caption, hidden),
        names: names(bars.series.iter().map(|series| series.0.as_str())),
    };
    let area = surround(root, &words, &|index, (x, y)| {
        root.draw(&Rectangle::new([(x - px(6), y - px(6)), (x + px(6), y + px(6))], colour(index).filled()))
    })?;
    let x = Side { span: Span::exact(0.0, bars.groups.len().max(1) as f64), label: "", ticks: false };
    let y = Side { span: Span::around(scale, tops.into_iter(), true), label: &bars.y.label, ticks: true };
    let chart = axes(&area, &x, &y)?;
    for (index, group) in groups.iter().enumerate() {
        let slot = Slot::of(&chart, scale, index);
        name(root, &chart, &bars.groups[index], slot)?;
        if bars.stacked {
            stack(root, &chart, group, slot)?;
        } else {
            beside(root, &chart, group, slot)?;
        }
    }
    if groups.iter().flatten().all(|cell| cell.height().is_none()) {
        nothing(root, &chart)?;
    }
    Ok(())
}

/// Cells of a group, one a series. Heights of stacked bars must not be negative: they would not add up to the stack's.
fn cells(bars: &Bars, scale: Scale, group: usize) -> Vec<Cell> {
    let cell = |values: &[Option<f64>]| match values.get(group).copied().flatten() {
        None => Cell::Missing,
        Some(value) if bars.stacked && value < 0.0 => Cell::Hidden,
        Some(value) => position(scale, value).map_or(Cell::Hidden, Cell::Height),
    };
    bars.series.iter().map(|series| cell(&series.1)).collect()
}

/// The room of a group, in drawing units of the root area.
#[derive(Clone, Copy)]
struct Slot {
    left: f64,
    right: f64,
    /// Height that bars stand on.
    base: i32,
}

impl Slot {
    fn of<B: DrawingBackend>(chart: &Chart<'_, B>, scale: Scale, group: usize) -> Self {
        let base = match scale {
            Scale::Linear => 0.0,
            Scale::Log => chart.plotting_area().get_y_range().start,
        };
        let place = |x: usize| chart.plotting_area().map_coordinate(&(x as f64, base));
        let (left, right) = (place(group), place(group + 1));
        Self { left: f64::from(left.0), right: f64::from(right.0), base: left.1 }
    }

    /// Its middle `share`.
    fn inner(self, share: f64) -> Self {
        let cut = (self.right - self.left) * (1.0 - share) / 2.0;
        Self { left: self.left + cut, right: self.right - cut, base: self.base }
    }

    fn middle(self) -> i32 {
        ((self.left + self.right) / 2.0).round() as i32
    }
}

fn name<B: DrawingBackend>(root: &Area<B>, chart: &Chart<'_, B>, name: &str, slot: Slot) -> Drawn<B> {
    let style = text(12.0, INK);
    let inner = slot.inner(0.94);
    let floor = chart.plotting_area().get_pixel_range().1.end;
    let lines = lines(root, name, &style, ((inner.right - inner.left) as i32, 3))?;
    put(root, &lines, &style.pos(Pos::new(HPos::Center, VPos::Top)), (slot.middle(), floor + px(6), px(16)))
}

/// One bar from `from` up to `to`, series `index`.
fn bar<B: DrawingBackend>(root: &Area<B>, slot: Slot, (from, to): (i32, i32), index: usize) -> Drawn<B> {
    // A line of background keeps neighbours apart where there is room for it.
    let gap = if slot.right - slot.left > f64::from(px(5)) { f64::from(px(1)) } else { 0.0 };
    let corners = [(slot.left.round() as i32, from), ((slot.right - gap).round() as i32, to)];
    root.draw(&Rectangle::new(corners, colour(index).filled()))
}

fn height<B: DrawingBackend>(chart: &Chart<'_, B>, position: f64) -> i32 {
    chart.plotting_area().map_coordinate(&(0.0, position)).1
}

fn beside<B: DrawingBackend>(root: &Area<B>, chart: &Chart<'_, B>, cells: &[Cell], slot: Slot) -> Drawn<B> {
    let inner = slot.inner(0.84);
    let width = (inner.right - inner.left) / cells.len() as f64;
    for (index, cell) in cells.iter().enumerate() {
        let left = inner.left + index as f64 * width;
        let own = Slot { left, right: left + width, base: slot.base };
        match *cell {
            Cell::Missing => not_measured(root, own, "n/a")?,
            Cell::Hidden => (),
            Cell::Height(top) => bar(root, own, (slot.base, height(chart, top)), index)?,
        }
    }
    Ok(())
}

fn stack<B: DrawingBackend>(root: &Area<B>, chart: &Chart<'_, B>, cells: &[Cell], slot: Slot) -> Drawn<B> {
    let mut own = slot.inner(0.6);
    let mut sum = 0.0;
    for (index, cell) in cells.iter().enumerate() {
        if let Cell::Height(part) = *cell {
            sum += part;
            let top = height(chart, sum);
            bar(root, own, (own.base, top), index)?;
            own.base = top;
        }
    }
    let measured = cells.iter().any(|cell| cell.height().is_some());
    match cells.contains(&Cell::Missing) {
        true if measured => not_measured(root, own, "+ n/a"),
        true => not_measured(root, own, "n/a"),
        false => Ok(()),
    }
}

/// Words above a slot's base, upright where there is room for them, else turned.
fn not_measured<B: DrawingBackend>(root: &Area<B>, slot: Slot, words: &str) -> Drawn<B> {
    let style = text(11.0, DIM);
    let place = (slot.middle(), slot.base - px(4));
    if slot.right - slot.left > f64::from(px(34)) {
        return root.draw_text(words, &style.pos(Pos::new(HPos::Center, VPos::Bottom)), place);
    }
    let turned = style.transform(FontTransform::Rotate270).pos(Pos::new(HPos::Left, VPos::Center));
    root.draw_text(words, &turned, place)
}
