//! Coloured operators from form factors F and reflectances R of patches: light that arrives after any number of bounces, or up to k of them.
//!
//! Irradiance of all patches from exitance `B0 = R E_direct` is `sum over h of F (R F)^(h-1) B0`: the codecs hold that sum, one matrix a channel. The
//! thesis stops at h = k; the sum without end is the resolvent `F (I - R F)^-1`.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

/// Relative change at which a resolvent is done.
const TOLERANCE: f64 = 1e-7;
/// Doublings after which a series is said to diverge: 2^14 bounces, enough up to a spectral radius of 0.999.
const DOUBLINGS: u32 = 14;
/// Rows of a task: enough that packing the other matrix costs little.
const ROWS: usize = 512;

/// `sum over h = 1..=k of F (R F)^(h-1)` by channel, from row-major `f` (n x n) and the reflectance of n patches. Sums in f32. Zero matrices where
/// k = 0. O(k n^3).
///
/// # Errors
/// Lengths that do not fit, or a result beyond f32.
pub fn polynomial(f: &[f32], n: usize, reflectance: &[[f32; 3]], k: u32) -> Result<[Vec<f32>; 3], String> {
    check(f, n, reflectance)?;
    channels(|c| {
        let reflect = |j: usize| f64::from(reflectance[j][c]);
        let mut sum = if k == 0 { vec![0.0; n * n] } else { f.to_vec() };
        for _ in 1..k {
            // Horner: P <- F + F R P.
            sum = multiply_add(f, n, reflect, &sum, f);
        }
        finite(sum, c)
    })
}

/// `F (I - R F)^-1` by channel: the sum of [`polynomial`] without end, doubled (`S_2m = S_m + (F R)^m S_m`) until a doubling changes no row by more
/// than 1e-7 of the largest sum of a row. O(n^3) for each of about log2 of the number of bounces.
///
/// # Errors
/// Lengths that do not fit, or a series that has not come to rest after 2^14 bounces: some reflectances are 1 or nearly, or rows of F exceed 1.
pub fn resolvent(f: &[f32], n: usize, reflectance: &[[f32; 3]]) -> Result<[Vec<f32>; 3], String> {
    check(f, n, reflectance)?;
    channels(|c| {
        let zero = vec![0.0; n * n];
        let mut sum = f.to_vec();
        let mut power: Vec<f32> =
            f.iter().enumerate().map(|(at, x)| (f64::from(*x) * f64::from(reflectance[at % n][c])) as f32).collect();
        for _ in 0..DOUBLINGS {
            let next = finite(multiply_add(&power, n, |_| 1.0, &sum, &sum), c)?;
            let (change, size) =
                next.chunks(n.max(1)).zip(sum.chunks(n.max(1))).fold((0.0f64, 0.0f64), |(change, size), (new, old)| {
                    let change_here: f64 =
                        new.iter().zip(old).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).sum();
                    let size_here: f64 = new.iter().map(|x| f64::from(x.abs())).sum();
                    (change.max(change_here), size.max(size_here))
                });
            sum = next;
            if change <= TOLERANCE * size {
                return Ok(sum);
            }
            power = finite(multiply_add(&power, n, |_| 1.0, &power, &zero), c)?;
        }
        Err(format!("channel {c}: light does not come to rest in {} bounces", 1u32 << DOUBLINGS))
    })
}

fn channels(of: impl Fn(usize) -> Result<Vec<f32>, String>) -> Result<[Vec<f32>; 3], String> {
    Ok([of(0)?, of(1)?, of(2)?])
}

fn check(f: &[f32], n: usize, reflectance: &[[f32; 3]]) -> Result<(), String> {
    if n.checked_mul(n) != Some(f.len()) || reflectance.len() != n {
        return Err(format!("{} form factors and {} reflectances of {n} patches", f.len(), reflectance.len()));
    }
    Ok(())
}

fn finite(values: Vec<f32>, channel: usize) -> Result<Vec<f32>, String> {
    if values.par_iter().all(|x| x.is_finite()) {
        return Ok(values);
    }
    Err(format!("channel {channel}: the sum of bounces is not finite"))
}

/// `C + A D B` with a diagonal D; the same sums whichever thread does them, as each task has rows of its own.
fn multiply_add(a: &[f32], n: usize, diagonal: impl Fn(usize) -> f64 + Sync, b: &[f32], c: &[f32]) -> Vec<f32> {
    let scaled: Vec<f32> = b.par_iter().enumerate().map(|(at, x)| (diagonal(at / n) * f64::from(*x)) as f32).collect();
    let mut product = c.to_vec();
    let Ok(right) = ArrayView2::from_shape((n, n), &scaled) else { return product };
    let a_task = ROWS * n.max(1);
    product.par_chunks_mut(a_task).zip(a.par_chunks(a_task)).for_each(|(to, left)| {
        let rows = to.len() / n;
        if let (Ok(left), Ok(mut to)) =
            (ArrayView2::from_shape((rows, n), left), ArrayViewMut2::from_shape((rows, n), to))
        {
            general_mat_mul(1.0, &left, &right, 1.0, &mut to);
        }
    });
    product
}

#[cfg(test)]
mod tests;
