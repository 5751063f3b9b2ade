//! Arithmetic that decides membership in lists: the CPU's side of `glsl/inc/cull.glsl`, to the bit. Only operations that IEEE 754
//! rounds one way; nothing here may be fused or reordered, and Rust does neither.

use crate::shared::{DISTANCE_SLACK, FAR_LIMIT, SLOT_SLACK, TileGrid};

/// 1 / x for x in [1e-37, 1e37], within 4 ulp: a line through the exponent's bits, then three steps of Newton's iteration.
pub fn reciprocal(x: f32) -> f32 {
    let mut y = f32::from_bits(0x7ef3_11c7_u32.wrapping_sub(x.to_bits()));
    for _ in 0..3 {
        y *= 2.0 - x * y;
    }
    y
}

/// Nearest and farthest distance along the view axis, metres, of a position whose stored depth is `depth`, widened by what the two
/// may differ by.
pub fn distance_range(grid: &TileGrid, depth: f32) -> [f32; 2] {
    let (low, high) = if grid.perspective != 0 {
        let y = reciprocal((depth + grid.depth_scale).clamp(1e-37, 1e30));
        let d = grid.depth_offset * y;
        // 1 - e <= 1 / (1 + e), and 1 / (1 - e) <= 1 + 2 e up to a half.
        let e = grid.depth_slack * y;
        (d - d * e, if e < 0.5 { d + d * (e + e) } else { FAR_LIMIT })
    } else {
        let d = grid.depth_offset - depth * grid.depth_scale;
        let e = (grid.depth_slack + DISTANCE_SLACK) * grid.depth_scale;
        (d - e, d + e)
    };
    [low - low.abs() * DISTANCE_SLACK, (high + high.abs() * DISTANCE_SLACK).min(FAR_LIMIT)]
}

/// Slots a metre from `near` to `far`.
pub fn slots_a_metre(near: f32, far: f32, slots: u32) -> f32 {
    slots as f32 * reciprocal((far - near).max(1e-36))
}

/// The slot that holds distance `d`. It never descends as d grows, whatever is rounded, and that is all that a mask needs.
pub fn depth_slot(near: f32, slots_a_metre: f32, d: f32, slots: u32) -> u32 {
    ((d - near) * slots_a_metre).clamp(0.0, (slots - 1) as f32) as u32
}

/// Distances between which everything lies that [`depth_slot`] puts into slots `first` to `last`, of a power of two: its inverse, widened
/// by more than it may round. A slot is found from `(d - near) * slots * reciprocal(far - near)`, which is off by less than 2^-20 of
/// itself.
pub fn slot_distances([near, far]: [f32; 2], slots: u32, first: u32, last: u32) -> [f32; 2] {
    let step = (far - near) * (1.0 / slots as f32);
    let (a, b) = (first as f32 * step, (last + 1) as f32 * step);
    let (begin, end) = (near + a, near + b);
    let low = begin - (a * SLOT_SLACK + begin.abs() * DISTANCE_SLACK);
    let high = end + (b * SLOT_SLACK + end.abs() * DISTANCE_SLACK);
    [low, if last + 1 < slots { high } else { far }]
}

/// Bits `first` to `last` of a 64-bit mask.
pub fn slot_mask(first: u32, last: u32) -> u64 {
    (u64::MAX << first) & (u64::MAX >> (63 - last))
}

/// Signed distance of a point from the plane through the eye and an edge of the tile grid, `[tangent, normal across, normal along z,
/// offset]`.
pub fn edge_distance(edge: [f32; 4], across: f32, z: f32) -> f32 {
    (edge[1] * across + edge[2] * z) - edge[3]
}

/// Distance from a coordinate to an interval, 0 within.
pub fn interval_distance(low: f32, high: f32, x: f32) -> f32 {
    (low - x).max(x - high).max(0.0)
}

