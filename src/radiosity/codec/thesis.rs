//! The codec of A. Shcherbakov's thesis (2017), and the same with its holes filled.
//!
//! In each channel the largest 4 % of all elements are kept apart, the rest is divided by its largest, and `ln + 25`, times 255 / 25, rounded and
//! clamped to 0..=255, is what BC1 blocks of four colours hold. Code 0, which zeros and everything under `exp(-25)` of the largest have, decodes to
//! exactly 0 here rather than to `exp(-25)`.
//!
//! `thesis` leaves code 0 where elements were taken out and adds those as they are, whatever the blocks decode to there. `thesis-filled` puts the mean
//! of the block's other codes there and keeps apart what is missing from what the block decodes to. Same bytes, a quarter of the error or less.
//!
//! In memory: [`Thesis::blocks`] as [`super::block`] says, `ceil(n / 4)` squared of them; [`Thesis::tables`], 256 f32 each for red, green and blue;
//! [`Thesis::apart`], one list a channel.

use rayon::prelude::*;

use super::block::{self, Block};
use super::fit::{self, Codes};
use super::logarithm::{Logarithm, Table};
use super::sparse::{self, Values};
use super::{Bytes, Coded};

/// Of all elements of a channel, how many are kept apart.
pub const SHARE: f64 = 0.04;

/// What blocks hold where elements were taken out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holes {
    /// Code 0: `thesis`.
    Zero,
    /// The mean of the block's other codes: `thesis-filled`.
    Filled,
}

/// An encoded operator.
#[derive(Debug, Clone, PartialEq)]
pub struct Thesis {
    /// Rows and columns.
    pub n: usize,
    /// BC1 blocks, row-major, all of four colours.
    pub blocks: Vec<Block>,
    /// f32 of each code by channel.
    pub tables: [Table; 3],
    /// What to add, by channel.
    pub apart: [Values; 3],
}

impl Thesis {
    /// From three row-major n x n matrices, red, green and blue.
    ///
    /// # Errors
    /// As [`super::check`].
    pub fn encode(n: usize, operator: &[Vec<f32>; 3], holes: Holes) -> Result<Self, String> {
        super::check(n, operator)?;
        let channels = [0, 1, 2].map(|c| Channel::new(n, &operator[c]));
        let side = block::side(n);
        let of = |number: usize| {
            let (codes, weights) = texels(n, &channels, holes, number / side, number % side);
            fit::four_color_block(&codes, &weights)
        };
        let blocks = (0..side * side).into_par_iter().map(of).collect();
        let tables = [0, 1, 2].map(|c| channels[c].logarithm.table());
        let mut encoded = Self { n, blocks, tables, apart: Default::default() };
        encoded.apart = [0, 1, 2].map(|c| {
            let missing = |at: usize| match holes {
                Holes::Zero => operator[c][at],
                Holes::Filled => {
                    operator[c][at] - encoded.texels(at / n / 4, at % n / 4)[at / n % 4 * 4 + at % n % 4][c]
                }
            };
            Values::new(n, channels[c].apart.iter().map(|at| (*at, missing(*at))))
        });
        Ok(encoded)
    }

    /// What the elements kept apart take in the form that the thesis gives them, (f32, u32) each.
    pub fn published_sparse_bytes(&self) -> usize {
        self.apart.iter().map(|values| 8 * values.values.len()).sum()
    }
}

impl Coded for Thesis {
    fn side(&self) -> usize {
        self.n
    }

    fn bytes(&self) -> Bytes {
        Bytes {
            blocks: 8 * self.blocks.len(),
            sparse: self.apart.iter().map(Values::bytes).sum(),
            tables: size_of_val(&self.tables),
        }
    }

    fn texels(&self, row: usize, column: usize) -> [[f32; 3]; 16] {
        let block = self.blocks.get(row * block::side(self.n) + column).copied().unwrap_or_default();
        let palette = block::bc1_palette(block).map(|code| [0, 1, 2].map(|c| self.tables[c][usize::from(code[c])]));
        std::array::from_fn(|texel| palette[block::bc1_index(block, texel)])
    }

    fn apart(&self, row: usize, add: &mut dyn FnMut(usize, usize, f32)) {
        for (channel, values) in self.apart.iter().enumerate() {
            values.row(row).for_each(|(column, value)| add(column, channel, value));
        }
    }
}

/// The 8-bit logarithms that the thesis orders rows by: n x n x 3 bytes, 0 where elements are taken out.
///
/// # Errors
/// As [`super::check`].
pub fn image(n: usize, operator: &[Vec<f32>; 3]) -> Result<Vec<u8>, String> {
    super::check(n, operator)?;
    let channels = [0, 1, 2].map(|c| Channel::new(n, &operator[c]));
    Ok((0..n * n).flat_map(|at| [0, 1, 2].map(|c| channels[c].codes[at])).collect())
}

/// One channel after the largest were taken out.
struct Channel {
    /// Element numbers, ascending.
    apart: Vec<usize>,
    logarithm: Logarithm,
    /// 0 where taken out.
    codes: Vec<u8>,
    /// Bit `at % 8` of byte `at / 8`: element `at` was taken out.
    taken: Vec<u8>,
}

impl Channel {
    fn new(n: usize, values: &[f32]) -> Self {
        let apart = sparse::largest(values, sparse::share(n, SHARE));
        let mut taken = vec![0u8; values.len().div_ceil(8)];
        apart.iter().for_each(|at| taken[at / 8] |= 1 << (at % 8));
        let is_taken = |at: usize| taken[at / 8] >> (at % 8) & 1 != 0;
        let left = |(at, value): (usize, &f32)| if is_taken(at) { 0.0 } else { *value };
        let top = values.par_iter().enumerate().map(left).reduce(|| 0.0, f32::max);
        let logarithm = Logarithm::thesis(f64::from(top));
        let code = |pair| logarithm.code(f64::from(left(pair)));
        let codes = values.par_iter().enumerate().map(code).collect();
        Self { apart, logarithm, codes, taken }
    }

    fn is_taken(&self, at: usize) -> bool {
        self.taken[at / 8] >> (at % 8) & 1 != 0
    }
}

/// Codes of a block and how much each counts: not at all beyond the matrix.
fn texels(n: usize, channels: &[Channel; 3], holes: Holes, row: usize, column: usize) -> (Codes, fit::Weights) {
    let at = |texel: usize| {
        let (y, x) = (4 * row + texel / 4, 4 * column + texel % 4);
        (y < n && x < n).then_some(y * n + x)
    };
    let mut codes = [[0.0f32; 3]; 16];
    for (c, channel) in channels.iter().enumerate() {
        let (mut sum, mut count) = (0.0f32, 0.0f32);
        for (texel, at) in (0..16).filter_map(|texel| at(texel).map(|at| (texel, at))) {
            codes[texel][c] = channel.codes[at].into();
            if !channel.is_taken(at) {
                sum += codes[texel][c];
                count += 1.0;
            }
        }
        if holes == Holes::Filled {
            // Elements taken out are larger than all others, so where there are no others the largest code is closest.
            let fill = if count > 0.0 { sum / count } else { 255.0 };
            (0..16)
                .filter(|texel| at(*texel).is_some_and(|at| channel.is_taken(at)))
                .for_each(|texel| codes[texel][c] = fill);
        }
    }
    (codes, std::array::from_fn(|texel| if at(texel).is_some() { 1.0 } else { 0.0 }))
}

#[cfg(test)]
mod tests;
