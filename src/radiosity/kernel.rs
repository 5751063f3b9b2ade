//! Form factors between polygons that see all of each other, exactly: the double contour integral (E. Sparrow, "A New and Simpler Formulation for
//! Radiative Angle Factors", 1963)
//!
//! `A_i F_ij = 1 / (2 pi) * sum over edges e of i and f of j of (e . f) * integral over both of ln |x - y|`
//!
//! with unit vectors e and f along the edges. The integral over f has a closed form. That over e is done by the double exponential rule (H. Takahasi,
//! M. Mori, "Double Exponential Formulas for Numerical Integration", 1974), which takes the logarithms at the ends of its pieces: e is cut where it
//! passes the ends of f, so that edges may touch, cross and lie in one another.
//!
//! What of either polygon lies behind the other's plane is cut off first. All in f64 and world space, metres.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

/// Step of the double exponential rule, and steps to either side: nodes beyond lie closer to the end than f64 tells apart.
const STEP: f64 = 0.125;
const STEPS: i32 = 26;

/// Relative to the size of the polygons: what lies this close to a plane lies in it.
const PLANE: f64 = 1e-12;

/// Area times form factor, square metres: light that leaves `from` in all directions and meets `to`, with nothing in between. Both are planar and
/// convex, counter-clockwise as seen from their front; at least three corners each. Exactly 0 where they lie in one plane or show each other
/// their backs.
pub fn exchange(from: &[DVec3], to: &[DVec3]) -> f64 {
    let scale = from.iter().chain(to).fold(0.0f64, |most, p| most.max((*p - from[0]).abs().max_element()));
    let Some(from_plane) = Plane::of(from) else { return 0.0 };
    let Some(to_plane) = Plane::of(to) else { return 0.0 };
    let slack = PLANE * scale;
    let Some(to) = in_front(to, &from_plane, slack) else { return 0.0 };
    let Some(from) = in_front(from, &to_plane, slack) else { return 0.0 };
    let mut sum = 0.0;
    for (a, b) in edges(&from) {
        for (c, d) in edges(&to) {
            let along = (b - a).normalize_or_zero().dot((d - c).normalize_or_zero());
            if along.abs() > 1e-15 {
                sum += along * edge_pair(a, b, c, d);
            }
        }
    }
    (sum / TAU).max(0.0)
}

/// A polygon's plane.
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// `None` of a polygon without area.
    fn of(polygon: &[DVec3]) -> Option<Self> {
        // Newell's normal, about the first corner so that a far polygon keeps its digits.
        let origin = polygon[0];
        let doubled: DVec3 = edges(polygon).map(|(a, b)| (a - origin).cross(b - origin)).sum();
        let normal = doubled.try_normalize()?;
        Some(Self { normal, offset: normal.dot(origin) })
    }

    fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
}

/// What of a polygon lies in front of a plane (I. Sutherland, G. Hodgman, "Reentrant Polygon Clipping", 1974); `None` where nothing does.
fn in_front(polygon: &[DVec3], plane: &Plane, slack: f64) -> Option<Vec<DVec3>> {
    let distances: Vec<f64> = polygon
        .iter()
        .map(|p| plane.distance(*p))
        .map(|distance| if distance.abs() <= slack { 0.0 } else { distance })
        .collect();
    if distances.iter().all(|distance| *distance <= 0.0) {
        return None;
    }
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for index in 0..polygon.len() {
        let next = (index + 1) % polygon.len();
        let (here, there) = (distances[index], distances[next]);
        if here >= 0.0 {
            kept.push(polygon[index]);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(polygon[index].lerp(polygon[next], here / (here - there)));
        }
    }
    Some(kept)
}

