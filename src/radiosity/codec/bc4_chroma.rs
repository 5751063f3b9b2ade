//! `bc4-chroma`: luminance `(R + G + B) / 3` as logarithmic codes in BC4 blocks, two bytes of chroma a block, and the 2 % of the elements that this
//! misses by most, with what is missing.
//!
//! An element is its luminance times the block's ratios `(r, g, b)`: r and b from tables of 256 f32 by a byte each, `g = max((3 - r) - b, 0)` in f32,
//! one subtraction after the other. Luminance comes from a third table by the code of the texel, 4 to 12 nats wide; code 0 is exactly 0.
//! Elements that are 0, or closer to it than to code 1, decode to exactly 0: by index 6 of blocks of six levels, which nothing else has. Other blocks
//! have eight levels; one whose ends are the same reads as six, without index 6. Blocks of nothing but zeros are not stored.
//!
//! In memory: [`Bc4Chroma::stored`] tells for block `b = row * side + column` of [`block::side`] squared ones where in [`Bc4Chroma::blocks`] and
//! [`Bc4Chroma::chroma`] it is (red in the low byte, blue in the high one; two blocks a word); [`Bc4Chroma::apart`] is added.

use rayon::prelude::*;

use super::block::{self, Block};
use super::levels::{Fitter, Texel};
use super::logarithm::{Logarithm, Table};
use super::residual::{SHARE, Source, Texels};
use super::skip::Stored;
use super::sparse::{self, Residuals};
use super::{Bytes, Coded};

/// Luminance and chroma take turns.
const ROUNDS: u32 = 3;
/// Of the sum of squares of luminances, how much may have ratios beyond either end of the tables.
const OUTSIDE: f64 = 5e-4;

/// An encoded operator.
#[derive(Debug, Clone, PartialEq)]
pub struct Bc4Chroma {
    /// Rows and columns.
    pub n: usize,
    /// Which blocks are stored.
    pub stored: Stored,
    /// BC4 blocks of luminance that are.
    pub blocks: Vec<Block>,
    /// As many: code of red over luminance, and in the high byte that of blue.
    pub chroma: Vec<u16>,
    /// Tables of codes.
    pub tables: Tables,
    /// What to add.
    pub apart: Residuals,
}

/// What codes stand for; in memory in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables {
    /// Luminance by texel.
    pub luminance: Table,
    /// Red over luminance, ascending in equal steps.
    pub red: Table,
    /// Blue over luminance, ascending in equal steps.
    pub blue: Table,
}

impl Tables {
    /// Ratios of a block; their sum is 3 but for rounding, or more where green would be negative.
    pub fn ratios(&self, chroma: u16) -> [f32; 3] {
        let (r, b) = (self.red[usize::from(chroma & 255)], self.blue[usize::from(chroma >> 8)]);
        [r, (3.0 - r - b).max(0.0), b]
    }

    fn decode(&self, (block, chroma): (Block, u16)) -> [[f32; 3]; 16] {
        let ratios = self.ratios(chroma);
        block::bc4_texels(block).map(|code| ratios.map(|ratio| self.luminance[usize::from(code)] * ratio))
    }
}

impl Bc4Chroma {
    /// From three row-major n x n matrices, red, green and blue.
    ///
    /// # Errors
    /// As [`super::check`].
    pub fn encode(n: usize, operator: &[Vec<f32>; 3]) -> Result<Self, String> {
        super::check(n, operator)?;
        let source = Source { n, operator };
        let luminances: Vec<f32> =
            (0..n * n).into_par_iter().map(|at| luminance(&[0, 1, 2].map(|c| operator[c][at]))).collect();
        let logarithm = Logarithm::of(&luminances, sparse::share(n, SHARE * super::bc1::BEYOND));
        drop(luminances);
        let [red, blue] = ratio_tables(&source);
        let tables = Tables { luminance: logarithm.table(), red, blue };
        let fitter = ChromaFitter { logarithm, fitter: Fitter::new(logarithm), tables: &tables };
        let (blocks, apart) = source.keep_apart(
            |texels| fitter.fit(texels),
            |block| block.map_or([[0.0; 3]; 16], |block| tables.decode(block)),
        );
        let stored = Stored::new(blocks.iter().map(Option::is_some));
        let (blocks, chroma) = blocks.into_iter().flatten().unzip();
        Ok(Self { n, stored, blocks, chroma, tables, apart })
    }
}

