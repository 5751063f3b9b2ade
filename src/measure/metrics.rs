//! Measures of the difference between two pictures.
//!
//! Errors are over red, green and blue; alpha is not compared. The relative error of a pixel is the largest over its
//! channels of `|a - b| / max(|ref|, 1e-3 * mean |ref|)` (DESIGN.md, section 5), the mean taken over every finite
//! channel of the whole reference picture, masked or not. A channel that is not finite, in either picture, is an
//! infinite error.

/// Share of the reference's mean magnitude that a relative error is measured against at least.
const RELATIVE_FLOOR: f64 = 1e-3;

/// Two pictures compared. No compared pixel at all is an infinite error: a comparison of nothing shows nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Root of the mean over pixels and channels of the squared difference.
    pub rmse: f64,
    /// Largest difference of a channel.
    pub max_abs: f64,
    /// Mean over pixels of the relative error.
    pub mean_relative: f64,
    /// Largest relative error of a pixel.
    pub max_relative: f64,
    /// Pixels of which any bit of red, green or blue differs.
    pub differing_pixels: usize,
    /// Pixels compared.
    pub pixels: usize,
}

/// Compares whole pictures. Where one is longer, the pixels that the other lacks are infinite errors.
pub fn compare(reference: &[[f64; 4]], other: &[[f64; 4]]) -> Difference {
    compare_where(reference, other, |_| true)
}

/// Compares the pixels whose `mask` is true; pixels beyond the mask's end are compared too.
pub fn compare_masked(reference: &[[f64; 4]], other: &[[f64; 4]], mask: &[bool]) -> Difference {
    compare_where(reference, other, |pixel| mask.get(pixel).copied().unwrap_or(true))
}

/// The same picture in f64, exactly.
pub fn widen(picture: &[[f32; 4]]) -> Vec<[f64; 4]> {
    picture.iter().map(|pixel| pixel.map(f64::from)).collect()
}

/// True for pixels whose 3 x 3 neighbourhood has one id; beyond the picture's edges there are no neighbours. Rows of
/// `width` pixels; all false where `surface_id` has another length than `width * height`.
///
/// The id must change wherever the picture may have an edge: the reference renderer's smooth groups do, but for a group
/// that hides a part of itself.
pub fn interior_mask(surface_id: &[u32], width: u32, height: u32) -> Vec<bool> {
    let (width, height) = (width as usize, height as usize);
    if surface_id.len() != width * height {
        return vec![false; surface_id.len()];
    }
    let uniform = |x: usize, y: usize| {
        let id = surface_id[y * width + x];
        let mut rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        let columns = x.saturating_sub(1)..=(x + 1).min(width - 1);
        rows.all(|row| columns.clone().all(|column| surface_id[row * width + column] == id))
    };
    (0..surface_id.len()).map(|pixel| uniform(pixel % width, pixel / width)).collect()
}

fn compare_where(reference: &[[f64; 4]], other: &[[f64; 4]], compared: impl Fn(usize) -> bool) -> Difference {
    let floor = RELATIVE_FLOOR * mean_magnitude(reference);
    let mut difference =
        Difference { rmse: 0.0, max_abs: 0.0, mean_relative: 0.0, max_relative: 0.0, differing_pixels: 0, pixels: 0 };
    for pixel in (0..reference.len().max(other.len())).filter(|&pixel| compared(pixel)) {
        // NaN stands for a pixel that is not there; its error is infinite like any NaN's.
        let a = reference.get(pixel).copied().unwrap_or([f64::NAN; 4]);
        let b = other.get(pixel).copied().unwrap_or([f64::NAN; 4]);
        let differs = pixel >= reference.len().min(other.len()) || (0..3).any(|c| a[c].to_bits() != b[c].to_bits());
        let mut relative = 0.0f64;
        for (&a, &b) in a.iter().zip(&b).take(3) {
            let error = absolute_error(a, b);
            difference.max_abs = difference.max_abs.max(error);
            difference.rmse += error * error;
            relative = relative.max(relative_error(error, a, floor));
        }
        difference.mean_relative += relative;
        difference.max_relative = difference.max_relative.max(relative);
        difference.differing_pixels += usize::from(differs);
        difference.pixels += 1;
    }
    if difference.pixels == 0 {
        let none = f64::INFINITY;
        return Difference { rmse: none, max_abs: none, mean_relative: none, max_relative: none, ..difference };
    }
    let pixels = difference.pixels as f64;
    difference.rmse = (difference.rmse / (3.0 * pixels)).sqrt();
    difference.mean_relative /= pixels;
    difference
}

fn absolute_error(reference: f64, other: f64) -> f64 {
    if reference.is_finite() && other.is_finite() { (reference - other).abs() } else { f64::INFINITY }
}

fn relative_error(error: f64, reference: f64, floor: f64) -> f64 {
    // 0 / 0 is no error, and inf / inf is one.
    if error == 0.0 || error.is_infinite() { error } else { error / reference.abs().max(floor) }
}

