//! Blocks and elements kept apart, chosen by what the blocks get wrong.

use rayon::prelude::*;

use super::block;
use super::sparse::{self, Residuals};

/// Of all elements, how many are kept apart.
pub const SHARE: f64 = 0.02;

/// An operator in blocks: elements and what is known of them before any block is made.
pub struct Source<'a> {
    /// Rows and columns.
    pub n: usize,
    /// Three n x n matrices.
    pub operator: &'a [Vec<f32>; 3],
}

/// The elements of a block.
#[derive(Clone, Copy)]
pub struct Texels {
    /// By texel; 0 beyond the matrix.
    pub values: [[f32; 3]; 16],
    /// Bit t: texel t may decode to anything that is not 0, as it lies beyond the matrix or is kept apart.
    pub free: u16,
}

impl Source<'_> {
    /// Of a block by number.
    pub fn texels(&self, number: usize) -> Texels {
        let side = block::side(self.n);
        let (row, column) = (4 * (number / side), 4 * (number % side));
        let mut texels = Texels { values: [[0.0; 3]; 16], free: 0 };
        for texel in 0..16 {
            let (y, x) = (row + texel / 4, column + texel % 4);
            if y < self.n && x < self.n {
                texels.values[texel] = [0, 1, 2].map(|c| self.operator[c][y * self.n + x]);
            } else {
                texels.free |= 1 << texel;
            }
        }
        texels
    }

    /// Makes all blocks, keeps apart the [`SHARE`] of elements that they miss by most (root of the sum of squares over channels), and makes the blocks
    /// in which such lie again, as those elements may now be anything there. `fit` makes a block, `decode` tells what it decodes to.
    pub fn keep_apart<B: Copy + Send + Sync>(
        &self,
        fit: impl Fn(&Texels) -> B + Sync,
        decode: impl Fn(&B) -> [[f32; 3]; 16] + Sync,
    ) -> (Vec<B>, Residuals) {
        let (n, side) = (self.n, block::side(self.n));
        let mut blocks: Vec<B> = (0..side * side).into_par_iter().map(|number| fit(&self.texels(number))).collect();
        let place = |at: usize| (at / n / 4 * side + at % n / 4, at / n % 4 * 4 + at % n % 4);
        let missing = |decoded: &[[f32; 3]; 16], at: usize| -> [f32; 3] {
            let texel = decoded[place(at).1];
            [0, 1, 2].map(|c| self.operator[c][at] - texel[c])
        };
        let mut misses = vec![0.0f32; n * n];
        misses.par_chunks_mut((4 * n).max(1)).enumerate().for_each(|(row, misses)| {
            let decoded: Vec<_> = blocks[row * side..(row + 1) * side].iter().map(&decode).collect();
            for (offset, miss) in misses.iter_mut().enumerate() {
                let squares = missing(&decoded[offset % n / 4], row * 4 * n + offset).map(|x| f64::from(x).powi(2));
                *miss = squares.iter().sum::<f64>().sqrt() as f32;
            }
        });
        let apart = sparse::largest(&misses, sparse::share(n, SHARE));
        drop(misses);
        let mut free: Vec<(usize, u16)> = apart.iter().map(|at| place(*at)).map(|(b, texel)| (b, 1 << texel)).collect();
        free.sort_unstable();
        free.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 |= if same { next.1 } else { 0 };
            same
        });
        let again = |&(number, free): &(usize, u16)| {
            let mut texels = self.texels(number);
            texels.free |= free;
            (number, fit(&texels))
        };
        let made: Vec<(usize, B)> = free.par_iter().map(again).collect();
        made.into_iter().for_each(|(number, block)| blocks[number] = block);
        let values: Vec<(usize, [f32; 3])> =
            apart.iter().map(|at| (*at, missing(&decode(&blocks[place(*at).0]), *at))).collect();
        (blocks, Residuals::new(n, &values))
    }
}
