//! Seeded random numbers that are the same on every machine: SplitMix64 (Steele, Lea and Flood, "Fast splittable
//! pseudorandom number generators", OOPSLA 2014, figure 17).

/// A stream of numbers that depends on its seed alone. Not for cryptography.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Random {
    state: u64,
}

/// The odd integer nearest to 2^64 over the golden ratio: the step of the Weyl sequence.
const GAMMA: u64 = 0x9E37_79B9_7F4A_7C15;

impl Random {
    /// The stream of `seed`; every seed is as good as another.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// All 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GAMMA);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// Uniform in [0, 1): a multiple of 2^-53.
    pub fn unit_f64(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform from `low` towards `high`; rounding may reach `high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_outputs_are_those_of_the_published_generator() {
        let mut random = Random::new(0);
        assert_eq!(random.next_u64(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(random.next_u64(), 0x6E78_9E6A_A1B9_65F4);
        assert_eq!(random.next_u64(), 0x06C4_5D18_8009_454F);
    }

    #[test]
    fn unit_stays_below_one_and_is_centred() {
        let mut random = Random::new(7);
        let values: Vec<f64> = (0..4096).map(|_| random.unit_f64()).collect();
        assert!(values.iter().all(|v| (0.0..1.0).contains(v)));
        // Standard error of the mean: 1 / sqrt(12 * 4096) = 0.0045.
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
    }

    #[test]
    fn range_covers_its_interval() {
        let mut random = Random::new(3);
        let values: Vec<f64> = (0..1000).map(|_| random.range(-2.0, 6.0)).collect();
        assert!(values.iter().all(|v| (-2.0..=6.0).contains(v)));
        assert!(values.iter().any(|v| *v < -1.5) && values.iter().any(|v| *v > 5.5));
    }
}
