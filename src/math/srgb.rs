//! sRGB's transfer curve (IEC 61966-2-1), both ways, over 0 to 1.

/// Light of an encoded value.
pub fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encoded value of light.
pub fn encode(light: f64) -> f64 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_the_other_way_round() {
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((decode(encode(x)) - x).abs() < 1e-7, "{x}");
        }
        assert!((decode(0.5) - 0.214_041_140_482).abs() < 1e-12);
    }
}
