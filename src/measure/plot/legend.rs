//! Legends of debug views: rows of pixels to stand below a picture, with a bar of its colours, their numbers and sentences.

use image::RgbImage;
use image::imageops::thumbnail;
use plotters::drawing::IntoDrawingArea;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters_backend::DrawingBackend;

use super::canvas::{self, Bitmap, text};
use super::frame::{Area, Drawn, INK, lines, px};
use super::{FINE, failed, number};
use crate::error::Result;
use crate::measure::color_map::viridis;

/// Pixels from a line of text to the next.
const LINE: i32 = 16;
/// Em of the text in pixels.
const EM: f64 = 12.0;
/// Pixels around everything; less in narrow pictures.
const MARGIN: i32 = 6;
/// Rows of the bar.
const BAR: i32 = 12;
/// Edge of the square that shows a colour of its own.
const SQUARE: i32 = 10;
/// Lines that a sentence is broken into at most.
const MOST_LINES: usize = 6;

/// Colours that numbers are drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colors {
    /// See [`viridis`].
    Viridis,
    /// Black to white.
    Grey,
}

/// Numbers as colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Which colours.
    pub colors: Colors,
    /// The number of the first colour; positive on a logarithmic bar.
    pub low: f64,
    /// The number of the last colour, at least `low`.
    pub high: f64,
    /// Equal ratios of numbers are equal lengths, else equal differences.
    pub logarithmic: bool,
}

impl Bar {
    /// Colour of a number; outside of the bar that of its end.
    pub fn color(&self, value: f64) -> [u8; 3] {
        let place = |x: f64| if self.logarithmic { x.ln() } else { x };
        let size = place(self.high) - place(self.low);
        self.color_at(if size > 0.0 { (place(value) - place(self.low)) / size } else { 0.0 })
    }

    fn color_at(&self, share: f64) -> [u8; 3] {
        match self.colors {
            Colors::Viridis => viridis(share),
            Colors::Grey => [(share.clamp(0.0, 1.0) * 255.0).round() as u8; 3],
        }
    }

    /// The number half-way along.
    fn middle(&self) -> f64 {
        if self.logarithmic { self.low.sqrt() * self.high.sqrt() } else { 0.5 * (self.low + self.high) }
    }
}

/// What the colours of a picture mean.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Legend {
    /// Where colours stand for numbers.
    pub bar: Option<Bar>,
    /// What the picture shows, with its unit.
    pub text: String,
    /// Colours with a meaning of their own.
    pub keys: Vec<([u8; 3], String)>,
}

/// Where things stand, in pixels from the upper left corner.
struct Layout {
    /// First column and number of columns.
    columns: [i32; 2],
    rows: i32,
    bar_top: Option<i32>,
    /// Upper left corners.
    squares: Vec<([i32; 2], [u8; 3])>,
    words: Vec<Word>,
}

struct Word {
    text: String,
    anchor: HPos,
    at: [i32; 2],
}

impl Legend {
    /// All of it in words, for a terminal.
    pub fn sentence(&self) -> String {
        let bar = self.bar.as_ref().map(|bar| format!("{} to {}: ", short(bar.low), short(bar.high)));
        let keys = self.keys.iter().map(|(_, text)| format!("; {text}"));
        format!("{}{}{}", bar.unwrap_or_default(), self.text, keys.collect::<String>())
    }

    /// Rows of `width` RGBA8 pixels, from the top: as many as the words need.
    ///
    /// # Errors
    /// The embedded font cannot be read.
    pub fn rgba8(&self, width: u32) -> Result<Vec<u8>> {
        canvas::register_font()?;
        let layout = self.layout(width)?;
        let size = (width, layout.rows.unsigned_abs());
        let fine = (size.0 * FINE as u32, size.1 * FINE as u32);
        let mut pixels = vec![255; fine.0 as usize * fine.1 as usize * 3];
        {
            let root = Bitmap::new(&mut pixels, fine)?.into_drawing_area();
            layout.write(&root).and_then(|()| root.present()).map_err(failed)?;
        }
        let image = RgbImage::from_raw(fine.0, fine.1, pixels).ok_or_else(|| failed("a bitmap of another size"))?;
        let words = thumbnail(&image, size.0, size.1);
        let mut rgba8: Vec<u8> = words.pixels().flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        self.paint(&layout, width as usize, &mut rgba8);
        Ok(rgba8)
    }

