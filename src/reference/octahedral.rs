//! CPU twin of `glsl/inc/octahedral.glsl`, in f64: unit vectors as two integers (Cigolle et al., "A Survey of Efficient Representations
//! for Independent Unit Vectors", JCGT 3(2), 2014).

use glam::{DVec2, DVec3};

/// Steps from 0 to 1.
fn half(bits: u32) -> f64 {
    f64::from((1u32 << (bits - 1)) - 1)
}

/// Turns the lower half of the octahedron outwards over the diagonals of the square, and back.
fn fold(p: DVec2) -> DVec2 {
    let folded = DVec2::ONE - DVec2::new(p.y, p.x).abs();
    DVec2::new(if p.x < 0.0 { -folded.x } else { folded.x }, if p.y < 0.0 { -folded.y } else { folded.y })
}

/// Codes of a vector that is not 0, `bits` (2 to 16) each; 0 to 2^bits - 2 occur.
pub fn encode(n: DVec3, bits: u32) -> [u32; 2] {
    let p = n.truncate() / n.abs().element_sum();
    let p = if n.z < 0.0 { fold(p) } else { p };
    let most = half(bits);
    ((p * most + 0.5).floor().clamp(DVec2::splat(-most), DVec2::splat(most)) + most).to_array().map(|c| c as u32)
}

/// The unit vector of a code; any two numbers of `bits` bits give one.
pub fn decode(code: [u32; 2], bits: u32) -> DVec3 {
    let most = half(bits);
    let p = code.map(|c| (f64::from(c) - most).min(most) / most);
    let p = DVec2::from_array(p);
    let z = 1.0 - p.x.abs() - p.y.abs();
    let p = if z < 0.0 { fold(p) } else { p };
    p.extend(z).normalize()
}

/// Radians between a vector and its decoded code, at most. With M steps from 0 to 1 a coordinate of the square is off by 1 / 2M; that moves a
/// point of the octahedron by (1, 1, 2) / 2M at most, sqrt(6) / 2M, and its faces are nowhere nearer to the eye than 1 / sqrt(3). The
/// last factor covers what a plane leaves out.
pub fn angle_bound(bits: u32) -> f64 {
    let most = half(bits);
    1.5 * 2f64.sqrt() / most * (1.0 + 1.0 / most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    const BITS: [u32; 3] = [8, 10, 16];

    fn check(code: [u32; 2], bits: u32) {
        let n = decode(code, bits);
        assert!(n.is_finite() && (n.length() - 1.0).abs() < 1e-15, "{code:?} in {bits} bits: {n}");
        let last = (1 << bits) - 2;
        // On the square's border two codes stand for one vector.
        if code.iter().all(|&c| 0 < c && c < last) {
            assert_eq!(encode(n, bits), code, "{bits} bits");
        }
    }

    #[test]
    fn l5_every_code_of_8_and_10_bits() {
        for bits in [8, 10] {
            for y in 0..1 << bits {
                (0..1 << bits).for_each(|x| check([x, y], bits));
            }
        }
    }

    #[test]
    fn l5_corners_axes_and_folds_of_16_bits() {
        let middle = (1 << 15) - 1;
        let rows = [0, 1, middle - 1, middle, middle + 1, 2 * middle - 1, 2 * middle, 2 * middle + 1, 12_345];
        for x in 0..1 << 16 {
            rows.iter().for_each(|&y| {
                check([x, y], 16);
                check([y, x], 16);
            });
            // Along the folds |x| + |y| = 1, and a step to either side.
            let across = u32::abs_diff(x, middle);
            for y in [middle + middle.saturating_sub(across), across.saturating_sub(1), (across + 1).min(2 * middle)] {
                check([x, y], 16);
            }
        }
    }

    #[test]
    fn axes_are_exact() {
        for bits in BITS {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                for n in [axis, -axis] {
                    assert_eq!(decode(encode(n, bits), bits), n, "{bits} bits");
                }
            }
        }
    }

    #[test]
    fn l5_angles_stay_within_the_bound_and_reach_for_it() {
        let mut random = Random::new(5);
        for bits in BITS {
            let mut largest = 0.0f64;
            for _ in 0..40_000 {
                let n = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                if n.length() > 0.1 {
                    let off = n.normalize().distance(decode(encode(n, bits), bits));
                    largest = largest.max(2.0 * (off * 0.5).asin());
                }
            }
            let bound = angle_bound(bits);
            assert!(largest <= bound && largest > 0.9 * bound, "{bits} bits: {largest:e}, at most {bound:e}");
        }
    }
}
