//! Ends of BC1 blocks by least squares in the space of codes.

use super::block::{self, Block, End, Palette};

/// Codes of 16 texels.
pub type Codes = [[f32; 3]; 16];

/// Weights of 16 texels, none negative; 0 where a texel may become anything.
pub type Weights = [f32; 16];

/// Steps of the power iteration: codes of a block mostly lie along one line, which it finds in two or three.
const ITERATIONS: u32 = 8;

/// Both ends of the texels along their principal axis through the mean; one point twice where they are all the same, black where none has weight.
pub fn extremes(codes: &Codes, weights: &Weights) -> [[f32; 3]; 2] {
    let total: f32 = weights.iter().sum();
    if total <= 0.0 {
        return [[0.0; 3]; 2];
    }
    let seen = || codes.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    let mean: [f32; 3] = [0, 1, 2].map(|c| seen().map(|(code, weight)| code[c] * weight / total).sum());
    let mut covariance = [[0.0f32; 3]; 3];
    for (code, weight) in seen() {
        let from_mean = [0, 1, 2].map(|c| code[c] - mean[c]);
        for (row, a) in covariance.iter_mut().zip(from_mean) {
            row.iter_mut().zip(from_mean).for_each(|(sum, b)| *sum += weight / total * a * b);
        }
    }
    let widest = (0..3).max_by(|a, b| covariance[*a][*a].total_cmp(&covariance[*b][*b])).unwrap_or(0);
    let mut axis = covariance[widest];
    for _ in 0..ITERATIONS {
        let length = axis.iter().map(|x| x * x).sum::<f32>().sqrt();
        if length <= 1e-6 {
            return [mean; 2];
        }
        let unit = axis.map(|x| x / length);
        axis = covariance.map(|row| row.iter().zip(unit).map(|(a, b)| a * b).sum());
    }
    let length = axis.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-12);
    let unit = axis.map(|x| x / length);
    let along = |code: &[f32; 3]| -> f32 { (0..3).map(|c| (code[c] - mean[c]) * unit[c]).sum() };
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for (code, _) in seen() {
        let t = along(code);
        (least, most) = (least.min(t), most.max(t));
    }
    [most, least].map(|t| [0, 1, 2].map(|c| mean[c] + t * unit[c]))
}

/// Ends that fit best while every texel keeps its index of four colours; `None` where all texels lie at one point of the line.
pub fn refined(codes: &Codes, weights: &Weights, indices: &[u8; 16]) -> Option<[[f32; 3]; 2]> {
    // Texel = (1 - t) * end 0 + t * end 1: normal equations.
    let (mut aa, mut ab, mut bb) = (0.0f32, 0.0f32, 0.0f32);
    let (mut a, mut b) = ([0.0f32; 3], [0.0f32; 3]);
    for ((code, weight), index) in codes.iter().zip(weights).zip(indices) {
        let t = [0.0, 1.0, 1.0 / 3.0, 2.0 / 3.0][usize::from(index & 3)];
        let u = 1.0 - t;
        aa += weight * u * u;
        ab += weight * u * t;
        bb += weight * t * t;
        for c in 0..3 {
            a[c] += weight * u * code[c];
            b[c] += weight * t * code[c];
        }
    }
    let determinant = aa * bb - ab * ab;
    if determinant <= 1e-6 * (aa + bb) * (aa + bb) {
        return None;
    }
    let solve = |p: [f32; 3], q: [f32; 3], x: f32, y: f32| [0, 1, 2].map(|c| (x * p[c] - y * q[c]) / determinant);
    Some([solve(a, b, bb, ab), solve(b, a, aa, ab)])
}

/// The nearest index of each texel, the lower of two as near, and the weighted sum of squares.
pub fn nearest(codes: &Codes, weights: &Weights, palette: &Palette) -> ([u8; 16], f32) {
    let palette = palette.map(|color| color.map(f32::from));
    let mut error = 0.0;
    let indices = std::array::from_fn(|texel| {
        let squared = |k: usize| -> f32 { (0..3).map(|c| (palette[k][c] - codes[texel][c]).powi(2)).sum() };
        let (mut index, mut least) = (0, squared(0));
        for k in 1..4 {
            let here = squared(k);
            if here < least {
                (index, least) = (k as u8, here);
            }
        }
        error += weights[texel] * least;
        index
    });
    (indices, error)
}

/// Ends whose first third comes nearest to one colour: what a flat block is stored as, for a third lies closer to most codes than an end does.
pub fn flat(color: [f32; 3]) -> [End; 2] {
    let near = block::nearest_end(color);
    let mut ends = [near; 2];
    let mut least = [f32::INFINITY; 3];
    for more in -2i32..=2 {
        for less in -2i32..=2 {
            let moved =
                |by: i32| [0, 1, 2].map(|c| (i32::from(near[c]) + by).clamp(0, if c == 1 { 63 } else { 31 }) as u8);
            let pair = [moved(more), moved(less)];
            let third = block::four_colors(pair)[2];
            for c in 0..3 {
                let off = (f32::from(third[c]) - color[c]).abs();
                if off < least[c] {
                    least[c] = off;
                    (ends[0][c], ends[1][c]) = (pair[0][c], pair[1][c]);
                }
            }
        }
    }
    ends
}

/// Ends in the order that decodes with four colours: the greater number first, and one of them a step off where they are the same.
pub fn ordered(ends: [End; 2]) -> [End; 2] {
    let [a, b] = ends.map(block::pack_end);
    match a.cmp(&b) {
        std::cmp::Ordering::Greater => ends,
        std::cmp::Ordering::Less => [ends[1], ends[0]],
        std::cmp::Ordering::Equal if a > 0 => [ends[0], block::unpack_end(a - 1)],
        std::cmp::Ordering::Equal => [block::unpack_end(1), ends[0]],
    }
}

/// Sum of squares, ends as stored and indices.
type Fit = (f32, [End; 2], [u8; 16]);

/// A block of four colours for 16 codes: ends along the principal axis, once refined by least squares, or those of the mean where that is closer.
pub fn four_color_block(codes: &Codes, weights: &Weights) -> Block {
    let try_ends = |ends: [End; 2]| -> Fit {
        let ends = ordered(ends);
        let (indices, error) = nearest(codes, weights, &block::four_colors(ends));
        (error, ends, indices)
    };
    let closer = |a: Fit, b: Fit| if b.0 < a.0 { b } else { a };
    let mut best = try_ends(extremes(codes, weights).map(block::nearest_end));
    if let Some(refined) = refined(codes, weights, &best.2) {
        best = closer(best, try_ends(refined.map(block::nearest_end)));
    }
    let total: f32 = weights.iter().sum();
    if total > 0.0 {
        let mean = |c: usize| codes.iter().zip(weights).map(|(code, weight)| code[c] * weight / total).sum();
        best = closer(best, try_ends(flat([0, 1, 2].map(mean))));
    }
    block::bc1(best.1, &best.2)
}
