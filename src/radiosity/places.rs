//! A patch with what every pair asks of it: where points of it lie, and what it exchanges with one that is near.

use glam::DVec3;

use super::pair::{self, Facet};
use super::patches::Patch;
use super::sight::NO_TRIANGLE;
use crate::math::random::Random;

/// Pairs of triangles that two patches exchange by, at most: ornaments would otherwise take the square of what they are made of.
const MOST_PAIRS: usize = 256;
/// Odd: strata of one patch meet strata of the other all over.
const STRIDE: usize = 99;

/// See the module.
pub struct Places<'a> {
    /// What it is of.
    pub patch: &'a Patch,
    /// Square metres up to the end of each triangle.
    ends: Vec<f64>,
    /// Unit normals of triangles.
    normals: Vec<DVec3>,
}

/// A point of a patch.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// World space, metres.
    pub at: DVec3,
    /// Unit normal of its triangle.
    pub normal: DVec3,
    /// The scene's triangle that it lies on, or [`NO_TRIANGLE`].
    pub triangle: u32,
}

impl<'a> Places<'a> {
    /// Of a patch.
    pub fn new(patch: &'a Patch) -> Self {
        let mut end = 0.0;
        let doubled = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a);
        let ends = patch.triangles.iter().map(|t| {
            end += 0.5 * doubled(t).length();
            end
        });
        let ends = ends.collect();
        let normals = patch.triangles.iter().map(|t| doubled(t).normalize_or_zero()).collect();
        Self { patch, ends, normals }
    }

    /// Stratum k of n by area, anywhere in the triangle that it falls on.
    pub fn point(&self, k: u32, n: u32, random: &mut Random) -> Place {
        let along = (f64::from(k) + random.unit_f64()) / f64::from(n) * self.patch.area;
        let index = self.triangle_of(along);
        let (root, across) = (random.unit_f64().sqrt(), random.unit_f64());
        let [a, b, c] = self.patch.triangles.get(index).copied().unwrap_or([self.patch.center; 3]);
        Place {
            at: a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across),
            normal: self.normals.get(index).copied().unwrap_or(self.patch.normal),
            triangle: self.patch.sources.get(index).copied().unwrap_or(NO_TRIANGLE),
        }
    }

    /// Square metres: light that leaves one patch and meets the other, were nothing in between. By all pairs of triangles, or, where these are more than
    /// twice as many, by 256 of them, one from each stratum of both areas, which differ from call to call: on average they exchange as much as
    /// all. No patch meets more than all light of the other.
    pub fn exchange(&self, other: &Self, random: &mut Random) -> f64 {
        let triangles = [&self.patch.triangles, &other.patch.triangles];
        let most = self.patch.area.min(other.patch.area);
        if triangles[0].len() * triangles[1].len() <= 2 * MOST_PAIRS {
            let [own, others] = triangles.map(|all| all.iter().map(Facet::new).collect::<Vec<_>>());
            return own.iter().flat_map(|t| others.iter().map(|u| pair::exchange(t, u))).sum::<f64>().min(most);
        }
        let each = [self, other].map(|places| places.ends.last().copied().unwrap_or(0.0) / MOST_PAIRS as f64);
        let offset = (random.unit_f64() * MOST_PAIRS as f64) as usize;
        let of = |k: usize| {
            let strata = [k, (k * STRIDE + offset) % MOST_PAIRS];
            let [t, u] = [(self, 0), (other, 1)].map(|(places, side): (&Self, usize)| {
                let along = (strata[side] as f64 + random.unit_f64()) * each[side];
                Facet::new(&places.patch.triangles[places.triangle_of(along)])
            });
            pair::exchange(&t, &u) / (t.area() * u.area())
        };
        ((0..MOST_PAIRS).map(of).sum::<f64>() * each[0] * each[1] * MOST_PAIRS as f64).min(most)
    }

    /// The triangle in which so much of the area, counted along all of them, ends.
    fn triangle_of(&self, along: f64) -> usize {
        self.ends.partition_point(|end| *end <= along).min(self.ends.len().saturating_sub(1))
    }
}

/// A point of a patch and the normal there: stratum k of n by area.
pub fn points_on(patch: &Patch, n: u32, random: &mut Random) -> Vec<[DVec3; 2]> {
    let places = Places::new(patch);
    let of = |k| {
        let place = places.point(k, n, random);
        [place.at, place.normal]
    };
    (0..n).map(of).collect()
}