impl Coded for Bc4Chroma {
    fn side(&self) -> usize {
        self.n
    }

    fn bytes(&self) -> Bytes {
        Bytes {
            blocks: 8 * self.blocks.len() + 2 * self.chroma.len() + self.stored.bytes(),
            sparse: self.apart.bytes(),
            tables: size_of_val(&self.tables),
        }
    }

    fn texels(&self, row: usize, column: usize) -> [[f32; 3]; 16] {
        let number = self.stored.find(row * block::side(self.n) + column);
        let block = number.and_then(|number| self.blocks.get(number).zip(self.chroma.get(number)));
        block.map_or([[0.0; 3]; 16], |(block, chroma)| self.tables.decode((*block, *chroma)))
    }

    fn apart(&self, row: usize, add: &mut dyn FnMut(usize, usize, f32)) {
        for (column, value) in self.apart.row(row) {
            (0..3).for_each(|c| add(column, c, value[c]));
        }
    }
}

/// The mean of the channels.
fn luminance(value: &[f32; 3]) -> f32 {
    value.iter().map(|x| x / 3.0).sum()
}

/// Ratios of red and blue that fit a block best when its texels have such luminances, and the sum of squares of those; `None` of a dark block.
///
/// Least squares of `r L = R`, `(3 - r - b) L = G`, `b L = B`: with sums `S = L L` and `p, q, s = L R, L G, L B` over texels
/// `2 r + b = 3 + (p - q) / S` and `r + 2 b = 3 + (s - q) / S`.
fn ratios<'a>(texels: impl Iterator<Item = (f32, &'a [f32; 3])>) -> Option<([f64; 2], f64)> {
    let (mut squares, mut sums) = (0.0f64, [0.0f64; 3]);
    for (luminance, value) in texels {
        squares += f64::from(luminance).powi(2);
        (0..3).for_each(|c| sums[c] += f64::from(luminance) * f64::from(value[c]));
    }
    if squares <= 0.0 {
        return None;
    }
    let [first, second] = [sums[0], sums[2]].map(|sum| 3.0 + (sum - sums[1]) / squares);
    Some(([(2.0 * first - second) / 3.0, (2.0 * second - first) / 3.0], squares))
}

/// Tables from the smallest to the largest ratio that blocks ask for, but for [`OUTSIDE`] of them.
fn ratio_tables(source: &Source) -> [Table; 2] {
    let side = block::side(source.n);
    let of = |number: usize| {
        let texels = source.texels(number);
        ratios(texels.values.iter().map(|value| (luminance(value), value)))
    };
    let mut found: Vec<([f64; 2], f64)> = (0..side * side).into_par_iter().filter_map(of).collect();
    let all: f64 = found.iter().map(|(_, squares)| squares).sum();
    [0, 1].map(|k| {
        found.sort_by(|a, b| a.0[k].total_cmp(&b.0[k]));
        let end = |mut blocks: Box<dyn Iterator<Item = &([f64; 2], f64)> + '_>| {
            let mut sum = 0.0;
            let passes = |(_, squares): &&([f64; 2], f64)| {
                sum += squares;
                sum > OUTSIDE * all
            };
            blocks.find(passes).map_or(1.0, |(ratios, _)| ratios[k].clamp(0.0, 3.0))
        };
        let (low, high) = (end(Box::new(found.iter())), end(Box::new(found.iter().rev())));
        // Grey operators have ratios of exactly 1, which rounding of the sums is not to spoil.
        let [low, high] = if high - low < 1e-6 { [(low * 1e6).round() / 1e6; 2] } else { [low, high] };
        std::array::from_fn(|code| (low + (high - low) * code as f64 / 255.0) as f32)
    })
}

