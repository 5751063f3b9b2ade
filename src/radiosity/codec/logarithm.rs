//! 8-bit logarithms, with code 0 for zero.

/// Nats from code 1 to code 255, at least and at most. Ranges of 10 nats or more where values ask for 6 cost `bc1` a fifth of its accuracy in a room of
/// 429 patches.
pub const FEWEST: f64 = 4.0;
/// See [`FEWEST`].
pub const MOST: f64 = 12.0;
/// Of the sum of a channel, what may lie below code 1.
pub const LOST: f64 = 1e-4;

/// f32 of every code of one channel. `table[0]` is exactly 0; the others ascend.
pub type Table = [f32; 256];

/// Logarithms of one channel: code c of 1..=255 stands for `top * exp((c - 255) * step)`, code 0 for 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithm {
    /// What code 255 stands for; 0 where the channel has nothing in it.
    pub top: f64,
    /// Nats a code.
    pub step: f64,
}

impl Logarithm {
    /// The thesis' scale: `(ln(x / top) + 25) * 255 / 25`.
    pub fn thesis(top: f64) -> Self {
        Self { top, step: 25.0 / 255.0 }
    }

    /// The scale that a channel's own values ask for: code 255 is about the largest but `spare` of them, code 1 about the value under which all others
    /// together are [`LOST`] of the sum, but [`FEWEST`] to [`MOST`] nats below code 255.
    pub fn of(values: &[f32], spare: usize) -> Self {
        Self::with_loss(values, spare, LOST)
    }

    /// The same with another share of the sum that may lie below code 1.
    pub fn with_loss(values: &[f32], spare: usize, lost: f64) -> Self {
        // Positive f32 ascend as their bits do: bins of sign, exponent and 7 bits of mantissa, under 1 % wide.
        let mut bins = vec![(0u64, 0.0f64); 1 << 15];
        for value in values.iter().filter(|value| **value > 0.0) {
            let bin = &mut bins[(value.to_bits() >> 16) as usize];
            *bin = (bin.0 + 1, bin.1 + f64::from(*value));
        }
        let edge = |bin: usize| f64::from(f32::from_bits((bin as u32) << 16));
        let (mut above, mut below) = (0, 0.0);
        let lost = lost * bins.iter().map(|bin| bin.1).sum::<f64>();
        let is_top = |(_, bin): &(usize, &(u64, f64))| {
            above += bin.0;
            above > spare as u64
        };
        let Some((top, _)) = bins.iter().enumerate().rev().find(is_top) else { return Self { top: 0.0, step: 1.0 } };
        let is_bottom = |(_, bin): &(usize, &(u64, f64))| {
            below += bin.1;
            below > lost
        };
        let bottom = bins.iter().enumerate().find(is_bottom).map_or(top, |(bin, _)| bin);
        // The upper edge, unless that is infinity.
        let top = edge(top + 1).min(f32::MAX.into());
        let least = edge(bottom).max(f32::MIN_POSITIVE.into());
        Self { top, step: (top / least).ln().clamp(FEWEST, MOST) / 254.0 }
    }

    /// Whether a value is closer to 0 than to code 1: such values are stored as zeros.
    pub fn is_zero(&self, x: f32) -> bool {
        f64::from(x) < 0.5 * self.top * (-254.0 * self.step).exp() || x == 0.0 || self.top == 0.0
    }

    /// Code of a value, rounded to the nearest and clamped to 0..=255. Values that come to 0 or less are lost: [`Self::table`] has 0 for them.
    pub fn code(&self, x: f64) -> u8 {
        if x > 0.0 && self.top > 0.0 {
            ((x / self.top).ln() / self.step + 255.0).round().clamp(0.0, 255.0) as u8
        } else {
            0
        }
    }

    /// Unrounded code of a value, clamped to 0..=255.
    pub fn real_code(&self, x: f64) -> f32 {
        if x > 0.0 && self.top > 0.0 { ((x / self.top).ln() / self.step + 255.0).clamp(0.0, 255.0) as f32 } else { 0.0 }
    }

    /// The f32 of every code: the exponential in f64, rounded once.
    pub fn table(&self) -> Table {
        let of = |code: usize| (self.top * ((code as f64 - 255.0) * self.step).exp()) as f32;
        std::array::from_fn(|code| if code == 0 { 0.0 } else { of(code) })
    }
}

#[cfg(test)]
mod tests;
