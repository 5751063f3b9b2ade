//! Debug views: pictures of intermediate values in display bytes, each with the legend that says what its colours mean.

use std::collections::BTreeSet;

use super::color_map;
use super::exposure::{self, Tonemap};
use super::picture::Picture;
use super::plot::legend::{Bar, Colors, Legend};
use crate::error::{Error, Result};

/// Pixels that miss a light.
pub const GREEN: [u8; 3] = [0, 255, 0];
/// What is not finite, as in every picture.
const MAGENTA: [u8; 3] = [255, 0, 255];
/// What has no number.
const BLACK: [u8; 3] = [0; 3];

/// How bright a lit picture stays behind what is shown over it.
const DARKENED: f64 = 0.35;

/// How a layer is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// Layer's RGB as it is.
    Color(&'static str),
    /// Layer's RGB, and what it is, scaled so that the largest channel is white.
    Brightness(&'static str, &'static str),
    /// Layer's three numbers from 0..1, and what they are.
    Shares(&'static str, &'static str),
    /// Layer's XYZ from -1..1.
    Direction(&'static str),
    /// Distance from a position layer's -z in false colour, logarithmic.
    Distance(&'static str),
    /// One value a pixel, scaled so that the largest is white.
    Raw(&'static str),
    /// One value a pixel in false colour.
    Numbers(Numbers),
    /// One id a pixel, and what it names, each in a colour of its own. A pixel without one holds a NaN.
    Identities(&'static str, &'static str),
}

/// A layer of one number a pixel, and how its numbers are spread over colours. A pixel without a number holds a NaN.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Numbers {
    /// Name of the layer.
    pub layer: &'static str,
    /// What the numbers are, with their unit.
    pub text: &'static str,
    /// What an infinite one says.
    pub infinite: &'static str,
    /// Number of the first colour; `None`: the smallest there is.
    pub low: Option<f64>,
    /// Number of the last colour; `None`: the largest there is.
    pub high: Option<f64>,
    /// By ratios, where all are positive.
    pub logarithmic: bool,
}

/// A view's picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Rows of RGBA8 pixels from the top.
    pub rgba8: Vec<u8>,
    /// What their colours mean.
    pub legend: Legend,
}

impl Shown {
    /// The picture with its legend below: rows from the top, and how many.
    ///
    /// # Errors
    /// The embedded font cannot be read.
    pub fn with_legend(&self, width: u32) -> Result<(Vec<u8>, u32)> {
        let mut rows = self.rgba8.clone();
        rows.extend(self.legend.rgba8(width)?);
        let height = rows.len() / (4 * width.max(1) as usize);
        Ok((rows, height as u32))
    }
}

/// Draws the view.
///
/// # Errors
/// A layer that the frame did not leave.
pub fn draw(picture: &Picture, view: View) -> Result<Shown> {
    let missing = |name: &str| Error::new(format!("the frame has no layer {name} to show"));
    let rgba = |name: &str| picture.rgba(name).ok_or_else(|| missing(name));
    let values = |name: &str| picture.layer(name).ok_or_else(|| missing(name));
    match view {
        View::Color(name) => {
            let text = "linear base colour, shown as sRGB";
            Ok(plain(exposure::display(rgba(name)?, 0.0, Tonemap::None), text))
        }
        View::Brightness(name, text) => Ok(brightness(rgba(name)?, text)),
        View::Shares(name, text) => {
            let text = format!("{text}, from 0 (dark) to 1 (bright)");
            Ok(plain(bytes(rgba(name)?.iter().map(|p| shares([p[0], p[1], p[2]]))), &text))
        }
        View::Direction(name) => {
            let colors = rgba(name)?.iter().map(direction);
            Ok(plain(bytes(colors), "normal in view space: x red, y green, z blue, from -1 (dark) to 1 (bright)"))
        }
        View::Distance(name) => {
            let distance = |p: &[f32; 4]| if covered(p) { -p[2] } else { f32::NAN };
            let distances: Vec<f32> = rgba(name)?.iter().map(distance).collect();
            let numbers = Numbers { text: "metres along the view axis", logarithmic: true, ..Numbers::default() };
            Ok(heat(&distances, &numbers))
        }
        View::Raw(name) => {
            let values = values(name)?;
            let most = f64::from(values.iter().copied().fold(0.0f32, f32::max));
            let bar = Bar { colors: Colors::Grey, low: 0.0, high: most, logarithmic: false };
            let text = "depth as stored: 1 at the near plane, 0 farthest".to_string();
            let rgba8 = bytes(values.iter().map(|&v| bar.color(f64::from(v))));
            Ok(Shown { rgba8, legend: Legend { bar: Some(bar), text, keys: Vec::new() } })
        }
        View::Numbers(numbers) => Ok(heat(values(numbers.layer)?, &numbers)),
        View::Identities(name, text) => Ok(identities(values(name)?, text)),
    }
}

/// RGB whose largest channel is white.
fn brightness(pixels: &[[f32; 4]], text: &str) -> Shown {
    let channels = pixels.iter().flat_map(|p| &p[..3]).copied();
    let most = channels.filter(|x| x.is_finite()).fold(0.0f32, f32::max);
    let rgba8 = exposure::display(pixels, if most > 0.0 { -f64::from(most).log2() } else { 0.0 }, Tonemap::None);
    let white = if most > 0.0 { format!("shown as sRGB: white is {most}") } else { "0 everywhere".into() };
    plain(rgba8, &format!("{text}, {white}"))
}

/// One id a pixel, each in a colour of its own; black where there is none.
fn identities(ids: &[f32], text: &str) -> Shown {
    let color = |&id: &f32| if id.is_finite() { color_map::identity(id as u32) } else { BLACK };
    let rgba8 = bytes(ids.iter().map(color));
    let seen: BTreeSet<u32> = ids.iter().filter(|id| id.is_finite()).map(|&id| id as u32).collect();
    plain(rgba8, &format!("{text}, each in a colour of its own: {} in the picture", seen.len()))
}

/// One number a pixel in false colour; black where there is none.
pub fn heat(values: &[f32], numbers: &Numbers) -> Shown {
    let finite = || values.iter().copied().map(f64::from).filter(|v| v.is_finite());
    let bar = finite().next().is_some().then(|| {
        let low = numbers.low.unwrap_or_else(|| finite().fold(f64::INFINITY, f64::min));
        let high = numbers.high.unwrap_or_else(|| finite().fold(low, f64::max));
        let logarithmic = numbers.logarithmic && low > 0.0;
        // A bar of counts that are all 0 still has two ends.
        let high = if high <= low && !logarithmic { low + 1.0 } else { high };
        Bar { colors: Colors::Viridis, low, high, logarithmic }
    });
    let color = |&value: &f32| match &bar {
        Some(bar) if value.is_finite() => bar.color(f64::from(value)),
        _ if value.is_infinite() => MAGENTA,
        _ => BLACK,
    };
    let rgba8 = bytes(values.iter().map(color));
    let mut keys = Vec::new();
    if values.iter().any(|v| v.is_infinite()) {
        keys.push((MAGENTA, format!("magenta: {}", numbers.infinite)));
    }
    let nothing = if bar.is_none() { ": nowhere" } else { "" };
    Shown { rgba8, legend: Legend { bar, text: format!("{}{nothing}", numbers.text), keys } }
}

/// A lit picture in dark grey, and in green the pixels of which `missed`, a number of lights a pixel, is not 0.
pub fn missed(lit: &[u8], missed: &[f32]) -> Shown {
    let found = || missed.iter().filter(|m| **m > 0.0);
    let (pixels, pairs) = (found().count(), found().map(|&m| f64::from(m)).sum::<f64>());
    let color = |(pixel, missed): (&[u8], &f32)| if *missed > 0.0 { GREEN } else { grey(pixel) };
    let rgba8 = bytes(lit.chunks_exact(4).zip(missed).map(color));
    let text = "lights that reach a pixel and are not in its list, over the picture in grey".to_string();
    let key = match pixels {
        0 => "green: no pixel misses a light".to_string(),
        _ => format!("green: a light is missed ({pixels} pixels, {pairs} pairs)"),
    };
    Shown { rgba8, legend: Legend { bar: None, text, keys: vec![(GREEN, key)] } }
}

/// A rectangle of pixels to outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outline {
    /// First and last column.
    pub columns: [u32; 2],
    /// First and last row.
    pub rows: [u32; 2],
    /// sRGB.
    pub color: [u8; 3],
}

