//! Sides of cubes that surfaces pass through.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::{Gathered, OFF_GRID, Patch, Piece};

/// Least cosine between a side and a surface that it stands for: a cube's sides along a wall are none of it.
const TURNED: f64 = 0.1;

/// Sides of the cubes that hold pieces, but for those that lie on another such cube.
pub(super) fn sides(gathered: &Gathered, size: f64) -> Vec<Patch> {
    let mut cubes: BTreeMap<[i64; 3], Vec<&Piece>> = BTreeMap::new();
    for (key, pieces) in gathered {
        cubes.entry(key.0).or_default().extend(pieces);
    }
    let held: BTreeSet<[i64; 3]> = cubes.keys().copied().collect();
    let of = |(at, pieces): (&[i64; 3], &Vec<&Piece>)| {
        let empty = |side: usize| {
            let mut beside = *at;
            beside[side / 2] += if side.is_multiple_of(2) { 1 } else { -1 };
            !held.contains(&beside)
        };
        (0..6).filter(|side| empty(*side)).filter_map(|side| patch(*at, side, pieces, size)).collect::<Vec<_>>()
    };
    cubes.iter().flat_map(of).collect()
}

/// One side, with the mean of what looks that way: +x, -x, +y, -y, +z, -z.
fn patch(at: [i64; 3], side: usize, pieces: &[&Piece], size: f64) -> Option<Patch> {
    let normal = DVec3::AXES[side / 2] * if side.is_multiple_of(2) { 1.0 } else { -1.0 };
    let turned =
        || pieces.iter().map(|p| (p, p.area * p.normal.dot(normal))).filter(|(p, share)| *share > TURNED * p.area);
    let all: f64 = turned().map(|(_, share)| share).sum();
    if all <= 0.0 {
        return None;
    }
    let mean = |of: &dyn Fn(&Piece) -> DVec3| turned().map(|(p, share)| of(p) * share).sum::<DVec3>() / all;
    let low = (DVec3::from_array(at.map(|x| x as f64)) - OFF_GRID) * size;
    let center = low + (DVec3::splat(0.5) + 0.5 * normal) * size;
    let (u, v) = (DVec3::AXES[(side / 2 + 1) % 3] * 0.5 * size, DVec3::AXES[(side / 2 + 2) % 3] * 0.5 * size);
    let v = if side.is_multiple_of(2) { v } else { -v };
    let [a, b, c, d] = [center - u - v, center + u - v, center + u + v, center - u + v];
    Some(Patch {
        triangles: vec![[a, b, c], [a, c, d]],
        sources: Vec::new(),
        area: size * size,
        center,
        normal,
        flat: true,
        radius: 0.5f64.sqrt() * size,
        reflectance: mean(&|p| p.reflectance),
        emission: mean(&|p| p.emission),
    })
}
