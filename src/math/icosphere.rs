//! A sphere's stand-in of flat triangles: an icosahedron whose faces are cut in four and whose corners are pushed out to the sphere.

use glam::DVec3;

use crate::shared::ICOSPHERE_CORNERS;

/// Radius of the sphere around the mesh; that of the sphere within it is 1.
pub const CIRCUMRADIUS: f64 = 1.0705;

/// Where corners lie, so that the nearest faces keep a distance of 1 after rounding to f32: 1 over theirs, 0.934172, and a little more.
const SCALE: f64 = 1.07047;

/// Three corners a triangle, counter-clockwise seen from outside; w is 0. No face is nearer to the centre than 1.
pub fn corners() -> Vec<[f32; 4]> {
    let mut corners = Vec::with_capacity(ICOSPHERE_CORNERS as usize);
    for [a, b, c] in icosahedron() {
        let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
        for triangle in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
            corners.extend(triangle.map(|p| (p * SCALE).as_vec3().extend(0.0).to_array()));
        }
    }
    corners
}

/// Faces of the icosahedron on the unit sphere: every three corners that neighbour each other.
fn icosahedron() -> Vec<[DVec3; 3]> {
    let golden = (1.0 + 5f64.sqrt()) * 0.5;
    let mut points = Vec::new();
    for (a, b) in [(-1.0, -golden), (-1.0, golden), (1.0, -golden), (1.0, golden)] {
        points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    // Neighbours are 2 apart, the next nearest corners more than 3.
    let neighbours = |a: DVec3, b: DVec3| a.distance_squared(b) < 5.0;
    let mut faces = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i + 1).filter(|(_, b)| neighbours(a, **b)) {
            for &c in points[j + 1..].iter().filter(|c| neighbours(a, **c) && neighbours(b, **c)) {
                let outwards = (b - a).cross(c - a).dot(a) > 0.0;
                faces.push((if outwards { [a, b, c] } else { [a, c, b] }).map(DVec3::normalize));
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn triangles() -> Vec<[DVec3; 3]> {
        let point = |c: [f32; 4]| DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2]));
        corners().chunks_exact(3).map(|t| [point(t[0]), point(t[1]), point(t[2])]).collect()
    }

    #[test]
    fn faces_enclose_the_unit_sphere_tightly() {
        assert_eq!(corners().len(), ICOSPHERE_CORNERS as usize);
        let mut nearest = f64::INFINITY;
        for [a, b, c] in triangles() {
            nearest = nearest.min((b - a).cross(c - a).normalize().dot(a));
            assert!([a, b, c].iter().all(|p| p.length() < CIRCUMRADIUS));
        }
        assert!((1.0..1.00001).contains(&nearest), "{nearest}");
    }

    #[test]
    fn the_mesh_is_closed_and_faces_outwards() {
        let mut edges = BTreeSet::new();
        let bits = |p: DVec3| p.to_array().map(f64::to_bits);
        for [a, b, c] in triangles() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert((bits(from), bits(to))), "two faces run along an edge in one direction");
            }
        }
        assert!(edges.iter().all(|&(from, to)| edges.contains(&(to, from))));
    }
}
