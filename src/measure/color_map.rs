//! Colours for numbers: viridis (Smith and van der Walt, matplotlib 2.0), of even steps in lightness and safe for every colour vision;
//! and for names, of one lightness.

use crate::math::random::Random;
use crate::math::srgb;

/// sRGB at sixteen equal steps; between them lines.
const STOPS: [u32; 16] = [
    0x44_01_54, 0x48_1A_6C, 0x47_2F_7D, 0x41_44_87, 0x39_56_8C, 0x31_68_8E, 0x2A_78_8E, 0x23_88_8E, 0x1F_98_8B,
    0x22_A8_84, 0x35_B7_79, 0x54_C5_68, 0x7A_D1_51, 0xA5_DB_36, 0xD2_E2_1B, 0xFD_E7_25,
];

/// sRGB bytes of a share from 0 (violet) to 1 (yellow); the end's colour outside, and the first for what is not a number.
pub fn viridis(share: f64) -> [u8; 3] {
    let last = STOPS.len() - 1;
    let place = if share > 0.0 { share.min(1.0) * last as f64 } else { 0.0 };
    let index = (place as usize).min(last - 1);
    let along = place - index as f64;
    [16, 8, 0].map(|shift| {
        let [from, to] = [index, index + 1].map(|stop| f64::from((STOPS[stop] >> shift) & 0xFF));
        (from + (to - from) * along).round() as u8
    })
}

/// Relative luminance of the colours of ids, between those of pure green and pure red.
const LEVEL: f64 = 0.35;

/// sRGB bytes that tell ids apart: by a hash of the id one of many hues and of three strengths, all of one luminance, so that neither
/// looks like more.
pub fn identity(id: u32) -> [u8; 3] {
    let bits = Random::new(u64::from(id)).next_u64();
    let hue = (bits >> 32) as f64 / f64::from(u32::MAX) * 6.0;
    let strength = [0.4, 0.7, 1.0][(bits % 3) as usize];
    let pure = [0.0, 4.0, 2.0].map(|shift| (((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0).clamp(0.0, 1.0));
    let [r, g, b] = pure;
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    pure.map(|x: f64| {
        // Dark hues are mixed with white, bright ones with black, and then all with the grey of that luminance.
        let level = if luminance < LEVEL {
            x + (1.0 - x) * (LEVEL - luminance) / (1.0 - luminance)
        } else {
            x * LEVEL / luminance
        };
        (srgb::encode(LEVEL + (level - LEVEL) * strength) * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// CIE 1976 lightness of an sRGB colour.
    fn lightness([r, g, b]: [u8; 3]) -> f64 {
        let [r, g, b] = [r, g, b].map(|x| srgb::decode(f64::from(x) / 255.0));
        116.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt() - 16.0
    }

    #[test]
    fn ids_have_colours_of_one_lightness_and_neighbours_differ() {
        let colors: Vec<_> = (0..1000).map(identity).collect();
        let grey = lightness([LEVEL; 3].map(|x| (srgb::encode(x) * 255.0).round() as u8));
        assert!(colors.iter().all(|&color| (lightness(color) - grey).abs() < 1.0));
        assert!(colors.iter().collect::<BTreeSet<_>>().len() > 600, "few colours stand for two ids");
        let apart = |pair: &[[u8; 3]]| pair[0].iter().zip(pair[1]).map(|(a, b)| a.abs_diff(b)).max() > Some(10);
        assert!(colors.windows(2).filter(|pair| apart(pair)).count() > 950);
    }

    #[test]
    fn ends_and_what_lies_outside() {
        assert_eq!([0.0, -3.0, f64::NAN].map(viridis), [[68, 1, 84]; 3]);
        assert_eq!([1.0, f64::INFINITY].map(viridis), [[253, 231, 37]; 2]);
    }

    #[test]
    fn lightness_rises_evenly() {
        let steps: Vec<f64> = (0..=50).map(|i| lightness(viridis(f64::from(i) / 50.0))).collect();
        let mean = (steps[50] - steps[0]) / 50.0;
        for pair in steps.windows(2) {
            let step = pair[1] - pair[0];
            assert!((0.5 * mean..1.5 * mean).contains(&step), "a step of {step} where the mean is {mean}");
        }
    }
}
