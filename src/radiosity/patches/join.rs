//! Which pieces are one patch: those of a cell, a direction and a plane that see each other, and small ones of a cell that look much the same way.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{Gathered, LIFT, Piece};
use crate::reference::render::Reference;

/// Of the square of a patch's width: what is smaller is joined with others, so that ornaments do not take all patches.
const LEAST: f64 = 0.25;
/// Least cosine between directions of what is joined.
const ALIKE: f64 = 0.4;

/// Of the width of a patch: so far small ones step back from their surface to see each other.
const BACK: f64 = 0.4;

/// Cell, axis and sign that a direction is nearest to, and whether there is emission.
type Place = ([i64; 3], usize, bool);

/// The pieces of each patch.
pub(super) fn joined(gathered: Gathered, occluders: &Reference, size: f64) -> Vec<Vec<Piece>> {
    let parts: Vec<([i64; 3], Vec<Vec<Piece>>)> = gathered
        .into_iter()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(key, pieces)| (key.0, parted(pieces, occluders, size)))
        .collect();
    let (mut patches, mut small): (Vec<Vec<Piece>>, BTreeMap<Place, Vec<Part>>) = (Vec::new(), BTreeMap::new());
    for (cell, parts) in parts {
        for pieces in parts {
            let part = Part::new(pieces, size);
            if part.area < LEAST * size * size {
                let emits = part.pieces.iter().any(|piece| piece.emission.max_element() > 0.0);
                small.entry((cell, part.side(), emits)).or_default().push(part);
            } else {
                patches.push(part.pieces);
            }
        }
    }
    let groups: Vec<Vec<Part>> = small.into_values().collect();
    let more: Vec<Vec<Vec<Piece>>> = groups.into_par_iter().map(|parts| grown(parts, occluders, size)).collect();
    patches.extend(more.into_iter().flatten());
    patches
}

/// Pieces that see each other.
struct Part {
    pieces: Vec<Piece>,
    area: f64,
    /// Its middle, right above its surface.
    above: Vec<DVec3>,
    /// Times the area.
    normal: DVec3,
}

impl Part {
    fn new(pieces: Vec<Piece>, size: f64) -> Self {
        let area: f64 = pieces.iter().map(|piece| piece.area).sum();
        let middle = pieces.iter().map(|piece| middle(piece) * piece.area).sum::<DVec3>() / area;
        // The middle of an L is no place of it: the piece that is nearest to it is.
        let nearest = pieces.iter().min_by(|a, b| {
            middle.distance_squared(self::middle(a)).total_cmp(&middle.distance_squared(self::middle(b)))
        });
        let above = nearest.map(|piece| above(piece, size)).into_iter().collect();
        let normal = pieces.iter().map(|piece| piece.normal * piece.area).sum();
        Self { pieces, area, above, normal }
    }

    /// +x, -x, +y, -y, +z, -z.
    fn side(&self) -> usize {
        let n = self.normal.to_array();
        let axis = (0..3).fold(0, |best, k| if n[k].abs() > n[best].abs() { k } else { best });
        2 * axis + usize::from(n[axis] < 0.0)
    }

    fn join(&mut self, other: Self) {
        self.pieces.extend(other.pieces);
        self.area += other.area;
        self.above.extend(other.above);
        self.normal += other.normal;
    }
}

fn middle(piece: &Piece) -> DVec3 {
    (piece.corners[0] + piece.corners[1] + piece.corners[2]) / 3.0
}

fn above(piece: &Piece, size: f64) -> DVec3 {
    middle(piece) + piece.normal * (LIFT * size)
}

/// Small parts of one place, each joined with those before it that it sees and that look its way, until they are large enough.
fn grown(parts: Vec<Part>, occluders: &Reference, size: f64) -> Vec<Vec<Piece>> {
    let mut grown: Vec<Part> = Vec::new();
    for part in parts {
        let fits = |of: &Part| {
            let alike = of.normal.normalize_or_zero().dot(part.normal.normalize_or_zero()) > ALIKE;
            alike
                && of.area < LEAST * size * size
                && of.above.iter().all(|p| meet(occluders, size, *p, part.above[0], of.normal))
        };
        match grown.iter_mut().find(|of| fits(of)) {
            Some(of) => of.join(part),
            None => grown.push(part),
        }
    }
    grown.into_iter().map(|part| part.pieces).collect()
}

/// Two places see each other, or do where both step back from what they lie on: no wall stands between them then, only their like.
fn meet(occluders: &Reference, size: f64, p: DVec3, q: DVec3, normal: DVec3) -> bool {
    let back = normal.normalize_or_zero() * (BACK * size);
    let steps_back = |p: DVec3| !occluders.is_blocked(p, p + back);
    !occluders.is_blocked(p, q) || (steps_back(p) && steps_back(q) && !occluders.is_blocked(p + back, q + back))
}

/// Pieces that see each other right above their surface, together: what stands between them parts them.
fn parted(pieces: Vec<Piece>, occluders: &Reference, size: f64) -> Vec<Vec<Piece>> {
    let mut parts: Vec<Vec<Piece>> = Vec::new();
    for piece in pieces {
        let seen =
            |part: &Vec<Piece>| part.iter().any(|other| !occluders.is_blocked(above(&piece, size), above(other, size)));
        let mut joined = vec![];
        let (together, apart): (Vec<_>, Vec<_>) = parts.into_iter().partition(seen);
        together.into_iter().for_each(|part| joined.extend(part));
        joined.push(piece);
        parts = apart;
        parts.push(joined);
    }
    parts
}
