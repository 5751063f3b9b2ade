//! Ends of BC1 blocks of logarithmic codes, so that the sum of squares of what they decode *to* is least.
//!
//! A fit in codes treats a wrong code alike wherever it is; what it costs is proportional to the value. So the fit in codes, weighted by squares of
//! values, is only where a descent starts: one end's component after another, alone and together with others, is moved by a few steps, each texel takes
//! whichever palette entry is closest, and what is closer is kept until nothing is.

use super::block::{self, Block, End, Palette};
use super::fit;
use super::logarithm::{Logarithm, Table};
use super::residual::Texels;

/// Rounds of moves; most blocks come to rest in three or four.
const ROUNDS: u32 = 12;

/// Largest values of the components of an end.
const LAST: End = [31, 63, 31];

/// Moves of both ends' components.
type Move = [[i8; 3]; 2];

/// Scales of the three channels.
#[derive(Debug, Clone)]
pub struct Fitter {
    logarithms: [Logarithm; 3],
    tables: [Table; 3],
    /// Divides values, so that squares keep away from the ends of f32.
    unit: f32,
    moves: Vec<Move>,
}

/// One block's texels that count.
struct Target {
    /// In units of the fitter.
    values: Vec<[f32; 3]>,
    /// Lowest component of an end: 1 where the channel has no zero in the block, so that none decodes to 0.
    lowest: End,
    /// Three colours, the fourth entry being for zeros alone.
    three: bool,
}

impl Fitter {
    /// For channels of such scales.
    pub fn new(logarithms: [Logarithm; 3]) -> Self {
        let unit = logarithms.iter().map(|logarithm| logarithm.top as f32).fold(f32::MIN_POSITIVE, f32::max);
        let tables = logarithms.map(|logarithm| logarithm.table().map(|x| x / unit));
        Self { logarithms, tables, unit, moves: moves() }
    }

    /// A texel that is stored as exactly 0 in all channels.
    pub fn is_zero(&self, value: &[f32; 3]) -> bool {
        value.iter().zip(&self.logarithms).all(|(x, logarithm)| logarithm.is_zero(*x))
    }

    /// The block of these texels; `None` where all of them are zeros or free. Zeros decode to exactly 0, by the fourth entry of three colours, and no
    /// other texel has that entry.
    pub fn fit(&self, texels: &Texels) -> Option<Block> {
        let zero = texels.values.map(|value| self.is_zero(&value));
        let counts: Vec<usize> = (0..16).filter(|t| texels.free >> t & 1 == 0 && !zero[*t]).collect();
        if counts.is_empty() && (0..16).all(|t| zero[t]) {
            return None;
        }
        // Where all that is not zero is kept apart, the fit may as well be to that.
        let counts = if counts.is_empty() { (0..16).filter(|t| !zero[*t]).collect() } else { counts };
        let beyond = |t: usize| texels.free >> t & 1 != 0 && zero[t];
        let three = (0..16).any(|t| zero[t] && !beyond(t));
        let values: Vec<[f32; 3]> = counts.iter().map(|t| texels.values[*t].map(|x| x / self.unit)).collect();
        let has_zero = |c: usize| counts.iter().any(|t| self.logarithms[c].is_zero(texels.values[*t][c]));
        let target = Target { values, lowest: [0, 1, 2].map(|c| u8::from(!has_zero(c))), three };
        let ends = self.descend(&target, self.starts(texels, &counts));
        Some(self.stored(ends, &target, texels, &zero))
    }

    /// Ends by fits in codes.
    fn starts(&self, texels: &Texels, counts: &[usize]) -> [[End; 2]; 3] {
        let mut codes = [[0.0f32; 3]; 16];
        let (mut alike, mut weights) = ([0.0f32; 16], [0.0f32; 16]);
        for texel in counts.iter().copied() {
            let value = texels.values[texel];
            codes[texel] = [0, 1, 2].map(|c| self.logarithms[c].real_code(value[c].into()));
            alike[texel] = 1.0;
            weights[texel] = value.iter().map(|x| (x / self.unit).powi(2)).sum();
        }
        let most = weights.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        weights.iter_mut().zip(alike).for_each(|(weight, alike)| *weight = (*weight / most).max(1e-4) * alike);
        let fitted = |weights: &fit::Weights| {
            let block = fit::four_color_block(&codes, weights);
            [block[0] & 0xffff, block[0] >> 16].map(|bits| block::unpack_end(bits as u16))
        };
        let corner = |pick: fn(f32, f32) -> f32, from: f32| {
            let of = |c: usize| counts.iter().map(|t| codes[*t][c]).fold(from, pick);
            block::nearest_end([of(0), of(1), of(2)])
        };
        [fitted(&weights), fitted(&alike), [corner(f32::max, 0.0), corner(f32::min, 255.0)]]
    }

