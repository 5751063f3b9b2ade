//! An axis's range, its ticks, and where a value lies on it. Positions are values on a linear axis, their decimal
//! logarithms on a logarithmic one.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::Scale;

/// Values beyond this have no place: sums and differences of them could overflow.
const LARGEST: f64 = 1e100;

/// Relative size of a range below which its ends count as one value: [`number`] could not tell its ticks apart.
const FLAT: f64 = 1e-4;

/// Where `value` lies, `None` where it has no place: not finite, or not positive on a logarithmic axis.
pub(super) fn position(scale: Scale, value: f64) -> Option<f64> {
    match scale {
        Scale::Linear => (value.abs() < LARGEST).then_some(value),
        Scale::Log => (value > 0.0 && value < LARGEST).then(|| value.log10()),
    }
}

/// `value` with at most seven significant digits and no idle zeros, as a power of ten from a million on and below 0.0001.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { value.to_string() };
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..6.0).contains(&exponent) {
        let decimals = (6.0 - exponent).clamp(0.0, 9.0) as usize;
        return trim(&format!("{value:.decimals$}")).into();
    }
    let text = format!("{value:.6e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{}e{power}", trim(digits))
}

fn trim(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// The part of an axis that a figure shows, `low` below `high`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Span {
    /// Exactly from `low` to `high`, linear.
    pub fn exact(low: f64, high: f64) -> Self {
        Self { scale: Scale::Linear, low, high }
    }

    /// Around finite positions, with a margin. A linear span starts at zero where that costs at most half of it, and always
    /// for bars; a logarithmic one of bars starts at a power of ten below them all.
    pub fn around(scale: Scale, positions: impl Iterator<Item = f64>, bars: bool) -> Self {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = positions.fold(ends, |(low, high), p| (low.min(p), high.max(p)));
        if low > high {
            return Self { scale, low: 0.0, high: 1.0 };
        }
        let (low, high) = match scale {
            Scale::Linear => linear(low, high, bars),
            Scale::Log => {
                let margin = if high - low < FLAT { 0.5 } else { 0.05 * (high - low) };
                (if bars { (low - 0.1).floor() } else { low - margin }, high + margin)
            }
        };
        Self { scale, low, high }
    }

    /// Positions of at most about `most` labelled ticks.
    pub fn major(&self, most: usize) -> Vec<f64> {
        if self.scale == Scale::Linear || most == 0 {
            return steps(self.low, self.high, most);
        }
        let whole = self.multiples(&[1.0]);
        if whole.len() >= 3 {
            return whole.iter().copied().step_by(whole.len().div_ceil(most)).collect();
        }
        let finer = self.multiples(&[1.0, 2.0, 5.0]);
        if (3..=most.max(3)).contains(&finer.len()) {
            return finer;
        }
        if whole.len() == 2 {
            return whole;
        }
        steps(10f64.powf(self.low), 10f64.powf(self.high), most)
            .into_iter()
            .filter_map(|v| position(self.scale, v))
            .collect()
    }

    /// Positions of the lines between the ticks: 2 to 9 times each power of ten, where the powers are ticks and few.
    fn minor(&self, most: usize) -> Vec<f64> {
        let powers = self.high - self.low;
        if self.scale == Scale::Linear || !(2.0..=most as f64).contains(&powers) {
            return Vec::new();
        }
        self.multiples(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    }

    /// Positions in the span of `factors` times powers of ten, rising.
    fn multiples(&self, factors: &[f64]) -> Vec<f64> {
        let powers = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = powers.flat_map(|power| factors.iter().map(move |factor| f64::from(power) + factor.log10()));
        all.filter(|p| (self.low..=self.high).contains(p)).collect()
    }
}

fn linear(low: f64, high: f64, bars: bool) -> (f64, f64) {
    let near_zero = low >= 0.0 && low <= high / 2.0;
    let low = if bars {
        low.min(0.0)
    } else if near_zero {
        0.0
    } else {
        low
    };
    let high = if bars { high.max(0.0) } else { high };
    let size = high - low;
    // An end at zero stays there: nothing lies beyond.
    let moved = |end: f64, by: f64| if end == 0.0 { 0.0 } else { end + by };
    if high == 0.0 && low == 0.0 {
        (0.0, 1.0)
    } else if size <= FLAT * low.abs().max(high.abs()) {
        let half = low.abs().max(high.abs()) / 2.0;
        (low - half, high + half)
    } else {
        (moved(low, -0.05 * size), moved(high, 0.05 * size))
    }
}

/// Multiples of 1, 2 or 5 times a power of ten from `low` to `high`, at most about `most`.
fn steps(low: f64, high: f64, most: usize) -> Vec<f64> {
    let rough = (high - low) / most as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|&step| step >= rough * (1.0 - 1e-9));
    let Some(step) = step.filter(|&step| step > 0.0 && step.is_finite()) else { return Vec::new() };
    // Tolerance: a range that ends on a tick shows it, whatever the division's rounding.
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let count = (last - first).clamp(-1.0, most as f64) as i64;
    (0..=count).map(|index| (first + index as f64) * step).collect()
}

