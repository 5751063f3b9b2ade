//! Every element in 32 bits: what the others are measured against.

use rayon::prelude::*;

use super::tree_sum;

/// Exchange matrix over the areas of both patches, 1 / m^2, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    /// Rows and columns.
    pub count: usize,
    /// Row-major.
    pub elements: Vec<f32>,
}

impl Dense {
    /// Bytes on a device.
    pub fn bytes(&self) -> u64 {
        self.elements.len() as u64 * 4
    }

    /// Row by row what `sent` comes to, as `lanes` threads a row add it: thread k takes columns k, k + lanes and so on.
    pub fn product(&self, sent: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        let of = |row: &[f32]| {
            let mut sums = vec![[0f32; 3]; lanes];
            for (j, (share, sent)) in row.iter().zip(sent).enumerate() {
                let sum = &mut sums[j % lanes];
                (0..3).for_each(|c| sum[c] += share * sent[c]);
            }
            tree_sum(sums)
        };
        self.elements.par_chunks(self.count.max(1)).map(of).collect()
    }
}
