//! Every element of a coloured operator in 16 bits and three channels: bounces summed beforehand, with nothing else lost.

use exr::prelude::f16;
use rayon::prelude::*;

use super::{Bytes, Coded};

/// Largest element after scaling: f16 has its full precision down to 2^-14.
const TOP: f32 = 16384.0;

/// An encoded operator.
#[derive(Debug, Clone, PartialEq)]
pub struct Half {
    /// Rows and columns.
    pub n: usize,
    /// By channel, rows of [`Half::row_words`] words with two f16 each, the lower column in the lower half.
    pub words: Vec<u32>,
    /// A power of two; what every f16 is multiplied by.
    pub scale: f32,
}

impl Half {
    /// From three row-major n x n matrices, red, green and blue.
    ///
    /// # Errors
    /// As [`super::check`].
    pub fn encode(n: usize, operator: &[Vec<f32>; 3]) -> Result<Self, String> {
        super::check(n, operator)?;
        let largest = operator.iter().flatten().copied().fold(0f32, f32::max);
        let scale = if largest > 0.0 { (largest / TOP).log2().ceil().exp2().max(f32::MIN_POSITIVE) } else { 1.0 };
        let half = |x: &f32| u32::from(f16::from_f32(x / scale).to_bits());
        let pair = |two: &[f32]| half(&two[0]) | two.get(1).map_or(0, half) << 16;
        let words =
            operator.iter().flat_map(|of| of.chunks(n.max(1)).flat_map(|row| row.chunks(2).map(pair))).collect();
        Ok(Self { n, words, scale })
    }

    /// Words of a row of one channel.
    pub fn row_words(&self) -> usize {
        self.n.div_ceil(2)
    }

    /// Bits of every f16, channel by channel and row by row.
    pub fn halves(&self) -> impl Iterator<Item = u16> + '_ {
        self.words
            .chunks(self.row_words().max(1))
            .flat_map(|row| row.iter().flat_map(|word| [*word as u16, (word >> 16) as u16]).take(self.n))
    }

    /// The way back from [`Half::halves`].
    pub fn of_halves(n: usize, halves: &[u16], scale: f32) -> Self {
        let pair = |two: &[u16]| u32::from(two[0]) | u32::from(two.get(1).copied().unwrap_or(0)) << 16;
        Self { n, words: halves.chunks(n.max(1)).flat_map(|row| row.chunks(2).map(pair)).collect(), scale }
    }

    fn element(&self, row: usize, column: usize) -> [f32; 3] {
        if row.max(column) >= self.n {
            return [0.0; 3];
        }
        std::array::from_fn(|c| {
            let word = self.words[(c * self.n + row) * self.row_words() + column / 2];
            f16::from_bits((word >> (column % 2 * 16)) as u16).to_f32() * self.scale
        })
    }
}

impl Coded for Half {
    fn side(&self) -> usize {
        self.n
    }

    fn bytes(&self) -> Bytes {
        Bytes { blocks: 4 * self.words.len(), ..Bytes::default() }
    }

    fn texels(&self, row: usize, column: usize) -> [[f32; 3]; 16] {
        std::array::from_fn(|t| self.element(4 * row + t / 4, 4 * column + t % 4))
    }

    fn apart(&self, _: usize, _: &mut dyn FnMut(usize, usize, f32)) {}

    fn product(&self, x: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        let of = |row: usize| {
            let mut sums = vec![[0f32; 3]; lanes];
            for (turn, pair) in x[..x.len().min(self.n)].chunks(2).enumerate() {
                for (k, light) in pair.iter().enumerate() {
                    let element = self.element(row, 2 * turn + k);
                    (0..3).for_each(|c| sums[turn % lanes][c] += element[c] * light[c]);
                }
            }
            super::tree_sum(sums)
        };
        (0..self.n).into_par_iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scene::{check_decoding, error, scene};
    use super::*;

    #[test]
    fn r11_elements_are_off_by_half_a_step() {
        let scene = scene(6, 2);
        let operator = scene.resolvent();
        let encoded = Half::encode(scene.n, &operator).expect("an operator");
        check_decoding(&encoded);
        assert!(error(&encoded, &operator, &scene.lights) < 2e-4);
        for factor in [1e-30f32, 1e30] {
            let other = operator.clone().map(|of| of.iter().map(|x| x * factor).collect());
            let encoded = Half::encode(scene.n, &other).expect("an operator");
            let off = |c: usize| {
                let row = encoded.decode_row(7);
                row.iter().zip(&other[c][7 * scene.n..]).all(|(a, b)| (a[c] - b).abs() <= 5e-4 * b + 1e-7 * factor)
            };
            assert!(off(0) && off(2), "{factor}");
        }
        assert_eq!(encoded.bytes().total(), 12 * scene.n * scene.n.div_ceil(2));
        let halves: Vec<u16> = encoded.halves().collect();
        assert_eq!(halves.len(), 3 * scene.n * scene.n);
        assert_eq!(Half::of_halves(scene.n, &halves, encoded.scale), encoded);
    }
}
