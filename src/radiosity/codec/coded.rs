//! Codecs of a coloured operator: three n x n matrices of couplings in a byte or less an element, decoded alike on the CPU and in compute shaders.
//!
//! Every codec here has 4 x 4 blocks of 8-bit logarithmic codes ([`block`]), tables that turn codes into f32 ([`super::logarithm`]) and a few elements apart
//! ([`sparse`]) that are added. Tables are computed once in f64 and rounded, so that whoever reads them gets the same bits.
//!
//! A product is a fixed sum in f32, nothing fused, as threads for four rows add it: thread k of `lanes` takes what blocks k, k + lanes and so on decode
//! to, then elements k, k + lanes and so on of what is kept apart, columns ascending; then the sums of threads are added up ([`tree_sum`]).

use rayon::prelude::*;

use super::{block, sparse, tree_sum};

/// What an encoded operator takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bytes {
    /// Blocks, with what tells which of them are stored.
    pub blocks: usize,
    /// Elements kept apart.
    pub sparse: usize,
    /// Tables and scales, the same size for every operator.
    pub tables: usize,
}

impl Bytes {
    /// All of it.
    pub fn total(self) -> usize {
        self.blocks + self.sparse + self.tables
    }
}

/// An encoded operator.
pub trait Coded: Sync {
    /// Rows and columns.
    fn side(&self) -> usize;

    /// What it takes.
    fn bytes(&self) -> Bytes;

    /// The 16 elements of the block in such a row and column of blocks, both under [`block::side`], without what is kept apart. What lies beyond the
    /// matrix has any value; blocks that the lists lack are 0.
    fn texels(&self, row: usize, column: usize) -> [[f32; 3]; 16];

    /// Calls `add` with column, channel and value of everything kept apart in a row, columns ascending in each channel.
    fn apart(&self, row: usize, add: &mut dyn FnMut(usize, usize, f32));

    /// Row `row`: n elements, or none where there is no such row.
    fn decode_row(&self, row: usize) -> Vec<[f32; 3]> {
        let n = self.side();
        if row >= n {
            return Vec::new();
        }
        let mut decoded: Vec<[f32; 3]> = (0..block::side(n))
            .flat_map(|column| {
                let texels = self.texels(row / 4, column);
                (0..4).map(move |x| texels[row % 4 * 4 + x])
            })
            .take(n)
            .collect();
        self.apart(row, &mut |column, channel, value| {
            if let Some(element) = decoded.get_mut(column) {
                element[channel] += value;
            }
        });
        decoded
    }

    /// One element; 0 outside of the matrix.
    fn decode_element(&self, row: usize, column: usize) -> [f32; 3] {
        if row.max(column) >= self.side() {
            return [0.0; 3];
        }
        let mut element = self.texels(row / 4, column / 4)[row % 4 * 4 + column % 4];
        self.apart(row, &mut |at, channel, value| {
            if at == column {
                element[channel] += value;
            }
        });
        element
    }

    /// Operator times vector, in the order of the module's head. What `x` lacks is 0, what it has beyond n is left out.
    fn product(&self, x: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        let n = self.side();
        let of = |row: usize| -> Vec<[f32; 3]> {
            let mut sums = vec![[0f32; 12]; lanes];
            for column in 0..block::side(n) {
                let sum = &mut sums[column % lanes];
                for (t, element) in self.texels(row, column).iter().enumerate() {
                    let at = 4 * column + t % 4;
                    let light = if at < n { x.get(at).copied().unwrap_or_default() } else { [0.0; 3] };
                    (0..3).for_each(|c| sum[t / 4 * 3 + c] += element[c] * light[c]);
                }
            }
            let rows = (n - 4 * row).min(4);
            for down in 0..rows {
                let mut turns = [0; 3];
                self.apart(4 * row + down, &mut |column, c, value| {
                    sums[turns[c] % lanes][down * 3 + c] += value * x.get(column).map_or(0.0, |light| light[c]);
                    turns[c] += 1;
                });
            }
            tree_sum(sums).chunks_exact(3).take(rows).map(|e| [e[0], e[1], e[2]]).collect()
        };
        (0..block::side(n)).into_par_iter().flat_map_iter(of).collect()
    }
}

/// Whether three channels are n x n matrices of couplings that the codecs here can hold.
///
/// # Errors
/// Another number of elements, more rows than 16-bit columns reach, or an element that is negative, infinite or not a number.
pub fn check(n: usize, operator: &[Vec<f32>; 3]) -> Result<(), String> {
    if n > sparse::MOST {
        return Err(format!("{n} rows: columns kept apart have 16 bits, which is {} at most", sparse::MOST));
    }
    for (channel, values) in operator.iter().enumerate() {
        if values.len() != n * n {
            return Err(format!("channel {channel} has {} elements, {n} rows need {}", values.len(), n * n));
        }
        if let Some(at) = values.par_iter().position_first(|x| !x.is_finite() || *x < 0.0) {
            return Err(format!("channel {channel}, row {}, column {}: {} is no coupling", at / n, at % n, values[at]));
        }
    }
    Ok(())
}