/// Integral of `ln |x - y|` over both edges.
fn edge_pair(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let (length, other) = ((b - a).length(), (d - c).length());
    if length == 0.0 || other == 0.0 {
        return 0.0;
    }
    let (e, f) = ((b - a) / length, (d - c) / other);
    // Where along the first edge a logarithm may have its pole: beside the ends of the other, and where the two lines are closest.
    let cosine = e.dot(f);
    let sine2 = 1.0 - cosine * cosine;
    let apart = c - a;
    let closest = if sine2 > 1e-12 { (apart.dot(e) - cosine * apart.dot(f)) / sine2 } else { 0.0 };
    let mut cuts = [0.0, (c - a).dot(e), (d - a).dot(e), closest, length];
    cuts.iter_mut().for_each(|cut| *cut = cut.clamp(0.0, length));
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2)
        .filter(|piece| piece[1] - piece[0] > 1e-14 * length)
        .map(|piece| {
            let half = 0.5 * (piece[1] - piece[0]);
            let inner = |from_left: f64, from_right: f64| {
                // The end that is closer keeps its digits.
                let at = if from_left < from_right { piece[0] + from_left } else { piece[1] - from_right };
                log_distance(a + e * at, c, f, other)
            };
            half * double_exponential(|left, right| inner(left * half, right * half))
        })
        .sum()
}

/// Integral over [-1, 1] of a function of the distances to both ends.
fn double_exponential(function: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for step in -STEPS..=STEPS {
        let t = f64::from(step) * STEP;
        let (sinh, cosh) = (FRAC_PI_2 * t.sinh(), FRAC_PI_2 * t.cosh());
        // 1 - tanh s = 2 / (1 + e^2s).
        let (right, left) = (2.0 / (1.0 + (2.0 * sinh).exp()), 2.0 / (1.0 + (-2.0 * sinh).exp()));
        let weight = cosh / sinh.cosh().powi(2) * STEP;
        sum += weight * function(left, right);
    }
    sum
}

