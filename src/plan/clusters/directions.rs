//! Directions that clusters tell normals apart by (O. Olsson, M. Billeter, U. Assarsson, HPG 2012, section 3.2): cells of the octahedron's
//! square, which codes of the G-buffer fall into by integers alone, and bounds of the normals of each.

use glam::{DVec2, DVec3};

/// Bits of a direction, most first: the plan takes fewer where lists of more clusters do not fit.
pub(super) const BITS: [u32; 2] = [6, 4];

/// Steps along each side of a cell at which its normals are looked at.
const STEPS: u32 = 64;

/// Beside what lies between two steps: codes are decoded in f32.
const DECODE_SLACK: f64 = 1e-5;

/// The unit vector of a point of the square, [-1, 1] along each side.
fn unfolded(p: DVec2) -> DVec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let folded = DVec2::new((1.0 - p.y.abs()).copysign(p.x), (1.0 - p.x.abs()).copysign(p.y));
    (if z < 0.0 { folded } else { p }).extend(z).normalize()
}

/// Bits that a code has beyond those of its direction.
pub(super) fn shift(normal_bits: u32, direction_bits: u32) -> u32 {
    normal_bits - direction_bits / 2
}

/// Least and greatest coordinate of the normals of each direction, two texels each, rounded outward.
///
/// From one step to the next a point of the square moves by h along each side, so from the nearest step by h / 2; that moves the point of
/// the octahedron by (1, 1, 2) h / 2 at most, sqrt(6) h / 2, and none of its points is nearer to the eye than 1 / sqrt(3).
pub(super) fn table(normal_bits: u32, direction_bits: u32) -> Vec<[f32; 4]> {
    let (across, shift) = (1 << (direction_bits / 2), shift(normal_bits, direction_bits));
    let most = f64::from((1u32 << (normal_bits - 1)) - 1);
    let codes = |cell: u32| {
        let first = cell << shift;
        let last = first + (1 << shift) - 1;
        [first, last].map(|code| (f64::from(code) - most).min(most) / most)
    };
    let of = |[u, v]: [u32; 2]| {
        let ([left, right], [low, high]) = (codes(u), codes(v));
        let at = |step: u32, first: f64, last: f64| first + (last - first) * f64::from(step) / f64::from(STEPS);
        let points =
            (0..=STEPS).flat_map(|y| (0..=STEPS).map(move |x| DVec2::new(at(x, left, right), at(y, low, high))));
        let (least, greatest) = points.map(unfolded).fold((DVec3::MAX, DVec3::MIN), |(a, b), n| (a.min(n), b.max(n)));
        let step = (right - left).max(high - low) / f64::from(STEPS);
        let slack = 0.5 * 18f64.sqrt() * step + DECODE_SLACK;
        let outward =
            |n: DVec3, by: f64| (n + by).clamp(DVec3::splat(-1.0 - DECODE_SLACK), DVec3::splat(1.0 + DECODE_SLACK));
        let (a, b) = (outward(least, -slack).to_array(), outward(greatest, slack).to_array());
        let texel = |n: [f64; 3], to: fn(f32) -> f32| {
            let [x, y, z] = n.map(|x| to(x as f32));
            [x, y, z, 0.0]
        };
        [texel(a, f32::next_down), texel(b, f32::next_up)]
    };
    (0..across).flat_map(|v| (0..across).flat_map(move |u| of([u, v]))).collect()
}
