//! Blocks of four by four elements in eight bytes: of 3 bits an element one value stands for exactly 0 (as BC4 has values for its ends), the other seven
//! for a geometric series between two ends. Blocks that are all 0 are left out. Of what is left over after that the largest share is stored by itself.
//!
//! The matrix is symmetric and free of colour: reflectance may change without another bake.
//!
//! A block is one u64: bits 0 to 7 the code of its smallest value, 8 to 15 that of the step between values, and from bit 16 on 3 bits an element, row
//! by row; level 0 is 0, level k is `ends[low] * steps[step]^(k - 1)`. The power is put together from the squares of the step, so that a device
//! comes to the same bits.

use exr::prelude::f16;
use rayon::prelude::*;

use super::logarithm::Logarithm;
use super::{BLOCK, tree_sum};

/// Of the elements that may have a residual, which share may lie beyond the top of the scale: those few would cost all others their steps.
const BEYOND: f64 = 0.1;
/// Of the sum of all elements, what may lie below the least that is told from 0: the total is kept by scaling.
const LOST: f64 = 3e-3;
/// Values of a code.
const CODES: usize = 256;
/// Levels that are not 0.
const LEVELS: u32 = 7;
/// Rounds in which the ends of a block are moved while that makes it better.
const MOVES: usize = 24;
/// Largest residual after scaling: f16 has its full precision down to 2^-14.
const RESIDUAL_TOP: f32 = 1024.0;

/// An exchange matrix over the areas of both patches.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroBlock {
    /// Rows and columns.
    pub count: usize,
    /// Blocks along each side.
    pub side: usize,
    /// Value of each code of an end; then that of each code of a step.
    pub tables: [Vec<f32>; 2],
    /// Where each row of blocks begins in `columns` and `blocks`; one more at the end.
    pub offsets: Vec<u32>,
    /// Column of each block.
    pub columns: Vec<u16>,
    /// Blocks that are not all 0, row by row.
    pub blocks: Vec<u64>,
    /// Where each row begins in `residuals`; one more at the end.
    pub residual_offsets: Vec<u32>,
    /// Column in the lower half, above it an f16 that times `residual_scale` is added.
    pub residuals: Vec<u32>,
    /// A power of two.
    pub residual_scale: f32,
}

impl ZeroBlock {
    /// Encodes a symmetric, non-negative matrix; `extract` is the share of elements whose residual is stored. `weights` says how much an error in a row
    /// or column matters: the areas of patches.
    pub fn encode(elements: &[f32], weights: &[f64], extract: f64) -> Self {
        let count = weights.len();
        let side = count.div_ceil(BLOCK);
        let spare = ((count * count) as f64 * extract.clamp(0.0, 1.0) * BEYOND) as usize;
        let scale = Logarithm::with_loss(elements, spare, LOST);
        let tables = tables(&scale);
        let at = |i: usize, j: usize| if i < count && j < count { elements[i * count + j].max(0.0) } else { 0.0 };
        let least = f64::from(tables[0][0]) * (-0.5 * scale.step).exp();
        // Right of the diagonal; the other half is the same turned over.
        let upper: Vec<Vec<(u16, u64)>> = (0..side)
            .into_par_iter()
            .map(|row| {
                let blocks = (row..side).filter_map(|column| {
                    let values =
                        std::array::from_fn(|k| f64::from(at(row * BLOCK + k / BLOCK, column * BLOCK + k % BLOCK)));
                    let block = encode_block(&values, least, &tables, scale.step);
                    (block >> 16 != 0).then_some((column as u16, block))
                });
                blocks.collect()
            })
            .collect();
        let mut rows: Vec<Vec<(u16, u64)>> = vec![Vec::new(); side];
        for (row, blocks) in upper.iter().enumerate() {
            for &(column, block) in blocks {
                if usize::from(column) != row {
                    rows[usize::from(column)].push((row as u16, turned(block)));
                }
            }
        }
        for (row, blocks) in rows.iter_mut().zip(upper) {
            row.extend(blocks);
        }
        let mut encoded = Self {
            count,
            side,
            tables,
            offsets: offsets(rows.iter().map(Vec::len)),
            columns: rows.iter().flatten().map(|b| b.0).collect(),
            blocks: rows.iter().flatten().map(|b| b.1).collect(),
            residual_offsets: vec![0; count + 1],
            residuals: Vec::new(),
            residual_scale: 1.0,
        };
        encoded.add_residuals(elements, weights, extract);
        encoded.keep_total(elements, weights);
        encoded
    }

