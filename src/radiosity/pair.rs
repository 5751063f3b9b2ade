//! The exchange of two triangles with nothing in between: by the closed form where they touch or are near, by points where they are not.

use glam::DVec3;

use super::kernel;

/// Farther than so many times the sum of both radii one point of each is enough: the relative error falls with the square of the distance.
const ONE_POINT: f64 = 8.0;
/// Farther than that the seven points of a rule of degree five are: it falls with the sixth power.
const SEVEN_POINTS: f64 = 1.5;
/// Barycentric corners and weights of the rule (J. Radon, "Zur mechanischen Kubatur", 1948; P. Hammer, O. Marlowe, A. Stroud, 1956): the middle, and
/// two rings of three.
const MIDDLE: f64 = 0.225;
const RINGS: [[f64; 2]; 2] =
    [[0.470_142_064_105_115_1, 0.132_394_152_788_506_2], [0.101_286_507_323_456_3, 0.125_939_180_544_827_1]];

/// A triangle with what is asked of it again and again.
#[derive(Debug, Clone, Copy)]
pub struct Facet {
    corners: [DVec3; 3],
    middle: DVec3,
    normal: DVec3,
    area: f64,
    radius: f64,
}

impl Facet {
    /// Of corners counter-clockwise from the front.
    pub fn new(corners: &[DVec3; 3]) -> Self {
        let [a, b, c] = *corners;
        let middle = (a + b + c) / 3.0;
        let doubled = (b - a).cross(c - a);
        let radius = corners.iter().map(|p| p.distance_squared(middle)).fold(0.0, f64::max).sqrt();
        Self { corners: *corners, middle, normal: doubled.normalize_or_zero(), area: 0.5 * doubled.length(), radius }
    }

    /// Square metres.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Points and their shares of the area.
    fn points(&self) -> [(DVec3, f64); 7] {
        let [a, b, c] = self.corners;
        let mut points = [(self.middle, MIDDLE); 7];
        for (ring, [side, weight]) in RINGS.iter().enumerate() {
            for (k, [p, q, r]) in [[a, b, c], [b, c, a], [c, a, b]].into_iter().enumerate() {
                points[1 + 3 * ring + k] = (p * (1.0 - 2.0 * side) + (q + r) * *side, *weight);
            }
        }
        points
    }

    /// All corners lie in front of the other's plane.
    fn is_before(&self, other: &Self) -> bool {
        let slack = 1e-9 * (self.radius + other.radius);
        self.corners.iter().all(|p| (*p - other.middle).dot(other.normal) > -slack)
    }
}

/// Square metres: light that leaves one and meets the other; relative error under 1e-3 at any distance.
pub fn exchange(t: &Facet, u: &Facet) -> f64 {
    let distance = t.middle.distance(u.middle);
    let reach = t.radius + u.radius;
    if distance > ONE_POINT * reach {
        return point_kernel(t.middle, t.normal, u.middle, u.normal) * t.area * u.area;
    }
    // A plane that cuts the other triangle leaves an integrand with an edge.
    if distance > SEVEN_POINTS * reach && t.is_before(u) && u.is_before(t) {
        let others = u.points();
        let sum: f64 = t
            .points()
            .iter()
            .flat_map(|(p, w)| others.iter().map(move |(q, v)| w * v * point_kernel(*p, t.normal, *q, u.normal)))
            .sum();
        return sum * t.area * u.area;
    }
    kernel::exchange(&t.corners, &u.corners)
}

/// Form factor over area between two small pieces, 1 / m^2.
pub fn point_kernel(p: DVec3, n: DVec3, q: DVec3, m: DVec3) -> f64 {
    let way = q - p;
    let squared = way.length_squared();
    let cosines = n.dot(way).max(0.0) * (-m.dot(way)).max(0.0);
    if cosines > 0.0 { cosines / (std::f64::consts::PI * squared * squared) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// R2: whichever rule a distance chooses, it agrees with the closed form where that still has its digits.
    #[test]
    fn r2_every_rule_agrees_with_the_closed_form() {
        let mut random = Random::new(2);
        let mut three = || DVec3::new(random.unit_f64(), random.unit_f64(), random.unit_f64()) - 0.5;
        let mut worst: [f64; 3] = [0.0; 3];
        for k in 0..600 {
            let corners: [DVec3; 3] = [three(), three(), three()];
            let distance = 10f64.powf(-0.3 + 1.5 * f64::from(k) / 600.0);
            let place = three().normalize() * distance;
            let (turn, size) =
                (glam::DQuat::from_axis_angle(three().normalize(), 3.0 * three().x), 0.3 + three().y.abs());
            let other: [DVec3; 3] = [three(), three(), three()].map(|p| place + turn * p * size);
            let (t, u) = (Facet::new(&corners), Facet::new(&other));
            let right = kernel::exchange(&corners, &other);
            // What a grazing plane leaves is small and worth little.
            let scale = t.area * u.area / (std::f64::consts::PI * distance * distance);
            let rule = if t.middle.distance(u.middle) > ONE_POINT * (t.radius + u.radius) {
                2
            } else {
                usize::from(t.middle.distance(u.middle) > SEVEN_POINTS * (t.radius + u.radius))
            };
            worst[rule] = worst[rule].max((exchange(&t, &u) - right).abs() / scale);
        }
        println!("closed form {:.1e}, seven points {:.1e}, one point {:.1e}", worst[0], worst[1], worst[2]);
        assert!(worst[0] < 1e-9 && worst[1] < 1e-3 && worst[2] < 4e-3, "{worst:?}");
    }

    /// R2: squares that face each other from 0.1 to 1000 of their sizes.
    #[test]
    fn r2_far_squares_keep_their_digits() {
        for distance in [0.1f64, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0] {
            let square = |z: f64, up: f64| -> [Facet; 2] {
                let p = |x: f64, y: f64| DVec3::new(x, y * up, z);
                [[p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0)], [p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]]
                    .map(|t| Facet::new(&t))
            };
            let (one, mut other) = (square(0.0, 1.0), square(distance, 1.0));
            for facet in &mut other {
                let [a, b, c] = facet.corners;
                *facet = Facet::new(&[a, c, b]);
            }
            let found: f64 = one.iter().flat_map(|t| other.iter().map(|u| exchange(t, u))).sum();
            // Howell, C-11, for unit squares.
            let x = 1.0 / distance;
            let s = 1.0 + x * x;
            let closed = 2.0 / (std::f64::consts::PI * x * x)
                * ((s * s / (1.0 + 2.0 * x * x)).sqrt().ln() + 2.0 * x * s.sqrt() * (x / s.sqrt()).atan()
                    - 2.0 * x * x.atan());
            // The closed form loses its digits beyond; there one over pi d^2 is right to (1 / d)^2.
            let right = if distance > 50.0 { 1.0 / (std::f64::consts::PI * distance * distance) } else { closed };
            assert!((found / right - 1.0).abs() < 1e-3, "{distance}: {found} {right}");
        }
    }
}