/// Integral of `ln |x - y|` over y on an edge from `start` along the unit vector `along`.
fn log_distance(x: DVec3, start: DVec3, along: DVec3, length: f64) -> f64 {
    let way = x - start;
    let beside = way.dot(along);
    let height = (way - along * beside).length();
    let antiderivative = |t: f64| {
        let squared = t * t + height * height;
        let logarithm = if squared > 0.0 { 0.5 * t * squared.ln() } else { 0.0 };
        let angle = if height > 0.0 { height * (t / height).atan() } else { 0.0 };
        logarithm - t + angle
    };
    antiderivative(length - beside) - antiderivative(-beside)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle with one corner at `at`.
    fn rectangle(at: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Vec<DVec3> {
        let [at, u, v] = [at, u, v].map(DVec3::from_array);
        vec![at, at + u, at + u + v, at + v]
    }

    /// A rectangle at z = 0 that looks up, of such sides.
    fn floor(x: f64, y: f64) -> Vec<DVec3> {
        rectangle([0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0])
    }

    /// The same at that height, looking down.
    fn ceiling(x: f64, y: f64, height: f64) -> Vec<DVec3> {
        rectangle([0.0, 0.0, height], [0.0, y, 0.0], [x, 0.0, 0.0])
    }

    fn close(found: f64, exact: f64, most: f64) {
        assert!((found - exact).abs() <= most * exact, "{found:.12} for {exact:.12}");
    }

    #[test]
    fn parallel_rectangles_have_their_closed_form() {
        // Howell, C-11.
        for (height, exact) in [(1.0, 0.199_824_895_7), (0.1, 0.826_994_522_4), (10.0, 0.003_162_056_8)] {
            close(exchange(&floor(1.0, 1.0), &ceiling(1.0, 1.0, height)), exact, 2e-8);
        }
        close(exchange(&floor(2.0, 1.0), &ceiling(2.0, 1.0, 1.0)) / 2.0, 0.285_875_384_9, 1e-9);
    }

    #[test]
    fn rectangles_with_a_common_edge_have_their_closed_form() {
        // Howell, C-14: a floor of w x l and a wall of h x l over one of its edges of length l.
        for (l, w, h, exact) in
            [(1.0, 1.0, 1.0, 0.200_043_776_1), (1.0, 1.0, 2.0, 0.232_852_602_8), (2.0, 1.0, 1.0, 0.240_636_006_2)]
        {
            let wall = rectangle([0.0; 3], [0.0, l, 0.0], [0.0, 0.0, h]);
            close(exchange(&floor(w, l), &wall) / (w * l), exact, 1e-9);
        }
    }

    /// R1.
    #[test]
    fn what_does_not_see_each_other_exchanges_nothing() {
        let up = floor(1.0, 1.0);
        let beside = rectangle([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let overlapping = rectangle([0.5, 0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let away = rectangle([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let below = ceiling(1.0, 1.0, -1.0);
        for other in [&up, &beside, &overlapping, &away, &below] {
            assert_eq!(exchange(&up, other), 0.0);
            assert_eq!(exchange(other, &up), 0.0);
        }
        let line = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(exchange(&up, &line), 0.0);
    }

    #[test]
    fn a_closed_box_sends_everything_to_its_sides() {
        // Of 1 x 2 x 3 metres, far from the origin.
        let (at, size) = (DVec3::new(1e4, -2e3, 5.0), DVec3::new(1.0, 2.0, 3.0));
        let mut sides = Vec::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut along = [DVec3::ZERO; 3];
            (0..3).for_each(|k| along[k][k] = size[k]);
            let corner = |p: DVec3| (at + p).to_array();
            sides.push(rectangle(corner(DVec3::ZERO), along[u].to_array(), along[v].to_array()));
            sides.push(rectangle(corner(along[axis]), along[v].to_array(), along[u].to_array()));
        }
        for (index, side) in sides.iter().enumerate() {
            let area = (side[1] - side[0]).cross(side[3] - side[0]).length();
            let sum: f64 = sides.iter().map(|other| exchange(side, other)).sum();
            assert!((sum / area - 1.0).abs() < 1e-8, "side {index}: {}", sum / area);
        }
    }

    /// R4: and what is cut in two sends what the whole does, with edges that lie in one another.
    #[test]
    fn exchange_is_the_same_both_ways_and_adds_up() {
        let tilted = rectangle([0.2, -0.4, 0.0], [0.9, 0.1, 0.4], [-0.2, 0.8, 0.5]);
        let triangle = vec![DVec3::new(0.0, 0.0, 1.2), DVec3::new(0.3, 1.5, 0.7), DVec3::new(1.1, 0.2, 0.9)];
        close(exchange(&tilted, &triangle), exchange(&triangle, &tilted), 1e-9);
        let whole = exchange(&floor(1.0, 1.0), &rectangle([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]));
        let parts: f64 = [0.0, 0.3, 0.7]
            .into_iter()
            .zip([0.3, 0.4, 0.3])
            .map(|(y, l)| exchange(&floor(1.0, 1.0), &rectangle([0.0, y, 0.0], [0.0, l, 0.0], [0.0, 0.0, 1.0])))
            .sum();
        close(parts, whole, 1e-8);
    }

    /// A plane that passes through another's polygon: only what lies in front counts.
    #[test]
    fn what_lies_behind_is_cut_off() {
        let through = rectangle([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]);
        close(exchange(&floor(1.0, 1.0), &through), 0.200_043_776_1, 1e-9);
        close(exchange(&through, &floor(1.0, 1.0)), 0.200_043_776_1, 1e-9);
    }

    /// The middle of a sphere of facets: any two facets inside of one exchange A_i A_j / (4 pi R^2), in the limit of many.
    #[test]
    fn facets_of_a_sphere_approach_their_closed_form() {
        let facet = |theta: f64, phi: f64, step: f64| -> Vec<DVec3> {
            let at = |t: f64, p: f64| DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos());
            // Turned inward.
            vec![at(theta, phi), at(theta, phi + step), at(theta + step, phi)]
        };
        let area = |f: &[DVec3]| 0.5 * (f[1] - f[0]).cross(f[2] - f[0]).length();
        let off = |step: f64| {
            let (a, b) = (facet(1.0, 0.3, step), facet(2.0, 2.5, step));
            (exchange(&a, &b) / (area(&a) * area(&b) / (2.0 * TAU)) - 1.0).abs()
        };
        let [coarse, fine] = [off(0.2), off(0.1)];
        assert!(coarse < 0.05 && fine < coarse / 1.7, "{coarse} {fine}");
    }
}
