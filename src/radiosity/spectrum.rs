//! Smallest and largest eigenvalue of one reflection: what bounces may grow or fall by, and what Chebyshev iteration is told.

use serde::{Deserialize, Serialize};

use super::patches::Patches;

/// Steps of the power method.
const STEPS: usize = 60;
/// Eigenvalues found are widened by this share of what lies between the found and the bound by row sums.
const WIDEN: f64 = 0.02;

/// Of gathering light and reflecting it, over all three channels. Real: the operator is similar to a symmetric one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// At most 0.
    pub smallest: f64,
    /// Less than 1, or light never ends.
    pub largest: f64,
}

/// What gathers light that patches send, exitance times area, as irradiance.
pub type Product<'a> = &'a dyn Fn(&[[f32; 3]]) -> Vec<[f32; 3]>;

/// Found by the power method in the norm in which the operator is symmetric: areas times reflectance. First the largest in size, which is positive since
/// no element is negative; then, with that much added, the other end.
pub fn of(product: Product, patches: &Patches) -> Spectrum {
    let count = patches.list.len();
    // Rows of R^(1/2) A^(1/2) K A^(1/2) R^(1/2), by channel.
    let roots: Vec<[f64; 3]> = patches
        .list
        .iter()
        .map(|patch| (patch.reflectance * patch.area).to_array().map(|x| x.max(0.0).sqrt()))
        .collect();
    let applied = |vector: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let sent: Vec<[f32; 3]> =
            vector.iter().zip(&roots).map(|(v, root)| std::array::from_fn(|c| (v[c] * root[c]) as f32)).collect();
        let gathered = product(&sent);
        gathered.iter().zip(&roots).map(|(g, root)| std::array::from_fn(|c| f64::from(g[c]) * root[c])).collect()
    };
    let norm = |vector: &[[f64; 3]], c: usize| vector.iter().map(|v| v[c] * v[c]).sum::<f64>().sqrt();
    // Largest eigenvalue of the operator plus `shift`, less that; a channel each.
    let power = |shift: [f64; 3], first: &dyn Fn(usize) -> f64| -> [f64; 3] {
        let mut vector: Vec<[f64; 3]> = (0..count).map(|i| [first(i); 3]).collect();
        let mut found = [0.0; 3];
        for _ in 0..STEPS {
            let lengths: [f64; 3] = std::array::from_fn(|c| norm(&vector, c).max(f64::MIN_POSITIVE));
            vector.iter_mut().for_each(|v| (0..3).for_each(|c| v[c] /= lengths[c]));
            let next: Vec<[f64; 3]> = applied(&vector)
                .iter()
                .zip(&vector)
                .map(|(a, v)| std::array::from_fn(|c| shift[c] * v[c] - a[c] * if shift[c] > 0.0 { 1.0 } else { -1.0 }))
                .collect();
            found = std::array::from_fn(|c| norm(&next, c));
            vector = next;
        }
        found
    };
    let largest = power([0.0; 3], &|_| 1.0);
    // The vector has parts along every eigenvector, as good as surely.
    let other = power(largest, &|i| if (i * 7919) % 13 < 6 { 1.0 } else { -1.0 });
    let smallest = (0..3).map(|c| largest[c] - other[c]).fold(0.0, f64::min);
    let largest = largest.into_iter().fold(0.0, f64::max);
    Spectrum { smallest: smallest * (1.0 + WIDEN), largest: largest + WIDEN * (1.0 - largest).max(0.0) }
}