/// What blocks are made with.
struct ChromaFitter<'a> {
    logarithm: Logarithm,
    fitter: Fitter,
    tables: &'a Tables,
}

impl ChromaFitter<'_> {
    /// `None` where all texels are zeros.
    fn fit(&self, texels: &Texels) -> Option<(Block, u16)> {
        let zero = texels.values.map(|value| self.logarithm.is_zero(luminance(&value)));
        if zero.iter().all(|zero| *zero) {
            return None;
        }
        let any = (0..16).any(|t| texels.free >> t & 1 == 0 && !zero[t]);
        // Where all that is not zero is kept apart, the fit may as well be to that.
        let counts = |t: usize| !zero[t] && (texels.free >> t & 1 == 0 || !any);
        let seen = || (0..16).filter(|t| counts(*t)).map(|t| &texels.values[t]);
        let (found, _) = ratios(seen().map(|value| (luminance(value), value)))?;
        let mut chroma = self.nearest(found);
        let mut best: Option<(f64, Block, u16)> = None;
        for _ in 0..ROUNDS {
            let block = self.fitter.fit(&self.targets(texels, &zero, chroma));
            let codes = block::bc4_texels(block);
            let level = |t: usize| self.tables.luminance[usize::from(codes[t])];
            let decoded = || (0..16).filter(|t| counts(*t)).map(|t| (level(t), &texels.values[t]));
            let (found, _) = ratios(decoded())?;
            let error = |chroma: u16| {
                let ratios = self.tables.ratios(chroma);
                let miss = |(level, value): (f32, &[f32; 3])| -> f64 {
                    (0..3).map(|c| f64::from(level * ratios[c] - value[c]).powi(2)).sum()
                };
                decoded().map(miss).sum::<f64>()
            };
            chroma = self
                .around(found)
                .map(|chroma| (error(chroma), chroma))
                .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
                .1;
            let error = error(chroma);
            if best.is_some_and(|best| error >= best.0) {
                break;
            }
            best = Some((error, block, chroma));
        }
        best.map(|(_, block, chroma)| (block, chroma))
    }

    /// Luminances that come closest with such ratios.
    fn targets(&self, texels: &Texels, zero: &[bool; 16], chroma: u16) -> [Texel; 16] {
        let ratios = self.tables.ratios(chroma);
        let squares: f32 = ratios.iter().map(|x| x * x).sum();
        std::array::from_fn(|t| {
            let free = texels.free >> t & 1 != 0;
            let target = texels.values[t].iter().zip(ratios).map(|(x, ratio)| x * (ratio / squares)).sum();
            match (zero[t], free) {
                (true, true) => Texel::Beyond,
                (true, false) => Texel::Zero,
                (false, true) => Texel::Free(target),
                (false, false) => Texel::Value(target),
            }
        })
    }

    /// Codes of the ratios closest to these.
    fn nearest(&self, ratios: [f64; 2]) -> u16 {
        let code = |table: &Table, ratio: f64| {
            let (low, high) = (f64::from(table[0]), f64::from(table[255]));
            if high > low { ((ratio - low) / (high - low) * 255.0).round().clamp(0.0, 255.0) as u16 } else { 0 }
        };
        code(&self.tables.red, ratios[0]) | code(&self.tables.blue, ratios[1]) << 8
    }

    /// Those and their neighbours.
    fn around(&self, ratios: [f64; 2]) -> impl Iterator<Item = u16> {
        let chroma = self.nearest(ratios);
        let near = |code: u16| [code, code.saturating_sub(1), (code + 1).min(255)];
        near(chroma & 255).into_iter().flat_map(move |red| near(chroma >> 8).map(|blue| red | blue << 8))
    }
}

#[cfg(test)]
mod tests;
