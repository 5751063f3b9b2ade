//! What surrounds a figure's data: title, caption, legend and axes, each outside of the plotting area.

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor, TextStyle, WHITE};
use plotters_backend::DrawingBackend;

use super::FINE;
use super::axis::Span;
use super::canvas::text;

/// A part of the canvas, in drawing units from its corner.
pub(super) type Area<B> = DrawingArea<B, Shift>;

/// What drawing gives.
pub(super) type Drawn<B, T = ()> = std::result::Result<T, DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A plotting area with its axes.
pub(super) type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<Span, Span>>;

/// Colour of text and axes.
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
/// Colour of what stands back: captions, and words in place of data.
pub(super) const DIM: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(208, 208, 208);
const FAINT: RGBColor = RGBColor(234, 234, 234);

/// Characters of a text that are looked at: more do not fit into a figure of common size.
const LONGEST: usize = 1200;

/// Drawing units of a length in pixels.
pub(super) const fn px(pixels: i32) -> i32 {
    pixels * FINE
}

/// The words around the data.
pub(super) struct Words<'a> {
    /// Above.
    pub title: &'a str,
    /// Below.
    pub caption: String,
    /// In the legend, to the right; without any there is none.
    pub names: Vec<&'a str>,
}

/// An axis to draw.
pub(super) struct Side<'a> {
    /// Its range.
    pub span: Span,
    /// What it measures.
    pub label: &'a str,
    /// Whether it has ticks, else room for names of groups.
    pub ticks: bool,
}

/// A caption that also says how many values have no place in the figure.
pub(super) fn caption(text: &str, hidden: usize) -> String {
    let why = "not finite, or not positive where it must be";
    match hidden {
        0 => text.into(),
        1 => format!("{text} 1 value not shown ({why}).").trim_start().into(),
        _ => format!("{text} {hidden} values not shown ({why}).").trim_start().into(),
    }
}

/// Names for the legend: none for a single series without a name.
pub(super) fn names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let names: Vec<_> = names.collect();
    if names == [""] { Vec::new() } else { names }
}

/// Fills the background and draws the words; `key` draws the mark of a series in the legend, centred at a place of the root
/// area. Returns the room that is left.
pub(super) fn surround<B: DrawingBackend>(
    root: &Area<B>,
    words: &Words<'_>,
    key: &dyn Fn(usize, (i32, i32)) -> Drawn<B>,
) -> Drawn<B, Area<B>> {
    root.fill(&WHITE)?;
    let (width, height) = size(root);
    let (margin, inner) = (px(14), width - px(28));
    let (title_style, caption_style) = (text(17.0, INK), text(12.0, DIM));
    let title = lines(root, words.title, &title_style, (inner, 2))?;
    put(root, &title, &title_style, (margin, px(12), px(22)))?;
    let top = px(20) + title.len() as i32 * px(22);
    let caption = lines(root, &words.caption, &caption_style, (inner, 4))?;
    let bottom = px(12) + caption.len() as i32 * px(16);
    put(root, &caption, &caption_style, (margin, height - bottom, px(16)))?;
    let right = legend(root, &words.names, (top, height - bottom), key)?;
    Ok(root.margin(top, bottom + px(8), px(12), right))
}

/// Draws the legend at the right edge between two heights; returns the width it takes.
fn legend<B: DrawingBackend>(
    root: &Area<B>,
    names: &[&str],
    (upper, lower): (i32, i32),
    key: &dyn Fn(usize, (i32, i32)) -> Drawn<B>,
) -> Drawn<B, i32> {
    if names.is_empty() {
        return Ok(px(30));
    }
    let (width, _) = size(root);
    let (row, key_width) = (px(20), px(36));
    let style = text(13.0, INK);
    let room = ((lower - upper) / row).max(2) as usize;
    let shown = if names.len() > room { room - 1 } else { names.len() };
    let mut labels = Vec::new();
    for name in &names[..shown] {
        labels.push(shorten(root, &clean(name), &style, width * 3 / 10)?);
    }
    if shown < names.len() {
        labels.push(format!("and {} more", names.len() - shown));
    }
    let mut widest = 0;
    for label in &labels {
        widest = widest.max(text_width(root, label, &style)?);
    }
    let left = width - px(14) - widest - key_width;
    let style = style.pos(Pos::new(HPos::Left, VPos::Center));
    for (index, label) in labels.iter().enumerate() {
        let y = upper + index as i32 * row + row / 2;
        if index < shown {
            key(index, (left + px(14), y))?;
        }
        root.draw_text(label, &style, (left + key_width, y))?;
    }
    Ok(width - left + px(16))
}