    /// Stores what blocks are most wrong by, weighted by both areas; of equals those of lower rows and columns.
    fn add_residuals(&mut self, elements: &[f32], weights: &[f64], extract: f64) {
        let count = self.count;
        let wanted = ((count * count) as f64 * extract.clamp(0.0, 1.0)).round() as usize;
        let off: Vec<f32> = (0..count)
            .into_par_iter()
            .flat_map_iter(|i| {
                let row = self.block_row(i);
                (0..count).map(move |j| elements[i * count + j] - row[j])
            })
            .collect();
        let weight = |index: usize| (weights[index / count] * weights[index % count]).sqrt();
        let mut order: Vec<(f32, u32)> = off
            .par_iter()
            .enumerate()
            .filter(|(_, x)| **x != 0.0)
            .map(|(index, x)| ((f64::from(x.abs()) * weight(index)) as f32, index as u32))
            .collect();
        order.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.truncate(wanted);
        order.par_sort_unstable_by_key(|entry| entry.1);
        let largest = order.iter().map(|entry| off[entry.1 as usize].abs()).fold(0f32, f32::max);
        if largest > 0.0 {
            self.residual_scale = (largest / RESIDUAL_TOP).log2().ceil().exp2();
        }
        let mut lengths = vec![0usize; count];
        for &(_, index) in &order {
            let (i, j) = (index as usize / count, index as usize % count);
            let value = f16::from_f32(off[index as usize] / self.residual_scale);
            self.residuals.push(u32::from(value.to_bits()) << 16 | j as u32);
            lengths[i] += 1;
        }
        self.residual_offsets = offsets(lengths.into_iter());
    }

    /// Scales what blocks hold so that all of the matrix exchanges as much as before: errors of single elements even out, a share of all would not.
    fn keep_total(&mut self, elements: &[f32], weights: &[f64]) {
        let count = self.count;
        let total = |row: &dyn Fn(usize) -> Vec<f32>| -> f64 {
            let of = |i: usize| row(i).iter().zip(weights).map(|(x, w)| f64::from(*x) * w).sum::<f64>() * weights[i];
            (0..count).map(of).sum()
        };
        let (blocks, all) = (total(&|i| self.block_row(i)), total(&|i| self.row(i)));
        let wanted = total(&|i| elements[i * count..(i + 1) * count].to_vec());
        if blocks > 0.0 {
            let factor = (1.0 + (wanted - all) / blocks) as f32;
            self.tables[0].iter_mut().for_each(|end| *end *= factor);
        }
    }

    /// A row as its blocks have it.
    fn block_row(&self, i: usize) -> Vec<f32> {
        let mut row = vec![0f32; self.side * BLOCK];
        let blocks = self.offsets[i / BLOCK] as usize..self.offsets[i / BLOCK + 1] as usize;
        for at in blocks {
            for k in 0..BLOCK {
                row[usize::from(self.columns[at]) * BLOCK + k] = self.element(self.blocks[at], i % BLOCK * BLOCK + k);
            }
        }
        row.truncate(self.count);
        row
    }

    /// Element k of a block, as a device decodes it.
    pub fn element(&self, block: u64, k: usize) -> f32 {
        let level = (block >> (16 + 3 * k)) as u32 & 7;
        if level == 0 {
            return 0.0;
        }
        let step = self.tables[1][(block >> 8 & 255) as usize];
        let (twice, steps) = (step * step, level - 1);
        let mut value = self.tables[0][(block & 255) as usize];
        value *= if steps & 1 != 0 { step } else { 1.0 };
        value *= if steps & 2 != 0 { twice } else { 1.0 };
        value * if steps & 4 != 0 { twice * twice } else { 1.0 }
    }