fn mean_magnitude(picture: &[[f64; 4]]) -> f64 {
    let finite = picture.iter().flat_map(|pixel| &pixel[..3]).filter(|channel| channel.is_finite());
    let (sum, count) = finite.fold((0.0, 0usize), |(sum, count), channel| (sum + channel.abs(), count + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Vec<[f64; 4]> {
        (0..12).map(|i| [0.5 + f64::from(i), 1.0, 1e-3 * f64::from(i), 1.0]).collect()
    }

    #[test]
    fn a_picture_equals_itself() {
        let zero = Difference {
            rmse: 0.0,
            max_abs: 0.0,
            mean_relative: 0.0,
            max_relative: 0.0,
            differing_pixels: 0,
            pixels: 12,
        };
        assert_eq!(compare(&picture(), &picture()), zero);
        let black = vec![[0.0; 4]; 12];
        assert_eq!(compare(&black, &black), zero);
    }

    #[test]
    fn one_bit_is_seen_in_every_channel() {
        for (pixel, channel) in (0..12).flat_map(|p| (0..3).map(move |c| (p, c))) {
            let mut other = picture();
            let bits = other[pixel][channel].to_bits();
            other[pixel][channel] = f64::from_bits(bits ^ 1);
            let difference = compare(&picture(), &other);
            assert_eq!(difference.differing_pixels, 1);
            assert!(difference.max_abs > 0.0 && difference.max_relative > 0.0, "{pixel} {channel}: {difference:?}");
            let alone: Vec<bool> = (0..12).map(|p| p == pixel).collect();
            let others: Vec<bool> = alone.iter().map(|m| !m).collect();
            assert_eq!(compare_masked(&picture(), &other, &alone).differing_pixels, 1);
            assert_eq!(compare_masked(&picture(), &other, &others).max_abs, 0.0);
        }
    }

    #[test]
    fn the_sign_of_zero_is_a_bit() {
        let difference = compare(&[[0.0; 4]], &[[0.0, -0.0, 0.0, 0.0]]);
        assert_eq!((difference.differing_pixels, difference.max_abs), (1, 0.0));
    }

    #[test]
    fn what_is_not_finite_is_an_infinite_error() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut other = picture();
            other[7][1] = bad;
            for (a, b) in [(picture(), other.clone()), (other.clone(), picture()), (other.clone(), other)] {
                let d = compare(&a, &b);
                for error in [d.rmse, d.max_abs, d.mean_relative, d.max_relative] {
                    assert_eq!(error, f64::INFINITY, "{d:?}");
                }
            }
        }
    }

    #[test]
    fn values_computed_by_hand() {
        // Mean magnitude 12 / 6 = 2, so the floor is 0.002.
        let reference = [[4.0, 4.0, 4.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
        let other = [[4.0, 5.0, 4.0, 0.0], [0.0, 0.0, 0.001, 1.0]];
        let d = compare(&reference, &other);
        assert!((d.rmse - ((1.0 + 1e-6f64) / 6.0).sqrt()).abs() < 1e-15);
        assert!((d.max_relative - 0.5).abs() < 1e-15 && (d.mean_relative - 0.375).abs() < 1e-15);
        assert_eq!((d.max_abs, d.differing_pixels, d.pixels), (1.0, 2, 2));
        // A mask leaves a pixel's relative error as it was.
        assert!((compare_masked(&reference, &other, &[false, true]).max_relative - 0.5).abs() < 1e-15);
    }

    #[test]
    fn nothing_and_missing_pixels_are_no_success() {
        assert_eq!(compare(&[], &[]).max_relative, f64::INFINITY);
        assert_eq!(compare_masked(&picture(), &picture(), &[false; 12]).rmse, f64::INFINITY);
        let short = compare(&picture(), &picture()[..11]);
        assert_eq!((short.max_abs, short.differing_pixels, short.pixels), (f64::INFINITY, 1, 12));
    }

    #[test]
    fn widening_keeps_every_bit() {
        let narrow = [[0.1f32, -0.0, f32::MIN_POSITIVE, 1e30]];
        let wide = widen(&narrow);
        assert_eq!(wide[0].map(|x| (x as f32).to_bits()), narrow[0].map(f32::to_bits));
    }

    #[test]
    fn the_interior_is_one_surface() {
        #[rustfmt::skip]
        let ids = [
            1, 1, 1, 1, 2,
            1, 1, 1, 1, 2,
            1, 1, 1, 1, 1,
            3, 1, 1, 1, 1,
        ];
        #[rustfmt::skip]
        let interior = [
            1, 1, 1, 0, 0,
            1, 1, 1, 0, 0,
            0, 0, 1, 0, 0,
            0, 0, 1, 1, 1,
        ];
        assert_eq!(interior_mask(&ids, 5, 4), interior.map(|i| i == 1));
        assert_eq!(interior_mask(&[7], 1, 1), [true]);
        assert_eq!(interior_mask(&ids, 5, 3), [false; 20]);
        assert_eq!(interior_mask(&[], 0, 0), [false; 0]);
    }
}