/// A lit picture `width` pixels wide with outlines one pixel thick; later ones cover earlier ones.
pub fn outlined(lit: Vec<u8>, width: u32, outlines: &[Outline], text: String) -> Shown {
    let mut rgba8 = lit;
    let mut set = |x: u32, y: u32, [r, g, b]: [u8; 3]| {
        let at = (y as usize * width as usize + x as usize) * 4;
        if let Some(pixel) = rgba8.get_mut(at..at + 4).filter(|_| x < width) {
            pixel.copy_from_slice(&[r, g, b, 255]);
        }
    };
    for outline in outlines {
        let ([left, right], [top, bottom]) = (outline.columns, outline.rows);
        for x in left..=right {
            set(x, top, outline.color);
            set(x, bottom, outline.color);
        }
        for y in top..=bottom {
            set(left, y, outline.color);
            set(right, y, outline.color);
        }
    }
    Shown { rgba8, legend: Legend { bar: None, text, keys: Vec::new() } }
}

fn plain(rgba8: Vec<u8>, text: &str) -> Shown {
    Shown { rgba8, legend: Legend { bar: None, text: text.into(), keys: Vec::new() } }
}

fn bytes(colors: impl Iterator<Item = [u8; 3]>) -> Vec<u8> {
    colors.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
}