    /// A row, residuals added.
    pub fn row(&self, i: usize) -> Vec<f32> {
        let mut row = self.block_row(i);
        for entry in self.residuals_of(i) {
            row[(entry & 0xffff) as usize] += self.residual(*entry);
        }
        row
    }

    fn residuals_of(&self, i: usize) -> &[u32] {
        &self.residuals[self.residual_offsets[i] as usize..self.residual_offsets[i + 1] as usize]
    }

    fn residual(&self, entry: u32) -> f32 {
        f16::from_bits((entry >> 16) as u16).to_f32() * self.residual_scale
    }

    /// Row by row what `sent` comes to, as `lanes` threads for four rows add it: thread k takes blocks k, k + lanes and so on, then residuals alike.
    pub fn product(&self, sent: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        let of = |row: usize| -> Vec<[f32; 3]> {
            let mut sums = vec![[0f32; 3 * BLOCK]; lanes];
            let blocks = self.offsets[row] as usize..self.offsets[row + 1] as usize;
            for (turn, at) in blocks.enumerate() {
                let sum = &mut sums[turn % lanes];
                for k in 0..BLOCK * BLOCK {
                    let (down, across) = (k / BLOCK, k % BLOCK);
                    let element = self.element(self.blocks[at], k);
                    let from = sent.get(usize::from(self.columns[at]) * BLOCK + across).copied().unwrap_or([0.0; 3]);
                    (0..3).for_each(|c| sum[down * 3 + c] += element * from[c]);
                }
            }
            let rows = self.count.saturating_sub(row * BLOCK).min(BLOCK);
            for down in 0..rows {
                for (turn, entry) in self.residuals_of(row * BLOCK + down).iter().enumerate() {
                    let from = sent[(entry & 0xffff) as usize];
                    let sum = &mut sums[turn % lanes];
                    (0..3).for_each(|c| sum[down * 3 + c] += self.residual(*entry) * from[c]);
                }
            }
            tree_sum(sums).chunks_exact(3).take(rows).map(|e| [e[0], e[1], e[2]]).collect()
        };
        (0..self.side).into_par_iter().flat_map_iter(of).collect()
    }

    /// Whether every offset and column lies in what it points into.
    ///
    /// # Errors
    /// The field and the index, in words.
    pub fn check(&self) -> Result<(), String> {
        let grows = |name: &str, offsets: &[u32], end: usize| match offsets.windows(2).position(|w| w[0] > w[1]) {
            Some(at) => Err(format!("{name}[{at}] passes the one behind it")),
            None if offsets.first() != Some(&0) || offsets.last().copied() != Some(end as u32) => {
                Err(format!("{name} does not end at {end}"))
            }
            None => Ok(()),
        };
        grows("block_offsets", &self.offsets, self.blocks.len())?;
        grows("residual_offsets", &self.residual_offsets, self.residuals.len())?;
        if self.columns.len() != self.blocks.len() {
            return Err(format!("{} block_columns for {} blocks", self.columns.len(), self.blocks.len()));
        }
        if let Some(at) = self.columns.iter().position(|column| usize::from(*column) >= self.side) {
            return Err(format!("block_columns[{at}] is {}, of {} there are", self.columns[at], self.side));
        }
        match self.residuals.iter().position(|entry| (entry & 0xffff) as usize >= self.count) {
            Some(at) => Err(format!("residuals[{at}] has no column of {}", self.count)),
            None => Ok(()),
        }
    }

    /// Bytes on a device: tables, where rows begin, columns, blocks and residuals.
    pub fn bytes(&self) -> u64 {
        let offsets = (self.offsets.len() + self.residual_offsets.len()) * 4;
        let tables = self.tables.iter().map(|table| table.len() * 4).sum::<usize>();
        (tables + offsets + self.columns.len() * 2 + self.blocks.len() * 8 + self.residuals.len() * 4) as u64
    }