impl Ranged for Span {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            self.minor(hint.bold_points())
        } else {
            self.major(hint.max_num_points())
        }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Span {
    fn format_ext(&self, position: &f64) -> String {
        match self.scale {
            // What rounding leaves of zero is zero.
            Scale::Linear if position.abs() < 1e-9 * (self.high - self.low) => "0".into(),
            Scale::Linear => number(*position),
            Scale::Log => number(10f64.powf(*position)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(span: &Span, most: usize) -> Vec<String> {
        span.major(most).iter().map(|tick| span.format_ext(tick)).collect()
    }

    fn logarithmic(low: f64, high: f64) -> Span {
        Span { scale: Scale::Log, low: low.log10(), high: high.log10() }
    }

    #[test]
    fn numbers_are_short_and_right() {
        let cases: [(f64, &str); 9] = [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (65_536.0, "65536"),
            (1e6, "1e6"),
            (1_048_576.0, "1.048576e6"),
            (1e-4, "0.0001"),
            (2.5e-7, "2.5e-7"),
            (-12.50, "-12.5"),
            (1e300, "1e300"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(&Span::exact(0.0, 1.0), 5), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(labels(&Span::exact(-3.0, 7.0), 5), ["-2", "0", "2", "4", "6"]);
        assert_eq!(labels(&Span::exact(0.0, 4.0), 0), [""; 0]);
    }

    #[test]
    fn logarithmic_ticks_are_powers_or_their_parts() {
        assert_eq!(labels(&logarithmic(16.0, 70_000.0), 8), ["100", "1000", "10000"]);
        assert_eq!(labels(&logarithmic(1e-9, 1e9), 5).len(), 5);
        assert_eq!(labels(&logarithmic(0.9, 60.0), 8), ["1", "2", "5", "10", "20", "50"]);
        assert_eq!(labels(&logarithmic(1.05, 1.45), 6), ["1.1", "1.2", "1.3", "1.4"]);
        assert_eq!(logarithmic(1.0, 1e4).minor(8).len(), 32);
    }

    #[test]
    fn spans_hold_their_values() {
        for scale in [Scale::Linear, Scale::Log] {
            for values in [[3.0, 3.0], [1e-300, 1e90], [1.0, 1.000_001], [40.0, 50.0]] {
                let places = values.map(|v| position(scale, v).expect("a place"));
                let span = Span::around(scale, places.into_iter(), false);
                assert!(span.low < span.high && span.low <= places[0] && places[1] <= span.high, "{span:?}");
                assert!((1..=12).contains(&span.major(8).len()), "{span:?}: {:?}", span.major(8));
            }
        }
        assert_eq!(Span::around(Scale::Linear, [1.0, 4.0].into_iter(), false).low, 0.0);
        assert_eq!(Span::around(Scale::Linear, [-4.0, -3.0].into_iter(), true).high, 0.0);
        assert_eq!(Span::around(Scale::Log, [0.0, 2.0].into_iter(), true).low, -1.0);
    }

    #[test]
    fn values_without_a_place_are_told() {
        for value in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
            assert_eq!((position(Scale::Linear, value), position(Scale::Log, value)), (None, None));
        }
        assert_eq!(position(Scale::Log, 0.0), None);
        assert_eq!(position(Scale::Log, -1.0), None);
        assert_eq!(position(Scale::Linear, -1.0), Some(-1.0));
    }
}
