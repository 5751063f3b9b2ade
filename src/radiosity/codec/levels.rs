//! Ends of BC4 blocks of logarithmic codes, so that the sum of squares of what they decode *to* is least: descent as in [`super::linear`].

use super::block::{self, Block};
use super::logarithm::{Logarithm, Table};

/// Rounds of moves.
const ROUNDS: u32 = 12;
/// Steps of an end.
const STEPS: [i32; 10] = [16, -16, 8, -8, 4, -4, 2, -2, 1, -1];

/// What a texel of a block is to become.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texel {
    /// As close to this as can be, and not 0.
    Value(f32),
    /// Not 0, and how far off is no matter, but close is better.
    Free(f32),
    /// Exactly 0.
    Zero,
    /// Anything.
    Beyond,
}

/// Scale of the levels, and how far apart they are.
#[derive(Debug, Clone)]
pub struct Fitter {
    logarithm: Logarithm,
    table: Table,
    unit: f32,
}

impl Fitter {
    /// For values of such a scale.
    pub fn new(logarithm: Logarithm) -> Self {
        let unit = (logarithm.top as f32).max(f32::MIN_POSITIVE);
        Self { logarithm, table: logarithm.table().map(|x| x / unit), unit }
    }

    /// The block. Its ends are in the order that gives eight levels between them, or, where a texel is to be 0, four and 0 and 255.
    pub fn fit(&self, texels: &[Texel; 16]) -> Block {
        let mut values: Vec<f32> = texels
            .iter()
            .filter_map(|texel| if let Texel::Value(x) = texel { Some(x / self.unit) } else { None })
            .collect();
        if values.is_empty() {
            values = texels
                .iter()
                .filter_map(|texel| if let Texel::Free(x) = texel { Some(x / self.unit) } else { None })
                .collect();
        }
        let six = texels.contains(&Texel::Zero);
        let ends = self.descend(&values, six);
        let levels = block::bc4_levels(ends);
        let eight = ends[0] > ends[1];
        let indices = texels.map(|texel| match texel {
            Texel::Zero => 6,
            Texel::Beyond => 0,
            Texel::Value(x) | Texel::Free(x) => {
                let off = |index: &usize| (self.table[usize::from(levels[*index])] - x / self.unit).abs();
                let all = (0..8usize).filter(|index| eight || *index != 6);
                all.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0) as u8
            }
        });
        block::bc4(ends, &indices)
    }

    /// Ends as stored.
    fn descend(&self, values: &[f32], six: bool) -> [u8; 2] {
        // Ascending for six levels, descending for eight.
        let ordered = |[a, b]: [u8; 2]| if six == (a <= b) { [a, b] } else { [b, a] };
        let code = |x: f32| self.logarithm.code(f64::from(x) * f64::from(self.unit)).max(1);
        let most = code(values.iter().copied().fold(0.0, f32::max));
        let least = code(values.iter().copied().fold(f32::INFINITY, f32::min).min(f32::MAX));
        let mean = code(values.iter().sum::<f32>() / values.len().max(1) as f32);
        let mut best = (f32::INFINITY, [most, least]);
        for low in [least, (least / 2 + mean / 2).max(1), mean] {
            let ends = ordered([most, low]);
            let error = self.error(values, ends);
            if error < best.0 {
                best = (error, ends);
            }
        }
        for _ in 0..ROUNDS {
            let before = best.0;
            for step in STEPS {
                for [a, b] in [[step, 0], [0, step], [step, step], [step, -step]] {
                    let moved = |end: u8, by: i32| (i32::from(end) + by).clamp(1, 255) as u8;
                    let ends = ordered([moved(best.1[0], a), moved(best.1[1], b)]);
                    let error = if ends == best.1 { f32::INFINITY } else { self.error(values, ends) };
                    if error < best.0 {
                        best = (error, ends);
                    }
                }
            }
            if best.0 == before {
                break;
            }
        }
        ordered(best.1)
    }

    fn error(&self, values: &[f32], ends: [u8; 2]) -> f32 {
        let levels = block::bc4_levels(ends);
        let mut decoded = levels.map(|code| self.table[usize::from(code)]);
        if ends[0] <= ends[1] {
            decoded[6] = decoded[0];
        }
        let least = |x: &f32| decoded.iter().fold(f32::INFINITY, |least, level| least.min((level - x) * (level - x)));
        values.iter().map(least).sum()
    }
}
