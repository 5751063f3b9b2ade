//! Orders of rows and columns in which neighbours look alike, so that 4 x 4 blocks hold values that are close (A. Shcherbakov, thesis, 2017).
//!
//! Distances are sums of absolute differences (L1) of an 8-bit image of the matrix, usually of its logarithm after the largest values were taken out
//! ([`super::codec::thesis::image`]). Where two rows are as near, the lower index is taken; nothing here is drawn by chance.
//!
//! Rows and columns have orders of their own. Position p of the stored matrix S holds row `rows[p]`, and position q of its rows column `columns[q]`:
//! `S[p][q] = M[rows[p]][columns[q]]`. A product `y = M x` is then `y[rows[p]] = sum over q of S[p][q] x[columns[q]]`: [`gather`] x by `columns`,
//! multiply, [`scatter`] by `rows`. A square operator that is applied again and again scatters and gathers between products, by the one permutation
//! `x'[q] = y[p]` where `rows[p] = columns[q]`; where both orders are the same list that is the identity.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How rows and columns are put in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// As they come.
    None,
    /// Rows, greedily by all their values.
    Rows,
    /// Rows, then columns, greedily by all their values. O(n^3).
    RowsColumns,
    /// Rows, then columns, greedily by [`LANDMARKS`] of their values each. O(n^2) times [`LANDMARKS`].
    Landmarks,
}

impl Order {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Rows, Self::RowsColumns, Self::Landmarks];

    /// What it is called on command lines and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rows => "rows",
            Self::RowsColumns => "rows-columns",
            Self::Landmarks => "landmarks",
        }
    }
}

/// Positions at which rows (columns) are compared when not everywhere.
pub const LANDMARKS: usize = 128;

/// Nearest rows by landmarks of which all bytes are compared: without, the sum of distances in a room of 429 patches is 10 %
/// above the greedy one, with them 0.5 %.
pub const SHORTLIST: usize = 8;

/// Bytes that are worth handing to a thread: about 20 microseconds of comparisons.
const BYTES_A_TASK: usize = 1 << 18;

/// Orders of a matrix: `rows[p]` is the row at position p, `columns[q]` the column at position q. Each holds each of 0..n once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Orders {
    /// Of rows.
    pub rows: Vec<u32>,
    /// Of columns.
    pub columns: Vec<u32>,
}

impl Orders {
    /// Orders of an image of `n` x `n` x `channels` bytes, row-major, channels beside one another.
    ///
    /// # Errors
    /// The image has another size.
    pub fn new(order: Order, image: &[u8], n: usize, channels: usize) -> Result<Self, String> {
        check(image.len(), n, channels)?;
        let transposed = || transpose(image, n, channels);
        Ok(match order {
            Order::None => Self { rows: identity(n), columns: identity(n) },
            Order::Rows => Self { rows: rows(image, n, channels), columns: identity(n) },
            Order::RowsColumns => Self { rows: rows(image, n, channels), columns: rows(&transposed(), n, channels) },
            Order::Landmarks => {
                Self { rows: landmarks(image, n, channels), columns: landmarks(&transposed(), n, channels) }
            }
        })
    }

    /// A row-major matrix in these orders: `S[p][q] = M[rows[p]][columns[q]]`.
    ///
    /// # Errors
    /// The matrix has another size, or the orders name a row or column that it has not.
    pub fn apply<T: Copy + Send + Sync>(&self, matrix: &[T]) -> Result<Vec<T>, String> {
        let n = self.rows.len();
        check(matrix.len(), n, 1)?;
        if self.columns.len() != n || self.rows.iter().chain(&self.columns).any(|index| *index as usize >= n) {
            return Err(format!("orders of {n} rows and {} columns are no permutations", self.columns.len()));
        }
        let row = |p: &u32| {
            let row = &matrix[*p as usize * n..][..n];
            self.columns.iter().map(|q| row[*q as usize])
        };
        Ok(self.rows.par_iter().flat_map_iter(row).collect())
    }
}

/// The order 0, 1, 2 and so on.
pub fn identity(n: usize) -> Vec<u32> {
    (0..n as u32).collect()
}

/// Greedy order of rows by all their bytes: from row 0 on, always the row left over that is nearest to the last one. `image` as in [`Orders::new`];
/// the identity where it has another size. O(n^3).
pub fn rows(image: &[u8], n: usize, channels: usize) -> Vec<u32> {
    if check(image.len(), n, channels).is_err() {
        return identity(n);
    }
    path(image, n, n * channels, None)
}