    fn layout(&self, width: u32) -> Result<Layout> {
        let mut pixel = [255; 3];
        let ruler = Bitmap::new(&mut pixel, (1, 1))?.into_drawing_area();
        self.place(&ruler, width as i32).map_err(failed)
    }

    fn place<B: DrawingBackend>(&self, ruler: &Area<B>, width: i32) -> Drawn<B, Layout> {
        let margin = MARGIN.min(width / 8);
        let inner = width - 2 * margin;
        let mut layout =
            Layout { columns: [margin, inner], rows: MARGIN, bar_top: None, squares: Vec::new(), words: Vec::new() };
        if let Some(bar) = &self.bar {
            layout.bar_top = Some(layout.rows);
            layout.rows += BAR + 2;
            layout.numbers(ruler, bar)?;
        }
        layout.sentence(ruler, &self.text, 0)?;
        for (color, text) in &self.keys {
            layout.squares.push(([margin, layout.rows + (LINE - SQUARE) / 2], *color));
            layout.sentence(ruler, text, SQUARE + MARGIN)?;
        }
        layout.rows += MARGIN;
        Ok(layout)
    }

    /// Bar and squares, on the pixels themselves: their colours are exactly the picture's.
    fn paint(&self, layout: &Layout, width: usize, rgba8: &mut [u8]) {
        let [left, columns] = layout.columns;
        let mut set = |x: i32, y: i32, [r, g, b]: [u8; 3]| {
            let at = (y as usize * width + x as usize) * 4;
            if let Some(pixel) = rgba8.get_mut(at..at + 4).filter(|_| x >= 0 && (x as usize) < width) {
                pixel.copy_from_slice(&[r, g, b, 255]);
            }
        };
        if let (Some(bar), Some(top)) = (&self.bar, layout.bar_top) {
            for x in 0..columns {
                let color = bar.color_at(f64::from(x) / f64::from((columns - 1).max(1)));
                (top..top + BAR).for_each(|y| set(left + x, y, color));
            }
        }
        for ([left, top], color) in &layout.squares {
            for y in 0..SQUARE {
                (0..SQUARE).for_each(|x| set(left + x, top + y, *color));
            }
        }
    }
}

impl Layout {
    /// The bar's numbers at its ends and, where there is room, in the middle; in a sentence where the ends have no room.
    fn numbers<B: DrawingBackend>(&mut self, ruler: &Area<B>, bar: &Bar) -> Drawn<B> {
        let [left, columns] = self.columns;
        let style = text(EM, INK);
        let texts = [bar.low, bar.middle(), bar.high].map(short);
        let mut widths = [0; 3];
        for (width, text) in widths.iter_mut().zip(&texts) {
            *width = ruler.estimate_text_size(text, &style)?.0 as i32;
        }
        let [low, middle, high] = texts;
        let gap = px(8);
        if widths[0] + widths[2] + gap > px(columns) {
            return self.sentence(ruler, &format!("{low} to {high}"), 0);
        }
        let row = self.rows;
        let mut put = |text, anchor, x| self.words.push(Word { text, anchor, at: [x, row] });
        put(low, HPos::Left, left);
        put(high, HPos::Right, left + columns);
        if 2 * widths[0].max(widths[2]) + widths[1] + 2 * gap <= px(columns) {
            put(middle, HPos::Center, left + columns / 2);
        }
        self.rows += LINE;
        Ok(())
    }

