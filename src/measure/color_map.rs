//! Colours for numbers: viridis (Smith and van der Walt, matplotlib 2.0), of even steps in lightness and safe for every colour vision.

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::srgb;

    /// CIE 1976 lightness of an sRGB colour.
    fn lightness([r, g, b]: [u8; 3]) -> f64 {
        let [r, g, b] = [r, g, b].map(|x| srgb::decode(f64::from(x) / 255.0));
        116.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt() - 16.0
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