    /// From the best start to where no move is better. Descents from all of them gain under 1 % of the error at three times the time.
    fn descend(&self, target: &Target, starts: [[End; 2]; 3]) -> [End; 2] {
        let lifted = |start: [End; 2]| start.map(|end| [0, 1, 2].map(|c| end[c].max(target.lowest[c])));
        let [first, second, third] = starts.map(lifted).map(|ends| (self.error(target, &ends), ends));
        let mut best = [second, third].into_iter().fold(first, |best, next| if next.0 < best.0 { next } else { best });
        for _ in 0..ROUNDS {
            let before = best.0;
            for step in &self.moves {
                let Some(ends) = moved(&best.1, step, &target.lowest) else { continue };
                let error = self.error(target, &ends);
                if error < best.0 {
                    best = (error, ends);
                }
            }
            if best.0 == before {
                break;
            }
        }
        best.1
    }

    /// What the entries of a palette decode to, in units of the fitter.
    fn decoded(&self, palette: &Palette) -> [[f32; 3]; 4] {
        palette.map(|codes| [0, 1, 2].map(|c| self.tables[c][usize::from(codes[c])]))
    }

    /// Sum of squares of what the texels that count miss.
    fn error(&self, target: &Target, ends: &[End; 2]) -> f32 {
        let palette = if target.three { block::three_colors(*ends) } else { block::four_colors(*ends) };
        let decoded = self.decoded(&palette);
        let least = |value: &[f32; 3]| {
            let last = if target.three { f32::INFINITY } else { squared(&decoded[3], value) };
            (0..3).fold(last, |least, k| least.min(squared(&decoded[k], value)))
        };
        target.values.iter().map(least).sum()
    }

    /// The block as stored: ends in the order of its mode, then the closest entry for every texel.
    fn stored(&self, ends: [End; 2], target: &Target, texels: &Texels, zero: &[bool; 16]) -> Block {
        let [a, b] = ends.map(block::pack_end);
        let swapped = [ends[1], ends[0]];
        // Ends that are the same read as three colours whatever is meant: the fourth entry is not used then, and the first three are that colour.
        let four = !target.three && a != b;
        let ends = if (a > b) == four { ends } else { swapped };
        let palette = if four { block::four_colors(ends) } else { block::three_colors(ends) };
        let decoded = self.decoded(&palette);
        let indices = std::array::from_fn(|t| {
            if zero[t] {
                return 3;
            }
            let value = texels.values[t].map(|x| x / self.unit);
            let entries = if four { 4 } else { 3 };
            (0..entries)
                .min_by(|i, j| squared(&decoded[*i], &value).total_cmp(&squared(&decoded[*j], &value)))
                .unwrap_or(0) as u8
        });
        block::bc1(ends, &indices)
    }
}

fn squared(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    let off = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    off[0] * off[0] + off[1] * off[1] + off[2] * off[2]
}

/// Every move: one component, one end, both ends to the same or to opposite sides.
fn moves() -> Vec<Move> {
    let mut moves = Vec::new();
    for by in [1i8, -1, 2, -2, 4, -4] {
        let all = [by, by * 2, by];
        moves.extend([[all, [0; 3]], [[0; 3], all], [all, all], [all, all.map(|x| -x)]]);
    }
    for by in [1i8, -1, 2, -2, 3, -3] {
        for c in 0..3 {
            let mut one = [0; 3];
            one[c] = by;
            moves.extend([[one, [0; 3]], [[0; 3], one], [one, one], [one, one.map(|x| -x)]]);
        }
    }
    moves
}

/// `None` where a move leads nowhere.
fn moved(ends: &[End; 2], step: &Move, lowest: &End) -> Option<[End; 2]> {
    let of = |e: usize, c: usize| {
        (i32::from(ends[e][c]) + i32::from(step[e][c])).clamp(lowest[c].into(), LAST[c].into()) as u8
    };
    let moved = [0, 1].map(|e| [0, 1, 2].map(|c| of(e, c)));
    (moved != *ends).then_some(moved)
}