    /// The same with everything that is stored less by `factor`, a bit at a time: keeps a product from growing.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.tables[0].iter_mut().for_each(|end| *end *= factor);
        self.residual_scale *= factor;
        self
    }
}

/// Where runs of these lengths begin, and where the last one ends.
fn offsets(lengths: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut all = vec![0];
    let mut end = 0;
    for length in lengths {
        end += length as u32;
        all.push(end);
    }
    all
}

/// The block of the elements on the other side of the diagonal.
fn turned(block: u64) -> u64 {
    (0..BLOCK * BLOCK).fold(block & 0xffff, |all, k| {
        let level = block >> (16 + 3 * k) & 7;
        all | level << (16 + 3 * (k % BLOCK * BLOCK + k / BLOCK))
    })
}

/// Ends by their code, up to the top of the scale; steps by theirs: seven levels reach from one end to any other.
fn tables(scale: &Logarithm) -> [Vec<f32>; 2] {
    let top = scale.top.max(f64::from(f32::MIN_POSITIVE));
    let end = |code: usize| (top * ((code as f64 - (CODES - 1) as f64) * scale.step).exp()) as f32;
    let step = |code: usize| (code as f64 * scale.step / f64::from(LEVELS - 1)).exp() as f32;
    [(0..CODES).map(end).collect(), (0..CODES).map(step).collect()]
}

/// A block whose squared error no move of an end makes smaller.
fn encode_block(values: &[f64; BLOCK * BLOCK], least: f64, tables: &[Vec<f32>; 2], per_code: f64) -> u64 {
    let held = values.iter().copied().filter(|x| *x >= least);
    let (low, high) = held.fold((f64::INFINITY, 0.0), |(a, b), x| (f64::min(a, x), f64::max(b, x)));
    if high == 0.0 {
        return 0;
    }
    let code = |x: f64| {
        let last = (CODES - 1) as f64;
        let top = f64::from(tables[0][CODES - 1]);
        ((x / top).ln() / per_code + last).round().clamp(0.0, last) as i32
    };
    let mut best = (code(low), code(high) - code(low));
    let (mut error, mut block) = fitted(values, best, tables);
    for _ in 0..MOVES {
        let moves = [(-1, 0), (1, 0), (0, -1), (0, 1), (1, -1), (-1, 1), (2, -2), (0, -3)];
        let tried = moves.map(|(low, step)| {
            let ends = (best.0 + low, best.1 + step);
            let inside = (0..CODES as i32).contains(&ends.0) && (0..CODES as i32).contains(&ends.1);
            (ends, if inside { fitted(values, ends, tables) } else { (f64::INFINITY, 0) })
        });
        let (ends, found) = tried.into_iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap_or((best, (error, block)));
        if found.0 >= error {
            break;
        }
        (best, error, block) = (ends, found.0, found.1);
    }
    block
}

/// Squared error, and the block, with these codes of the smallest value and of the step.
fn fitted(values: &[f64; BLOCK * BLOCK], (low, step): (i32, i32), tables: &[Vec<f32>; 2]) -> (f64, u64) {
    let (end, ratio) = (f64::from(tables[0][low as usize]), f64::from(tables[1][step as usize]));
    let mut levels = [0.0; LEVELS as usize + 1];
    let mut value = end;
    for level in &mut levels[1..] {
        *level = value;
        value *= ratio;
    }
    let mut error = 0.0;
    let mut block = low as u64 | (step as u64) << 8;
    for (k, x) in values.iter().enumerate() {
        let nearest = (0..levels.len())
            .fold(0, |best, at| if (levels[at] - x).abs() < (levels[best] - x).abs() { at } else { best });
        error += (levels[nearest] - x).powi(2);
        block |= (nearest as u64) << (16 + 3 * k);
    }
    (error, block)
}

#[cfg(test)]
mod tests;
