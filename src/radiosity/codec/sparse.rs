//! What codecs keep apart from their blocks: rows of single elements (compressed sparse rows), to be added to what the blocks decode to.

use exr::prelude::f16;
use rayon::prelude::*;

/// Rows and columns that 16-bit column numbers reach.
pub const MOST: usize = 1 << 16;

/// Elements of one channel, f32.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values {
    /// Element numbers `offsets[i]..offsets[i + 1]` lie in row i; n + 1 of them.
    pub offsets: Vec<u32>,
    /// Column of each element, ascending within a row.
    pub columns: Vec<u16>,
    /// What to add.
    pub values: Vec<f32>,
}

impl Values {
    /// From values at ascending element numbers `row * n + column`.
    pub(super) fn new(n: usize, elements: impl Iterator<Item = (usize, f32)>) -> Self {
        let mut sparse = Self { offsets: vec![0; n + 1], ..Self::default() };
        for (element, value) in elements {
            sparse.offsets[element / n + 1] += 1;
            sparse.columns.push((element % n) as u16);
            sparse.values.push(value);
        }
        accumulate(&mut sparse.offsets);
        sparse
    }

    /// Columns and values of a row, columns ascending; nothing where there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let range = range(&self.offsets, row, self.values.len().min(self.columns.len()));
        self.columns[range.clone()].iter().map(|column| usize::from(*column)).zip(self.values[range].iter().copied())
    }

    /// Bytes as stored.
    pub fn bytes(&self) -> usize {
        4 * self.offsets.len() + 6 * self.values.len()
    }
}

/// Elements of three channels, f16 times a power of two.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Residuals {
    /// As in [`Values`].
    pub offsets: Vec<u32>,
    /// Word 0: column in bits 0..16, red above; word 1: green in bits 0..16, blue above. Columns ascend within a row.
    pub elements: Vec<[u32; 2]>,
    /// What every f16 is multiplied by, so that neither large nor small ones leave its range.
    pub scale: f32,
}

impl Residuals {
    /// From values at ascending element numbers `row * n + column`.
    pub(super) fn new(n: usize, values: &[(usize, [f32; 3])]) -> Self {
        let largest = values.iter().flat_map(|(_, value)| value).fold(0.0f32, |most, x| most.max(x.abs()));
        // The largest comes to lie in [2^14, 2^15); f16 ends below 2^16. 2^-126 is the least normal f32.
        let exponent = (((largest.to_bits() >> 23) as i32 - 127) - 14).max(-126);
        let scale = f32::from_bits(((exponent + 127) as u32) << 23);
        let bits = |x: f32| u32::from(f16::from_f32(x / scale).to_bits());
        let mut offsets = vec![0; n + 1];
        let element = |(element, [red, green, blue]): &(usize, [f32; 3])| {
            offsets[element / n + 1] += 1;
            [(element % n) as u32 | bits(*red) << 16, bits(*green) | bits(*blue) << 16]
        };
        let elements = values.iter().map(element).collect();
        accumulate(&mut offsets);
        Self { offsets, elements, scale }
    }

    /// Columns and values of a row, columns ascending; nothing where there is no such row. A value is its f16 as f32 times [`Self::scale`].
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, [f32; 3])> + '_ {
        self.elements[range(&self.offsets, row, self.elements.len())].iter().map(|[low, high]| {
            let of = |bits: u32| f16::from_bits(bits as u16).to_f32() * self.scale;
            ((low & 0xffff) as usize, [of(low >> 16), of(*high), of(high >> 16)])
        })
    }

    /// Bytes as stored.
    pub fn bytes(&self) -> usize {
        4 * self.offsets.len() + 8 * self.elements.len() + 4
    }
}

/// Numbers of the `count` largest, ascending: by value, then by number, the lower first, so that ties neither add nor lose one. Never a zero, so there
/// may be fewer.
pub fn largest(values: &[f32], count: usize) -> Vec<usize> {
    let mut chosen: Vec<usize> =
        values.par_iter().enumerate().filter(|(_, value)| **value > 0.0).map(|(number, _)| number).collect();
    if count == 0 {
        return Vec::new();
    }
    if count < chosen.len() {
        chosen.select_nth_unstable_by(count, |a, b| values[*b].total_cmp(&values[*a]).then(a.cmp(b)));
        chosen.truncate(count);
    }
    chosen.sort_unstable();
    chosen
}

/// `share` of all elements of an `n` x `n` matrix, rounded down.
pub fn share(n: usize, share: f64) -> usize {
    (n as f64 * n as f64 * share) as usize
}

fn accumulate(offsets: &mut [u32]) {
    let mut sum = 0;
    offsets.iter_mut().for_each(|offset| {
        sum += *offset;
        *offset = sum;
    });
}

fn range(offsets: &[u32], row: usize, len: usize) -> std::ops::Range<usize> {
    match offsets.get(row..).unwrap_or_default() {
        [from, to, ..] if from <= to && *to as usize <= len => *from as usize..*to as usize,
        _ => 0..0,
    }
}

#[cfg(test)]
mod tests;
