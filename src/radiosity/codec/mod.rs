//! Ways to store an exchange matrix, each with the product that a device makes of it, bit for bit.

pub mod bc1;
pub mod bc4_chroma;
pub mod block;
pub mod bounces;
pub mod coded;
pub mod dense;
pub mod fit;
pub mod half;
pub mod levels;
pub mod linear;
pub mod logarithm;
mod residual;
pub mod skip;
pub mod sparse;
pub mod summed;
#[cfg(test)]
pub(super) mod test_scene;
pub mod thesis;
pub mod zero_block;

pub use coded::{Bytes, Coded, check};
pub use dense::Dense;
pub use summed::{Code, Summed};
pub use zero_block::ZeroBlock;

/// Rows of a block, which one group of threads gathers for.
pub const BLOCK: usize = 4;

/// Partial sums of so many threads, added in the order in which a group of them does it: halves onto halves.
pub fn tree_sum<const N: usize>(mut lanes: Vec<[f32; N]>) -> [f32; N] {
    let mut width = lanes.len();
    while width > 1 {
        width /= 2;
        let (low, high) = lanes.split_at_mut(width);
        for (sum, added) in low.iter_mut().zip(high) {
            sum.iter_mut().zip(added).for_each(|(sum, added)| *sum += *added);
        }
    }
    lanes.first().copied().unwrap_or([0.0; N])
}

/// Root of the mean squared difference over that of what is right, rows weighted by `areas`.
pub fn relative_l2(found: &[[f64; 3]], right: &[[f64; 3]], areas: &[f64]) -> f64 {
    let sums = found.iter().zip(right).zip(areas).fold([0.0; 2], |[off, all], ((a, b), area)| {
        let square = |of: &dyn Fn(usize) -> f64| (0..3).map(|c| of(c) * of(c)).sum::<f64>() * area;
        [off + square(&|c| a[c] - b[c]), all + square(&|c| b[c])]
    });
    if sums[1] > 0.0 { (sums[0] / sums[1]).sqrt() } else { 0.0 }
}
