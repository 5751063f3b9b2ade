//! Mip levels, made on the CPU so that the device and the reference filter the same texels.
//!
//! Each level halves its parent, rounding down, by a box that covers it exactly: two texels where the parent's size is
//! even, three with sliding weights where it is odd, so that every texel counts alike and the mean is kept (S. Guthe
//! and P. Heckbert, "Non-Power-of-Two Mipmap Creation", NVIDIA, 2005). Levels follow from unrounded parents.

use std::sync::LazyLock;

use super::Image;
use crate::math::srgb;

/// All levels of a picture, the largest first, down to one texel.
#[derive(Debug, Clone, Default)]
pub struct MipChain {
    /// Level 0 is the picture itself.
    pub levels: Vec<Level>,
}

/// One level, rows from the top.
#[derive(Debug, Clone, Default)]
pub struct Level {
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// `width * height * 4` bytes, encoded as the picture is.
    pub rgba8: Vec<u8>,
}

/// A level before rounding: linear RGBA, 0 to 1.
struct Plane {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

/// Up to three parent texels along one axis and their weights.
#[derive(Clone, Copy)]
struct Taps {
    first: usize,
    count: usize,
    weights: [f32; 3],
}

/// All levels of `image`, which has at least one texel. `srgb`: colours are averaged as light, alpha always as it is.
pub fn chain(image: &Image, srgb: bool) -> MipChain {
    let mut levels = vec![Level { width: image.width, height: image.height, rgba8: image.rgba8.clone() }];
    let (mut width, mut height) = (image.width as usize, image.height as usize);
    let linear = linear_table(srgb);
    let source = |x: usize, y: usize| {
        let at = (y * image.width as usize + x) * 4;
        let texel = &image.rgba8[at..at + 4];
        [linear[texel[0] as usize], linear[texel[1] as usize], linear[texel[2] as usize], f32::from(texel[3]) / 255.0]
    };
    let mut parent: Option<Plane> = None;
    while width > 1 || height > 1 {
        let plane = match &parent {
            None => halve(width, height, source),
            Some(plane) => halve(width, height, |x, y| plane.texels[y * plane.width + x]),
        };
        (width, height) = (plane.width, plane.height);
        levels.push(round(&plane, srgb));
        parent = Some(plane);
    }
    MipChain { levels }
}

fn linear_table(srgb: bool) -> [f32; 256] {
    std::array::from_fn(|code| if srgb { srgb_to_linear(code as u8) as f32 } else { code as f32 / 255.0 })
}

/// Taps of texel `index` of a level whose parent has `size` texels along the axis.
fn taps(size: usize, index: usize) -> Taps {
    if size == 1 {
        return Taps { first: 0, count: 1, weights: [1.0, 0.0, 0.0] };
    }
    if size.is_multiple_of(2) {
        return Taps { first: 2 * index, count: 2, weights: [0.5, 0.5, 0.0] };
    }
    // The texel covers size / half parent texels from index * size / half on.
    let (half, n) = ((size / 2) as f32, size as f32);
    let i = index as f32;
    Taps { first: 2 * index, count: 3, weights: [(half - i) / n, half / n, (i + 1.0) / n] }
}

fn halve(width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 4]) -> Plane {
    let (out_width, out_height) = ((width / 2).max(1), (height / 2).max(1));
    let columns: Vec<Taps> = (0..out_width).map(|x| taps(width, x)).collect();
    let mut texels = Vec::with_capacity(out_width * out_height);
    for y in 0..out_height {
        let rows = taps(height, y);
        for column in &columns {
            let mut sum = [0.0f32; 4];
            for (dy, row_weight) in rows.weights.iter().enumerate().take(rows.count) {
                for (dx, column_weight) in column.weights.iter().enumerate().take(column.count) {
                    let weight = row_weight * column_weight;
                    let value = texel(column.first + dx, rows.first + dy);
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += weight * value;
                    }
                }
            }
            texels.push(sum);
        }
    }
    Plane { width: out_width, height: out_height, texels }
}

fn round(plane: &Plane, srgb: bool) -> Level {
    let unorm = |x: f32| (x * 255.0 + 0.5) as u8;
    let color = |x: f32| if srgb { linear_to_srgb(f64::from(x)) } else { unorm(x) };
    let rgba8 = plane.texels.iter().flat_map(|[r, g, b, a]| [color(*r), color(*g), color(*b), unorm(*a)]).collect();
    Level { width: plane.width as u32, height: plane.height as u32, rgba8 }
}

