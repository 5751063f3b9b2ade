//! A ray and where it meets a box or a triangle, in f64.
//!
//! The intersection is that of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2013): the edge
//! function of a shared edge has the same bits, but for its sign, in both triangles, so no ray passes between them. A
//! tolerance of 1e-12 on top closes the gap between meshes whose transforms round differently.

use std::ops::RangeInclusive;

use glam::DVec3;

/// Relative to the sum of the products in the three edge functions; f64 rounds each at 1.1e-16.
const EDGE_TOLERANCE: f64 = 1e-12;

/// A piece of a line: `origin + t * direction` for `t` in `min..=max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: DVec3,
    /// Need not be of unit length, must not be zero.
    pub direction: DVec3,
    /// May be negative.
    pub min: f64,
    /// May be infinite.
    pub max: f64,
}

/// A ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Index into the triangles that the hierarchy was built from.
    pub triangle: u32,
    /// Along the ray, in lengths of its direction.
    pub t: f64,
    /// Barycentric weights of the three corners: none negative, sum 1.
    pub weights: DVec3,
}

/// Barycentric weights of the point where a line meets a triangle's plane, inside the triangle or not. Not finite where
/// the line lies along the plane.
pub fn plane_weights(origin: DVec3, direction: DVec3, corners: &[DVec3; 3]) -> DVec3 {
    let areas = Sheared::new(origin, direction).project(corners).areas;
    areas / areas.element_sum()
}

/// A ray turned and sheared so that it runs along +z from the origin.
#[derive(Debug, Clone)]
pub struct Sheared {
    origin: DVec3,
    /// Which coordinates become x, y and z.
    axes: [usize; 3],
    shear: DVec3,
    inverse: DVec3,
}

struct Projected {
    /// Twice the signed areas opposite each corner.
    areas: DVec3,
    /// Sum of the magnitudes of the six products in `areas`: what they round relative to.
    magnitude: f64,
    /// The corners' distances along the ray.
    distances: DVec3,
}

impl Sheared {
    /// For the line `origin + t * direction`.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        // 1 / 0 would make 0 * inf = NaN where the origin lies in a slab's plane.
        let inverse = direction.map(|d| if d.abs() < 1e-300 { 1e300_f64.copysign(d) } else { 1.0 / d });
        let shear = DVec3::new(direction[x], direction[y], 1.0) / direction[z];
        Self { origin, axes: [x, y, z], shear, inverse }
    }

    /// Where the ray enters the box `min` to `max`, if it is inside it anywhere in `within`. A box must have some
    /// thickness.
    pub fn enter(&self, min: DVec3, max: DVec3, within: RangeInclusive<f64>) -> Option<f64> {
        let t0 = (min - self.origin) * self.inverse;
        let t1 = (max - self.origin) * self.inverse;
        let near = t0.min(t1).max_element();
        let far = t0.max(t1).min_element();
        // Either distance carries three roundings of 1.1e-16.
        let far = far + far.abs() * 1e-15;
        (near <= far && near <= *within.end() && far >= *within.start()).then_some(near)
    }

    fn project(&self, corners: &[DVec3; 3]) -> Projected {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            DVec3::new(p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], self.shear.z * p[z])
        });
        let edge = |p: DVec3, q: DVec3| (p.x * q.y - p.y * q.x, (p.x * q.y).abs() + (p.y * q.x).abs());
        let ((u, u_size), (v, v_size), (w, w_size)) = (edge(c, b), edge(a, c), edge(b, a));
        Projected {
            areas: DVec3::new(u, v, w),
            magnitude: u_size + v_size + w_size,
            distances: DVec3::new(a.z, b.z, c.z),
        }
    }

    /// Where the line meets the triangle, at any `t`; `triangle` goes into the answer.
    pub fn cross(&self, corners: &[DVec3; 3], triangle: u32) -> Option<Crossing> {
        let Projected { areas, magnitude, distances } = self.project(corners);
        let tolerance = magnitude * EDGE_TOLERANCE;
        let areas = if areas.min_element() >= -tolerance {
            areas.max(DVec3::ZERO)
        } else if areas.max_element() <= tolerance {
            (-areas).max(DVec3::ZERO)
        } else {
            return None;
        };
        let total = areas.element_sum();
        // A triangle seen along its plane: its area is rounding.
        if total <= 3.0 * tolerance {
            return None;
        }
        let weights = areas / total;
        Some(Crossing { triangle, t: weights.dot(distances), weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::new(0.0, 0.0, -2.0), DVec3::new(4.0, 0.0, -2.0), DVec3::new(0.0, 4.0, -2.0)];

    #[test]
    fn weights_and_distance_are_those_of_the_point() {
        for (origin, direction) in [
            (DVec3::ZERO, DVec3::new(0.5, 0.25, -1.0)),
            (DVec3::new(1.0, 0.5, -9.0), DVec3::Z * 7.0),
            (DVec3::new(-99.0, 0.5, -3.0), DVec3::new(100.0, 0.0, 1.0)),
        ] {
            let crossing = Sheared::new(origin, direction).cross(&TRIANGLE, 7).expect("a hit");
            let from_weights = (0..3).map(|k| TRIANGLE[k] * crossing.weights[k]).sum::<DVec3>();
            assert!((from_weights - DVec3::new(1.0, 0.5, -2.0)).length() < 1e-12, "{from_weights}");
            assert!((origin + direction * crossing.t - from_weights).length() < 1e-12);
            assert_eq!(crossing.triangle, 7);
        }
    }

    #[test]
    fn plane_weights_reach_outside() {
        let weights = plane_weights(DVec3::new(-1.0, 8.0, 0.0), DVec3::NEG_Z, &TRIANGLE);
        assert!((weights - DVec3::new(-0.75, -0.25, 2.0)).length() < 1e-12, "{weights}");
        let outside = Sheared::new(DVec3::new(-1.0, 8.0, 0.0), DVec3::NEG_Z);
        assert_eq!(outside.cross(&TRIANGLE, 0), None);
    }

    #[test]
    fn a_ray_through_a_shared_edge_or_corner_hits() {
        let mirrored = TRIANGLE.map(|p| DVec3::new(4.0 - p.x, 4.0 - p.y, p.z));
        for k in 0..=64 {
            let s = k as f64 / 64.0;
            let target = TRIANGLE[1].lerp(TRIANGLE[2], s);
            let line = Sheared::new(DVec3::new(0.3, 0.1, 5.0), target - DVec3::new(0.3, 0.1, 5.0));
            assert!(line.cross(&TRIANGLE, 0).or(line.cross(&mirrored, 1)).is_some(), "{s}");
        }
    }

    #[test]
    fn a_triangle_seen_along_its_plane_is_not_hit() {
        let line = Sheared::new(DVec3::new(-1.0, 1.0, -2.0), DVec3::X);
        assert_eq!(line.cross(&TRIANGLE, 0), None);
    }

    #[test]
    fn a_flat_box_is_entered() {
        let line = Sheared::new(DVec3::new(0.0, 0.5, 0.0), DVec3::NEG_Z);
        let thickness = DVec3::splat(1e-12);
        let (min, max) = (DVec3::new(0.0, 0.0, -1.0) - thickness, DVec3::new(0.0, 1.0, -1.0) + thickness);
        assert!(line.enter(min, max, 0.0..=9.0).is_some());
        assert_eq!(line.enter(min, max, 0.0..=0.5), None);
        assert_eq!(line.enter(min + DVec3::X, max + DVec3::X, 0.0..=9.0), None);
    }
}