/// Draws axes, grid and ticks into an area.
pub(super) fn axes<'a, B: DrawingBackend + 'a>(area: &Area<B>, x: &Side<'_>, y: &Side<'_>) -> Drawn<B, Chart<'a, B>> {
    let (width, height) = size(area);
    let small = text(12.0, INK);
    let below = px(if x.ticks { 46 } else { 60 });
    let y_ticks = ticks(height - below, 46);
    let mut widest = 0;
    for tick in y.span.major(y_ticks) {
        widest = widest.max(text_width(area, &y.span.format_ext(&tick), &small)?);
    }
    let beside = widest + px(34);
    let large = text(13.0, INK);
    let x_label = shorten(area, &clean(x.label), &large, width - beside)?;
    let y_label = shorten(area, &clean(y.label), &large, height - below)?;
    let mut chart = ChartBuilder::on(area)
        .set_label_area_size(LabelAreaPosition::Left, beside)
        .set_label_area_size(LabelAreaPosition::Bottom, below)
        .build_cartesian_2d(x.span.clone(), y.span.clone())?;
    let thin = FINE as u32;
    let mut mesh = chart.configure_mesh();
    mesh.x_labels(if x.ticks { ticks(width - beside, 80) } else { 0 })
        .y_labels(y_ticks)
        .label_style(small)
        .axis_desc_style(large)
        .axis_style(INK.stroke_width(thin))
        .bold_line_style(GRID.stroke_width(thin))
        .light_line_style(FAINT.stroke_width(thin))
        .set_all_tick_mark_size(px(4));
    if !x_label.is_empty() {
        mesh.x_desc(x_label);
    }
    if !y_label.is_empty() {
        mesh.y_desc(y_label);
    }
    mesh.draw()?;
    Ok(chart)
}

/// Ticks along `length` drawing units, one every `pixels`.
fn ticks(length: i32, pixels: i32) -> usize {
    (length / px(pixels)).clamp(2, 12) as usize
}

/// Says in the middle of the plotting area that there is no data.
pub(super) fn nothing<B: DrawingBackend>(root: &Area<B>, chart: &Chart<'_, B>) -> Drawn<B> {
    let (x, y) = chart.plotting_area().get_pixel_range();
    let style = text(16.0, DIM).pos(Pos::new(HPos::Center, VPos::Center));
    root.draw_text("nothing measured", &style, ((x.start + x.end) / 2, (y.start + y.end) / 2))
}

/// Width and height of an area.
fn size<B: DrawingBackend>(area: &Area<B>) -> (i32, i32) {
    let (width, height) = area.dim_in_pixel();
    (width as i32, height as i32)
}

fn text_width<B: DrawingBackend>(area: &Area<B>, text: &str, style: &TextStyle<'_>) -> Drawn<B, i32> {
    Ok(area.estimate_text_size(text, style)?.0 as i32)
}

/// `text` on one line of characters that XML allows.
fn clean(text: &str) -> String {
    let allowed = |c: char| match c {
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => ' ',
        c => c,
    };
    text.chars().take(LONGEST).map(allowed).collect()
}

/// `text`, ended with an ellipsis where it is wider than `width`.
fn shorten<B: DrawingBackend>(area: &Area<B>, text: &str, style: &TextStyle<'_>, width: i32) -> Drawn<B, String> {
    let (mut kept, mut shown) = (text.to_string(), text.to_string());
    while text_width(area, &shown, style)? > width && kept.pop().is_some() {
        shown = format!("{}…", kept.trim_end());
    }
    Ok(shown)
}

/// `text` broken after spaces and hyphens into lines of at most a width, and at most a number of them: what is left over, or
/// does not break, ends with an ellipsis.
pub(super) fn lines<B: DrawingBackend>(
    area: &Area<B>,
    text: &str,
    style: &TextStyle<'_>,
    (width, most): (i32, usize),
) -> Drawn<B, Vec<String>> {
    let text = clean(text);
    let (mut lines, mut line) = (Vec::new(), String::new());
    for piece in text.trim().split_inclusive([' ', '-']) {
        let longer = format!("{line}{piece}");
        // The last line takes all that is left and is shortened below.
        let breaks = !line.is_empty() && lines.len() + 1 < most && text_width(area, longer.trim_end(), style)? > width;
        line = if breaks {
            lines.push(line);
            piece.into()
        } else {
            longer
        };
    }
    if !line.is_empty() {
        lines.push(line);
    }
    for line in &mut lines {
        *line = shorten(area, line.trim_end(), style, width)?;
    }
    Ok(lines)
}

/// Draws lines below one another from a corner, `pitch` apart.
pub(super) fn put<B: DrawingBackend>(
    root: &Area<B>,
    lines: &[String],
    style: &TextStyle<'_>,
    (x, y, pitch): (i32, i32, i32),
) -> Drawn<B> {
    for (index, line) in lines.iter().enumerate() {
        root.draw_text(line, style, (x, y + index as i32 * pitch))?;
    }
    Ok(())
}