/// Light, 0 to 1, of an sRGB code.
pub fn srgb_to_linear(code: u8) -> f64 {
    static TABLE: LazyLock<[f64; 256]> =
        LazyLock::new(|| std::array::from_fn(|code| srgb::decode(code as f64 / 255.0)));
    TABLE[code as usize]
}

/// The sRGB code nearest to the encoding of `linear`; less than 0 and NaN give 0, more than 1 gives 255.
pub fn linear_to_srgb(linear: f64) -> u8 {
    // Light at which the encoding passes from one code to the next.
    static STEPS: LazyLock<[f64; 255]> =
        LazyLock::new(|| std::array::from_fn(|code| srgb::decode((code as f64 + 0.5) / 255.0)));
    STEPS.partition_point(|step| *step <= linear) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
        let rgba8 = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| texel(x, y)).collect();
        Image { name: String::new(), width, height, rgba8 }
    }

    #[test]
    fn codes_survive_the_way_through_light() {
        for code in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(code)), code);
        }
        assert_eq!([linear_to_srgb(-1.0), linear_to_srgb(f64::NAN), linear_to_srgb(9.0)], [0, 0, 255]);
        assert!((srgb_to_linear(188) - 0.5029).abs() < 1e-4);
        assert_eq!(linear_to_srgb(0.5), 188);
    }

    #[test]
    fn a_constant_picture_stays_constant() {
        for (width, height, sizes) in [
            (5, 3, vec![(5, 3), (2, 1), (1, 1)]),
            (7, 1, vec![(7, 1), (3, 1), (1, 1)]),
            (1, 6, vec![(1, 6), (1, 3), (1, 1)]),
            (1, 1, vec![(1, 1)]),
        ] {
            for srgb in [false, true] {
                let chain = chain(&image(width, height, |_, _| [200, 13, 255, 77]), srgb);
                assert_eq!(chain.levels.iter().map(|l| (l.width, l.height)).collect::<Vec<_>>(), sizes);
                for level in &chain.levels {
                    assert_eq!(level.rgba8.len(), (level.width * level.height * 4) as usize);
                    assert!(level.rgba8.chunks_exact(4).all(|t| t == [200, 13, 255, 77]), "{width}x{height}");
                }
            }
        }
    }

    #[test]
    fn every_texel_counts_alike() {
        for size in 2..40 {
            let mut weight = vec![0.0f32; size];
            for index in 0..size / 2 {
                let taps = taps(size, index);
                assert!((taps.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                for (i, w) in taps.weights.iter().enumerate().take(taps.count) {
                    weight[taps.first + i] += w;
                }
            }
            let expected = (size / 2) as f32 / size as f32;
            assert!(weight.iter().all(|w| (w - expected).abs() < 1e-6), "{size}: {weight:?}");
        }
    }

    #[test]
    fn the_mean_is_kept_in_light() {
        let picture = image(13, 11, |x, y| [(x * 19) as u8, (y * 23) as u8, ((x * y) % 256) as u8, (x * 16) as u8]);
        let mean = |level: &Level, channel: usize, light: bool| {
            let values = level.rgba8.chunks_exact(4).map(|t| t[channel]);
            let sum: f64 = values.map(|v| if light { srgb_to_linear(v) } else { f64::from(v) / 255.0 }).sum();
            sum / f64::from(level.width * level.height)
        };
        for srgb in [false, true] {
            let chain = chain(&picture, srgb);
            let last = chain.levels.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            for channel in 0..4 {
                let light = srgb && channel < 3;
                let (first, last) = (mean(&chain.levels[0], channel, light), mean(last, channel, light));
                // Half a code of the encoding, whose slope in light is at most 2.28.
                let slope = if light { 2.28 } else { 1.0 };
                assert!((first - last).abs() < slope * 0.5 / 255.0 + 1e-5, "{channel}");
            }
        }
        let half = chain(&image(2, 1, |x, _| [255 * x as u8; 4]), true);
        assert_eq!(half.levels[1].rgba8, [188, 188, 188, 128]);
    }
}
