//! From scene-linear radiance to display bytes: exposure, tone curve, sRGB. Only pictures for people pass through here.

use crate::math::srgb;

/// Tone curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tonemap {
    /// Clipped at 1.
    None,
    /// Narkowicz' fit of the ACES curve (2015, "ACES Filmic Tone Mapping Curve").
    Aces,
    /// Khronos PBR Neutral (specification 2024): colours stay themselves below 0.8.
    Neutral,
}

impl Tonemap {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Aces => "aces",
            Self::Neutral => "neutral",
        }
    }
}

/// Luminance to which automatic exposure brings the logarithmic mean of the covered pixels.
const KEY: f64 = 0.18;

fn luminance(c: &[f32; 4]) -> f64 {
    0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
}

/// Exposure value of the automatic rule: `2^EV` times the radiance has the logarithmic mean luminance 0.18 over pixels that are
/// covered and not black; 0 where there is none.
pub fn automatic_ev(pixels: &[[f32; 4]]) -> f64 {
    let lit = pixels.iter().filter(|c| c[3] > 0.0).map(luminance).filter(|l| *l > 1e-6 && l.is_finite());
    let (sum, count) = lit.fold((0.0, 0usize), |(s, n), l| (s + l.log2(), n + 1));
    if count == 0 { 0.0 } else { KEY.log2() - sum / count as f64 }
}

fn aces(x: f64) -> f64 {
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// Khronos PBR Neutral, steps as its specification lists them.
fn neutral(mut c: [f64; 3]) -> [f64; 3] {
    const START: f64 = 0.8 - 0.04;
    const DESATURATION: f64 = 0.15;
    let low = c[0].min(c[1]).min(c[2]);
    let offset = if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    c = c.map(|x| x - offset);
    let peak = c[0].max(c[1]).max(c[2]);
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let mix = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    c.map(|x| x * new_peak / peak * (1.0 - mix) + new_peak * mix)
}

/// Display bytes, RGBA8. A pixel that is not finite is magenta, so that it is seen.
pub fn display(pixels: &[[f32; 4]], ev: f64, tonemap: Tonemap) -> Vec<u8> {
    let scale = ev.exp2();
    let mut bytes = Vec::with_capacity(pixels.len() * 4);
    for pixel in pixels {
        if !pixel[..3].iter().all(|x| x.is_finite()) {
            bytes.extend_from_slice(&[255, 0, 255, 255]);
            continue;
        }
        let c = [0, 1, 2].map(|i| (f64::from(pixel[i]) * scale).max(0.0));
        let mapped = match tonemap {
            Tonemap::None => c,
            Tonemap::Aces => c.map(aces),
            Tonemap::Neutral => neutral(c),
        };
        bytes.extend(mapped.map(|x| (srgb::encode(x.clamp(0.0, 1.0)) * 255.0).round() as u8));
        bytes.push(255);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_brings_grey_to_the_key() {
        let pixels = [[0.5, 0.5, 0.5, 1.0], [2.0, 2.0, 2.0, 1.0], [9.0, 9.0, 9.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let ev = automatic_ev(&pixels);
        assert!((1.0 * ev.exp2() - KEY).abs() < 1e-9, "the geometric mean of 0.5 and 2 is 1: {ev}");
        assert_eq!(automatic_ev(&[[0.0; 4]]), 0.0);
    }

    #[test]
    fn curves_keep_black_and_are_monotone() {
        for tonemap in [Tonemap::None, Tonemap::Aces, Tonemap::Neutral] {
            let ramp: Vec<[f32; 4]> = (0..64).map(|i| [i as f32 / 16.0; 4]).collect();
            let bytes = display(&ramp, 0.0, tonemap);
            assert_eq!(bytes[0], 0, "{}", tonemap.name());
            assert!(bytes.chunks(4).zip(bytes.chunks(4).skip(1)).all(|(a, b)| a[0] <= b[0]), "{}", tonemap.name());
        }
    }

    #[test]
    fn a_pixel_that_is_not_a_number_is_seen() {
        assert_eq!(display(&[[f32::NAN, 0.0, 0.0, 1.0]], 0.0, Tonemap::None), [255, 0, 255, 255]);
    }
}