    /// Lines of text, `indent` pixels to the right.
    fn sentence<B: DrawingBackend>(&mut self, ruler: &Area<B>, sentence: &str, indent: i32) -> Drawn<B> {
        let [left, columns] = self.columns;
        let room = px((columns - indent).max(1));
        for text in lines(ruler, sentence, &text(EM, INK), (room, MOST_LINES))? {
            self.words.push(Word { text, anchor: HPos::Left, at: [left + indent, self.rows] });
            self.rows += LINE;
        }
        Ok(())
    }

    fn write<B: DrawingBackend>(&self, root: &Area<B>) -> Drawn<B> {
        let style = text(EM, INK);
        for word in &self.words {
            let style = style.pos(Pos::new(word.anchor, VPos::Top));
            root.draw_text(&word.text, &style, (px(word.at[0]), px(word.at[1])))?;
        }
        Ok(())
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    number(format!("{value:.3e}").parse().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend(text: &str) -> Legend {
        let bar = Bar { colors: Colors::Viridis, low: 0.0, high: 35.0, logarithmic: false };
        Legend { bar: Some(bar), text: text.into(), keys: vec![([0, 255, 0], "missed".into())] }
    }

    fn pixel(rgba8: &[u8], width: u32, x: u32, y: u32) -> [u8; 3] {
        let at = (y * width + x) as usize * 4;
        [rgba8[at], rgba8[at + 1], rgba8[at + 2]]
    }

    #[test]
    fn the_bar_begins_and_ends_with_the_pictures_colours() {
        let (rgba8, legend) = (legend("lights").rgba8(200).expect("a legend"), legend("lights"));
        let bar = legend.bar.expect("a bar");
        assert_eq!(pixel(&rgba8, 200, 6, 8), bar.color(0.0));
        assert_eq!(pixel(&rgba8, 200, 193, 8), bar.color(35.0));
        assert_eq!(pixel(&rgba8, 200, 5, 8), [255; 3], "the margin");
        assert!(rgba8.chunks_exact(4).any(|p| p == [0, 255, 0, 255]), "the key's square");
    }

    #[test]
    fn there_is_ink_where_the_numbers_stand() {
        let rgba8 = legend("").rgba8(200).expect("a legend");
        let dark = |columns: std::ops::Range<u32>| {
            let rows = (6 + 12 + 2)..(6 + 12 + 2 + 16);
            rows.flat_map(|y| columns.clone().map(move |x| (x, y))).any(|(x, y)| pixel(&rgba8, 200, x, y)[0] < 128)
        };
        assert!(dark(0..30) && dark(85..115) && dark(170..200));
        assert!(!dark(40..70), "between the numbers is nothing");
    }

    #[test]
    fn longer_words_take_more_rows_and_any_width_has_a_legend() {
        let rows = |legend: &Legend, width: u32| legend.rgba8(width).expect("a legend").len() / (4 * width as usize);
        let words = "lights that reach the pixel and are not in the list of its cell";
        assert!(rows(&legend(words), 200) > rows(&legend("lights"), 200));
        for width in [1, 2, 7, 16, 97, 4000] {
            assert!(rows(&legend(words), width) > 40, "{width}");
        }
    }

    #[test]
    fn a_logarithmic_bar_has_equal_ratios() {
        let bar = Bar { colors: Colors::Grey, low: 1.0, high: 100.0, logarithmic: true };
        assert_eq!((bar.color(10.0), bar.middle()), ([128; 3], 10.0));
        assert_eq!([bar.color(0.5), bar.color(1e9)], [[0; 3], [255; 3]]);
        let flat = Bar { low: 2.0, high: 2.0, ..bar };
        assert_eq!(flat.color(2.0), [0; 3]);
    }

    #[test]
    fn the_sentence_says_what_the_rows_show() {
        assert_eq!(legend("lights").sentence(), "0 to 35: lights; missed");
        assert_eq!(short(1234.567), "1235");
        assert_eq!(short(std::f64::consts::PI), "3.142");
    }
}
