//! `bc1`: logarithmic codes in BC1 blocks whose ends are fitted to what they decode to, and 2 % of the elements, those that the blocks miss by most,
//! with what is missing.
//!
//! Each channel has a scale of its own, 4 to 12 nats as its values ask for ([`Logarithm::of`]); code 0 is exactly 0. Elements that are 0 in all
//! channels, or closer to it than to code 1, decode to exactly 0: by index 3 of blocks of three colours, which nothing else has. Other blocks have four
//! colours; one whose ends are the same reads as three, without index 3. Blocks of nothing but zeros are not stored.
//!
//! In memory: [`Bc1::stored`] tells for block `b = row * side + column` of [`block::side`] squared ones where in [`Bc1::blocks`] it is; [`Bc1::tables`]
//! holds 256 f32 each for red, green and blue; [`Bc1::apart`] is added.

use super::block::{self, Block};
use super::linear::Fitter;
use super::logarithm::{Logarithm, Table};
use super::residual::{SHARE, Source};
use super::skip::Stored;
use super::sparse::{self, Residuals};
use super::{Bytes, Coded};

/// Of the elements that may be kept apart, which share may lie beyond the top of the scale: those few would cost all others
/// their steps.
pub(super) const BEYOND: f64 = 0.5;

/// An encoded operator.
#[derive(Debug, Clone, PartialEq)]
pub struct Bc1 {
    /// Rows and columns.
    pub n: usize,
    /// Which blocks are stored.
    pub stored: Stored,
    /// BC1 blocks that are.
    pub blocks: Vec<Block>,
    /// f32 of each code by channel.
    pub tables: [Table; 3],
    /// What to add.
    pub apart: Residuals,
}

impl Bc1 {
    /// From three row-major n x n matrices, red, green and blue.
    ///
    /// # Errors
    /// As [`super::check`].
    pub fn encode(n: usize, operator: &[Vec<f32>; 3]) -> Result<Self, String> {
        super::check(n, operator)?;
        let spare = sparse::share(n, SHARE * BEYOND);
        let logarithms = [0, 1, 2].map(|c| Logarithm::of(&operator[c], spare));
        let tables = logarithms.map(|logarithm| logarithm.table());
        let fitter = Fitter::new(logarithms);
        let (blocks, apart) = Source { n, operator }.keep_apart(
            |texels| fitter.fit(texels),
            |block| block.map_or([[0.0; 3]; 16], |block| decode(block, &tables)),
        );
        let stored = Stored::new(blocks.iter().map(Option::is_some));
        Ok(Self { n, stored, blocks: blocks.into_iter().flatten().collect(), tables, apart })
    }
}

impl Coded for Bc1 {
    fn side(&self) -> usize {
        self.n
    }

    fn bytes(&self) -> Bytes {
        Bytes {
            blocks: 8 * self.blocks.len() + self.stored.bytes(),
            sparse: self.apart.bytes(),
            tables: size_of_val(&self.tables),
        }
    }

    fn texels(&self, row: usize, column: usize) -> [[f32; 3]; 16] {
        let number = self.stored.find(row * block::side(self.n) + column);
        let block = number.and_then(|number| self.blocks.get(number));
        block.map_or([[0.0; 3]; 16], |block| decode(*block, &self.tables))
    }

    fn apart(&self, row: usize, add: &mut dyn FnMut(usize, usize, f32)) {
        for (column, value) in self.apart.row(row) {
            (0..3).for_each(|c| add(column, c, value[c]));
        }
    }
}

fn decode(block: Block, tables: &[Table; 3]) -> [[f32; 3]; 16] {
    let palette = block::bc1_palette(block).map(|codes| [0, 1, 2].map(|c| tables[c][usize::from(codes[c])]));
    std::array::from_fn(|texel| palette[block::bc1_index(block, texel)])
}

#[cfg(test)]
mod tests;
