//! A patch with what every pair asks of it: where points of it lie, and the facets that stand for it where others are near.

use glam::DVec3;

use super::pair::{self, Facet};
use super::patches::Patch;
use super::sight::NO_TRIANGLE;
use crate::math::random::Random;

/// Facets that stand for a patch of more triangles than that: a pair of ornaments would otherwise take the square of what they are made of.
const MOST_FACETS: usize = 16;

/// See the module.
pub struct Places<'a> {
    /// What it is of.
    pub patch: &'a Patch,
    /// Square metres up to the end of each triangle.
    ends: Vec<f64>,
    /// Unit normals of triangles.
    normals: Vec<DVec3>,
    /// Facets, and how many times its own area each stands for.
    facets: Vec<(Facet, f64)>,
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
        Self { patch, ends, normals, facets: Vec::new() }
    }

    /// Likewise with its facets: all triangles, or as many as [`MOST_FACETS`] of more, each as often as a stratum of the patch's area meets it.
    pub fn with_facets(patch: &'a Patch) -> Self {
        let mut places = Self::new(patch);
        let count = patch.triangles.len();
        if count <= MOST_FACETS {
            places.facets = patch.triangles.iter().map(|t| (Facet::new(t), 1.0)).collect();
            return places;
        }
        let all = places.ends.last().copied().unwrap_or(0.0);
        let each = all / MOST_FACETS as f64;
        for k in 0..MOST_FACETS {
            let facet = Facet::new(&patch.triangles[places.triangle_of((k as f64 + 0.5) * each)]);
            places.facets.push((facet, each / facet.area()));
        }
        places
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

    /// Square metres: light that leaves one patch and meets the other, were nothing in between. Patches of few triangles by all pairs of them.
    pub fn exchange(&self, other: &Self) -> f64 {
        let with = |(t, often): &(Facet, f64)| -> f64 {
            other.facets.iter().map(|(u, other)| pair::exchange(t, u) * often * other).sum()
        };
        self.facets.iter().map(with).sum()
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