/// Greedy order of rows by their bytes at [`LANDMARKS`] columns spread evenly, column `(2 k + 1) n / (2 LANDMARKS)`, or at all where there are fewer.
/// Of every row's [`SHORTLIST`] nearest by those the one nearest by all bytes comes next. `image` as in
/// [`Orders::new`]; the identity where it has another size.
pub fn landmarks(image: &[u8], n: usize, channels: usize) -> Vec<u32> {
    if check(image.len(), n, channels).is_err() {
        return identity(n);
    }
    if n <= LANDMARKS {
        return path(image, n, n * channels, None);
    }
    let chosen: Vec<usize> = (0..LANDMARKS).map(|k| (2 * k + 1) * n / (2 * LANDMARKS)).collect();
    let seen: Vec<u8> = image
        .par_chunks(n * channels)
        .flat_map_iter(|row| chosen.iter().flat_map(move |column| &row[column * channels..][..channels]).copied())
        .collect();
    path(&seen, n, LANDMARKS * channels, Some((image, n * channels)))
}

/// Sum over neighbouring rows, in this order, of the L1 distance of their bytes. 0 where image or order have another size.
pub fn neighbour_distance(image: &[u8], n: usize, channels: usize, order: &[u32]) -> u64 {
    if check(image.len(), n, channels).is_err() || order.iter().any(|row| *row as usize >= n) {
        return 0;
    }
    let bytes = n * channels;
    order.par_windows(2).map(|pair| distance(image, bytes, pair[0], pair[1])).sum()
}

/// Rows and columns exchanged; `image` as in [`Orders::new`]. Empty where it has another size.
pub fn transpose(image: &[u8], n: usize, channels: usize) -> Vec<u8> {
    if check(image.len(), n, channels).is_err() {
        return Vec::new();
    }
    let of = |column: usize| (0..n).flat_map(move |row| &image[(row * n + column) * channels..][..channels]).copied();
    (0..n).into_par_iter().flat_map_iter(of).collect()
}

/// `x` as positions of an order see it: value `order[q]` at position q. Values that `x` has not are the default.
pub fn gather<T: Copy + Default>(x: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|index| x.get(*index as usize).copied().unwrap_or_default()).collect()
}

/// Back from positions: the value at position p becomes number `order[p]`.
pub fn scatter<T: Copy + Default>(y: &[T], order: &[u32]) -> Vec<T> {
    let mut x = vec![T::default(); order.len()];
    for (value, index) in y.iter().zip(order) {
        if let Some(place) = x.get_mut(*index as usize) {
            *place = *value;
        }
    }
    x
}

/// Position of each index: the inverse of a permutation.
pub fn inverse(order: &[u32]) -> Vec<u32> {
    scatter(&identity(order.len()), order)
}

fn check(len: usize, n: usize, channels: usize) -> Result<(), String> {
    let wanted = n.checked_mul(n).and_then(|count| count.checked_mul(channels));
    if wanted == Some(len) && u32::try_from(n).is_ok() {
        return Ok(());
    }
    Err(format!("{len} values for {n} rows and columns with {channels} channels"))
}

/// Nearest-neighbour path from row 0 through rows of `bytes` bytes. With `whole` rows (all of them, bytes
/// of each) the [`SHORTLIST`] nearest are compared once more by those.
fn path(rows: &[u8], n: usize, bytes: usize, whole: Option<(&[u8], usize)>) -> Vec<u32> {
    let mut left = identity(n);
    let mut order = Vec::with_capacity(n);
    let mut last = match n {
        0 => return order,
        _ => left.swap_remove(0),
    };
    order.push(last);
    let a_task = (BYTES_A_TASK / bytes.max(1)).max(1);
    let mut found: Vec<(u64, u32, usize)> = Vec::with_capacity(n);
    while !left.is_empty() {
        // By distance, then by index: the same row in whatever order `left` is and however threads share it.
        let far = |(place, index): (usize, &u32)| (distance(rows, bytes, last, *index), *index, place);
        if left.len() <= a_task {
            found.clear();
            found.extend(left.iter().enumerate().map(far));
        } else {
            left.par_iter().enumerate().with_min_len(a_task).map(far).collect_into_vec(&mut found);
        }
        if let Some((image, bytes)) = whole {
            if found.len() > SHORTLIST {
                found.select_nth_unstable(SHORTLIST);
                found.truncate(SHORTLIST);
            }
            found.iter_mut().for_each(|(far, index, _)| *far = distance(image, bytes, last, *index));
        }
        let Some((_, _, place)) = found.iter().min() else { break };
        last = left.swap_remove(*place);
        order.push(last);
    }
    order
}

/// L1 distance of two rows of so many bytes.
fn distance(rows: &[u8], bytes: usize, a: u32, b: u32) -> u64 {
    let [a, b] = [a, b].map(|index| &rows[index as usize * bytes..][..bytes]);
    // Sums of 32 bits are what compilers turn into vector code; 2^16 differences fit in one.
    a.chunks(1 << 16)
        .zip(b.chunks(1 << 16))
        .map(|(a, b)| u64::from(a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b))).sum::<u32>()))
        .sum()
}

#[cfg(test)]
mod tests;