/// A layer of vectors is 0 where nothing was drawn.
fn covered(p: &[f32; 4]) -> bool {
    p[0] != 0.0 || p[1] != 0.0 || p[2] != 0.0
}

fn direction(p: &[f32; 4]) -> [u8; 3] {
    let xyz = [p[0], p[1], p[2]];
    if covered(p) { shares(xyz.map(|x| x * 0.5 + 0.5)) } else { BLACK }
}

/// Numbers from 0 to 1 as they are.
fn shares(numbers: [f32; 3]) -> [u8; 3] {
    let all = numbers.iter().all(|x| x.is_finite());
    if all { numbers.map(|x| (f64::from(x).clamp(0.0, 1.0) * 255.0).round() as u8) } else { MAGENTA }
}

/// Luma of display bytes (Rec. 709's weights), darkened.
fn grey(pixel: &[u8]) -> [u8; 3] {
    let [r, g, b] = [0, 1, 2].map(|i| f64::from(pixel[i]));
    [((0.2126 * r + 0.7152 * g + 0.0722 * b) * DARKENED).round() as u8; 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(shown: &Shown) -> Vec<[u8; 3]> {
        shown.rgba8.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
    }

    fn counts() -> Numbers {
        Numbers { layer: "n", text: "lights", infinite: "in vain", low: Some(0.0), ..Numbers::default() }
    }

    #[test]
    fn numbers_get_the_colours_of_the_legends_bar() {
        let shown = heat(&[0.0, 4.0, 8.0, f32::NAN, f32::INFINITY], &counts());
        let bar = shown.legend.bar.expect("a bar");
        assert_eq!((bar.low, bar.high, bar.logarithmic), (0.0, 8.0, false));
        assert_eq!(pixels(&shown), [bar.color(0.0), bar.color(4.0), bar.color(8.0), BLACK, MAGENTA]);
        assert_eq!(shown.legend.sentence(), "0 to 8: lights; magenta: in vain");
    }

    #[test]
    fn bars_of_one_number_and_of_none() {
        let high = |values: &[f32]| heat(values, &counts()).legend.bar.map(|bar| bar.high);
        assert_eq!((high(&[0.0, 0.0]), high(&[f32::NAN]), high(&[])), (Some(1.0), None, None));
        assert_eq!(heat(&[f32::NAN], &counts()).legend.sentence(), "lights: nowhere");
        let ratios = Numbers { low: None, logarithmic: true, ..counts() };
        let bar = |values: &[f32]| heat(values, &ratios).legend.bar.map(|bar| (bar.low, bar.high, bar.logarithmic));
        assert_eq!(bar(&[2.0, 2.0]), Some((2.0, 2.0, true)));
        assert_eq!(bar(&[-2.0, 2.0]), Some((-2.0, 2.0, false)), "behind the eye, through an orthographic lens");
    }

    #[test]
    fn only_missed_pixels_are_green() {
        let lit = [[200, 100, 50, 255], [255; 4], [0, 0, 0, 255]].concat();
        let shown = missed(&lit, &[0.0, 2.0, f32::NAN]);
        assert_eq!(pixels(&shown), [[41; 3], GREEN, [0; 3]]);
        assert!(shown.legend.sentence().ends_with("missed (1 pixels, 2 pairs)"), "{}", shown.legend.sentence());
        let none = missed(&lit, &[0.0; 3]);
        assert!(!pixels(&none).contains(&GREEN) && none.legend.sentence().ends_with("no pixel misses a light"));
    }

    #[test]
    fn outlines_are_one_pixel_thick() {
        let outline = Outline { columns: [1, 3], rows: [0, 2], color: [9; 3] };
        let shown = outlined(vec![0; 5 * 4 * 4], 5, &[outline], "quads".into());
        let drawn: String = pixels(&shown).iter().map(|p| if *p == [9; 3] { '#' } else { '.' }).collect();
        assert_eq!(drawn, [".###.", ".#.#.", ".###.", "....."].concat());
    }

    #[test]
    fn the_legend_stands_below_the_unchanged_picture() {
        let shown = heat(&[1.0; 64 * 3], &counts());
        let (rows, height) = shown.with_legend(64).expect("a legend");
        assert!(rows.starts_with(&shown.rgba8) && height > 3 + 20);
        assert_eq!(rows.len(), 64 * 4 * height as usize);
    }

    #[test]
    fn ids_are_told_apart_and_counted() {
        let shown = identities(&[0.0, 7.0, f32::NAN, 7.0, 8.0], "clusters");
        let drawn = pixels(&shown);
        assert_eq!((drawn[1], drawn[2]), (drawn[3], BLACK));
        assert!(drawn[0] != drawn[1] && drawn[1] != drawn[4] && drawn[0] != drawn[4], "{drawn:?}");
        assert_eq!(shown.legend.sentence(), "clusters, each in a colour of its own: 3 in the picture");
    }

    #[test]
    fn the_brightest_channel_is_white() {
        let shown = brightness(&[[4.0, 0.0, 1.0, 1.0], [0.0; 4], [f32::INFINITY, 0.0, 0.0, 1.0]], "emission");
        assert_eq!(pixels(&shown), [[255, 0, 137], BLACK, MAGENTA]);
        assert_eq!(shown.legend.sentence(), "emission, shown as sRGB: white is 4");
        let dark = brightness(&[[0.0; 4]], "emission");
        assert_eq!((pixels(&dark), dark.legend.sentence()), (vec![BLACK], "emission, 0 everywhere".to_string()));
    }

    #[test]
    fn layers_are_shown_or_named() {
        let mut picture = Picture::new(2, 1);
        picture.add_layer("normals", vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        picture.add_layer("raw", vec![0.25, 0.5]);
        picture.add_layer("material", vec![0.5, 0.0, 1.0, 1.0, f32::NAN, 0.0, 0.0, 1.0]);
        let shown = |view| draw(&picture, view).map(|shown| pixels(&shown));
        assert_eq!(shown(View::Direction("normals")), Ok(vec![[128, 128, 255], BLACK]));
        assert_eq!(shown(View::Raw("raw")), Ok(vec![[128; 3], [255; 3]]));
        assert_eq!(shown(View::Shares("material", "numbers")), Ok(vec![[128, 0, 255], MAGENTA]));
        let refused = shown(View::Numbers(counts())).expect_err("no such layer");
        assert_eq!(refused.to_string(), "the frame has no layer n to show");
    }
}
