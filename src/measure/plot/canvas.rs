//! The font of figures, and plotters' bitmap with text set as an SVG viewer sets it.

use ab_glyph::{Font, FontRef, OutlinedGlyph, ScaleFont, point};
use plotters::backend::BitMapBackend;
use plotters::style::{FontDesc, FontFamily, FontStyle, RGBColor, TextStyle};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};

use super::FINE;
use crate::error::{Error, Result};

/// Licence and making: `assets/font/`.
const FONT: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/font/dejavu-sans-subset.ttf"));

/// The embedded font's name, and in an SVG the list of fonts to try: the first two have the same widths.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Sizes of plotters an em: its SVG divides by this.
const SIZE_PER_EM: f64 = 1.24;

/// Height of the font's x in em, which SVG's `ex` is.
const X_HEIGHT: f32 = 0.547;

fn unreadable() -> Error {
    Error::new("the embedded font of figures could not be read")
}

/// Makes the embedded font known to plotters, which measures text by it. Safe to repeat.
pub(super) fn register_font() -> Result<()> {
    plotters::style::register_font(FAMILY, FontStyle::Normal, FONT).map_err(|_| unreadable())
}

/// Text whose em is `pixels` high.
pub(super) fn text(pixels: f64, color: RGBColor) -> TextStyle<'static> {
    let size = pixels * f64::from(FINE) * SIZE_PER_EM;
    FontDesc::new(FontFamily::Name(FAMILY), size, FontStyle::Normal).color(&color)
}

/// plotters' bitmap but for text: plotters leaves out the space to the left of each glyph, rounds every advance down and
/// puts the baseline elsewhere than in its SVG.
pub(super) struct Bitmap<'a> {
    bitmap: BitMapBackend<'a>,
    font: FontRef<'static>,
}

impl<'a> Bitmap<'a> {
    /// On rows of RGB bytes.
    pub fn new(pixels: &'a mut [u8], size: (u32, u32)) -> Result<Self> {
        if pixels.len() != size.0 as usize * size.1 as usize * 3 {
            return Err(Error::new("the figure could not be drawn: a bitmap of another size"));
        }
        let font = FontRef::try_from_slice(FONT).map_err(|_| unreadable())?;
        Ok(Self { bitmap: BitMapBackend::with_buffer(pixels, size), font })
    }

    /// Outlines of `text` along a baseline through the origin, and its width.
    fn set(&self, text: &str, em: f32) -> (Vec<OutlinedGlyph>, f32) {
        let scale = em * self.font.height_unscaled() / self.font.units_per_em().unwrap_or(2048.0);
        let font = self.font.as_scaled(scale);
        let (mut pen, mut before) = (0.0, None);
        let mut glyphs = Vec::new();
        for id in text.chars().map(|c| self.font.glyph_id(c)) {
            pen += before.map_or(0.0, |before| font.kern(before, id));
            glyphs.extend(self.font.outline_glyph(id.with_scale_and_position(scale, point(pen, 0.0))));
            pen += font.h_advance(id);
            before = Some(id);
        }
        (glyphs, pen)
    }
}

type Done<B> = std::result::Result<(), DrawingErrorKind<<B as DrawingBackend>::ErrorType>>;

impl DrawingBackend for Bitmap<'_> {
    type ErrorType = <BitMapBackend<'static> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.bitmap.get_size()
    }

    fn ensure_prepared(&mut self) -> Done<Self> {
        self.bitmap.ensure_prepared()
    }

    fn present(&mut self) -> Done<Self> {
        self.bitmap.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, color: BackendColor) -> Done<Self> {
        self.bitmap.draw_pixel(at, color)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done<Self> {
        self.bitmap.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done<Self> {
        self.bitmap.draw_rect(from, to, style, fill)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done<Self> {
        let em = (style.size() / SIZE_PER_EM) as f32;
        let (glyphs, width) = self.set(text, em);
        let left = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -width / 2.0,
            HPos::Right => -width,
        };
        // The `dy` that plotters' SVG gives each anchor.
        let baseline = match style.anchor().v_pos {
            VPos::Top => 0.76 * em,
            VPos::Center => 0.5 * X_HEIGHT * em,
            VPos::Bottom => -0.5 * X_HEIGHT * em,
        };
        let (color, turn) = (style.color(), style.transform());
        for glyph in glyphs {
            let corner = glyph.px_bounds().min;
            let (left, top) = ((left + corner.x).round() as i32, (baseline + corner.y).round() as i32);
            let mut done = Ok(());
            glyph.draw(|x, y, cover| {
                let (x, y) = turn.transform(left + x as i32, top + y as i32);
                let pixel = self.bitmap.draw_pixel((at.0 + x, at.1 + y), color.mix(f64::from(cover.clamp(0.0, 1.0))));
                if done.is_ok() {
                    done = pixel;
                }
            });
            done?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_what_reports_write() {
        let font = FontRef::try_from_slice(FONT).expect("a font");
        for c in (' '..='~').chain("äéµ×±°²…–−→≤≥≈∞".chars()) {
            assert_ne!(font.glyph_id(c).0, 0, "no glyph for {c:?}");
        }
        assert_eq!(font.glyph_id('\u{4e00}').0, 0, "the control: a character that was left out");
    }

    #[test]
    fn the_x_height_is_the_fonts() {
        let font = FontRef::try_from_slice(FONT).expect("a font");
        let outline = font.outline(font.glyph_id('x')).expect("an outline");
        let height = outline.bounds.max.y.max(outline.bounds.min.y) / font.units_per_em().expect("an em");
        assert!((height - X_HEIGHT).abs() < 1e-3, "{height}");
    }

    #[test]
    fn text_is_as_wide_as_its_advances() {
        let mut pixels = vec![0; 3];
        let bitmap = Bitmap::new(&mut pixels, (1, 1)).expect("a bitmap");
        let (glyphs, width) = bitmap.set("0 0", 100.0);
        assert_eq!(glyphs.len(), 2, "a space has no outline");
        // Advances of DejaVu Sans: 1303 of 2048 for a digit, 651 for the space.
        assert!((width - 100.0 * (2.0 * 1303.0 + 651.0) / 2048.0).abs() < 0.5, "{width}");
    }

    #[test]
    fn a_buffer_of_another_size_is_refused() {
        assert!(Bitmap::new(&mut [0; 5], (1, 1)).is_err());
    }
}