/// What lies between two edges from `near` to `far`, metres.
pub fn edge_interval(grid: &TileGrid, first: f32, last: f32, near: f32, far: f32) -> [f32; 2] {
    if grid.perspective == 0 {
        return [first.min(last), first.max(last)];
    }
    let [a, b, c, d] = [first * near, first * far, last * near, last * far];
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

/// False where the cone of a light cannot reach a box; texels as `glsl/inc/cull_cone.glsl` has them.
pub fn cone_reaches(cone: &[[f32; 4]], apex: [f32; 3], [x, y, distances]: [[f32; 2]; 3]) -> bool {
    let ([ax, ay, az, slack], [cosine, sine, ..]) = (cone[0], cone[1]);
    let half = [x[1] - x[0], y[1] - y[0], distances[1] - distances[0]].map(|size| size * 0.5);
    let center = [x[0] + x[1], y[0] + y[1], -(distances[0] + distances[1])].map(|sum| sum * 0.5);
    let v = [center[0] - apex[0], center[1] - apex[1], center[2] - apex[2]];
    let most = half[0].max(half[1].max(half[2]));
    let least = half[0].min(half[1].min(half[2]));
    let middle = (half[0] + half[1] + half[2]) - most - least;
    let radius = most + middle * 0.41422 + least * 0.31784;
    let c = [v[1] * az - v[2] * ay, v[2] * ax - v[0] * az, v[0] * ay - v[1] * ax];
    let across2 = (c[0] * c[0] + c[1] * c[1]) + c[2] * c[2];
    let along = (v[0] * ax + v[1] * ay) + v[2] * az;
    let reach = ((radius + slack) + along * sine) * 1.00001;
    !(cosine > 0.0 && (reach < 0.0 || (cosine * cosine) * across2 > reach * reach))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn reciprocal_is_within_four_ulp() {
        let mut random = Random::new(1);
        for _ in 0..200_000 {
            let x = (random.range(-85.0, 85.0)).exp() as f32;
            let exact = 1.0 / f64::from(x);
            let ulp = f64::from((exact as f32).next_up() - exact as f32);
            assert!((f64::from(reciprocal(x)) - exact).abs() <= 4.0 * ulp, "{x:e}");
        }
    }

    #[test]
    fn slots_never_descend_and_a_flat_tile_has_one() {
        let (near, far) = (1.0f32, 1.7f32);
        let scale = slots_a_metre(near, far, 32);
        let mut last = 0;
        for i in 0..=7000u16 {
            let slot = depth_slot(near, scale, 1.0 + f32::from(i) * 1e-4, 32);
            assert!(slot >= last && slot < 32);
            last = slot;
        }
        assert_eq!(last, 31);
        assert_eq!(depth_slot(2.0, slots_a_metre(2.0, 2.0, 32), 2.0, 32), 0);
        assert_eq!(depth_slot(-1e18, slots_a_metre(-1e18, 1e18, 64), 1e18, 64), 63);
    }

    #[test]
    fn distances_of_slots_hold_what_is_in_them() {
        let mut random = Random::new(3);
        let mut tightest = f32::INFINITY;
        for round in 0..200_000 {
            let near = if round % 3 == 0 { random.range(-50.0, 50.0) } else { random.range(-9.0, 9.0).exp() } as f32;
            let far = near + random.range(-20.0, 9.0).exp() as f32;
            let slots = if round % 2 == 0 { 32 } else { 64 };
            let scale = slots_a_metre(near, far, slots);
            let d = (near + random.unit_f64() as f32 * (far - near)).clamp(near, far);
            // On a boundary of slots, as far as floats go, every other time.
            let d = if round % 4 < 2 { (near + ((d - near) * scale).round() / scale).clamp(near, far) } else { d };
            let slot = depth_slot(near, scale, d, slots);
            let [low, high] = slot_distances([near, far], slots, slot, slot);
            assert!(low <= d && d <= high, "{near} {far}: {d} in slot {slot}, {low} to {high}");
            tightest = tightest.min((high - low) / ((far - near) / slots as f32).max(near.abs() * 1e-5));
        }
        assert!(tightest < 1.001, "{tightest}");
    }

    #[test]
    fn distances_contain_the_exact_one() {
        let mut random = Random::new(2);
        let perspective = TileGrid { perspective: 1, depth_offset: 0.05, depth_slack: 1e-6, ..TileGrid::default() };
        let far = TileGrid { depth_offset: 0.05 * 50.0 / 49.95, depth_scale: 0.05 / 49.95, ..perspective };
        let parallel = TileGrid { depth_offset: 9.0, depth_scale: 10.0, depth_slack: 1e-6, ..TileGrid::default() };
        for _ in 0..100_000 {
            let depth = random.unit_f64() as f32;
            for slip in [-1e-6, 0.0, 1e-6] {
                let (stored, depth) = (depth, f64::from(depth) + slip);
                for grid in [perspective, far] {
                    let exact = f64::from(grid.depth_offset) / (depth + f64::from(grid.depth_scale)).max(1e-30);
                    let [low, high] = distance_range(&grid, stored).map(f64::from);
                    assert!(low <= exact && exact.min(1e18) <= high, "{stored:e} {exact} {low} {high}");
                }
                let [low, high] = distance_range(&parallel, stored).map(f64::from);
                assert!(low <= 9.0 - depth * 10.0 && 9.0 - depth * 10.0 <= high);
            }
        }
    }

    #[test]
    fn masks_at_the_ends_of_words() {
        assert_eq!(slot_mask(0, 0), 1);
        assert_eq!(slot_mask(31, 32), 3 << 31);
        assert_eq!(slot_mask(0, 63), u64::MAX);
        assert_eq!(slot_mask(63, 63), 1 << 63);
    }
}
