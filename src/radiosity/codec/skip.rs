//! Which blocks are stored: a bit a block, and how many are stored before each word of bits.

use super::block::{self, Block};

/// Blocks that are stored, the others being zero all over.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stored {
    /// Bit `b % 32` of word `b / 32`: block b is stored.
    pub mask: Vec<u32>,
    /// Stored blocks before each word.
    pub counts: Vec<u32>,
}

impl Stored {
    /// From one answer a block.
    pub fn new(stored: impl Iterator<Item = bool>) -> Self {
        let mut list = Self::default();
        let mut count = 0;
        for (number, is_stored) in stored.enumerate() {
            if number % 32 == 0 {
                list.mask.push(0);
                list.counts.push(count);
            }
            if let Some(word) = list.mask.last_mut() {
                *word |= u32::from(is_stored) << (number % 32);
            }
            count += u32::from(is_stored);
        }
        list
    }

    /// Where block `number` is stored: the count before its word and the bits below its own; `None` where it is not.
    pub fn find(&self, number: usize) -> Option<usize> {
        let (mask, before) = self.mask.get(number / 32).zip(self.counts.get(number / 32))?;
        let bit = 1u32 << (number % 32);
        (mask & bit != 0).then(|| *before as usize + (mask & (bit - 1)).count_ones() as usize)
    }

    /// All blocks of a matrix of `n` rows, `zeros` where one is not stored.
    pub fn all(&self, blocks: &[Block], n: usize, zeros: Block) -> Vec<Block> {
        let of = |number: usize| self.find(number).and_then(|at| blocks.get(at)).copied().unwrap_or(zeros);
        (0..block::side(n) * block::side(n)).map(of).collect()
    }

    /// The way back: those that are not `zeros`.
    pub fn of_all(blocks: &[Block], zeros: Block) -> (Self, Vec<Block>) {
        let stored = Self::new(blocks.iter().map(|block| *block != zeros));
        (stored, blocks.iter().copied().filter(|block| *block != zeros).collect())
    }

    /// Bytes as stored.
    pub fn bytes(&self) -> usize {
        4 * (self.mask.len() + self.counts.len())
    }
}

#[cfg(test)]
mod tests;
