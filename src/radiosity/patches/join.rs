//! Which pieces are one patch: those of a cell, a direction and a plane that see each other, and small ones of a cell that look much the same way.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::air::Air;
use super::{Gathered, LIFT, Piece};
use crate::reference::render::Reference;

/// Of the square of a patch's width: what is smaller is joined with others, so that ornaments do not take all patches.
const LEAST: f64 = 0.25;
/// Least cosine between directions of what is joined.
const ALIKE: f64 = 0.4;

/// Of the square of a patch's width: what is smaller is an ornament, which joins others of its cell as long as no wall parts them, seen or not.
const ORNAMENT: f64 = 0.05;
/// Least cosine between directions of ornaments that are joined.
const ORNAMENTS_ALIKE: f64 = 0.1;

/// Pieces of an ornament that are tried in search of the air about it, and how close to them, in widths of a patch.
const AIR_PLACES: usize = 4;
const CLOSE_LIFT: f64 = 0.01;

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
    let groups: Vec<(Place, Vec<Part>)> = small.into_iter().collect();
    let more: Vec<Vec<Vec<Piece>>> =
        groups.into_par_iter().map(|((cell, ..), parts)| grown(cell, parts, occluders, size)).collect();
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
    /// Part of the air of its cell that it lies in, where that is known.
    air: Option<usize>,
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
        Self { pieces, area, above, normal, air: None }
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

/// The part of the air that some place right above a part lies in.
fn air_about(part: &Part, air: &Air, occluders: &Reference, size: f64) -> Option<usize> {
    let step = part.pieces.len().div_ceil(AIR_PLACES);
    let close = part
        .pieces
        .iter()
        .step_by(step)
        .flat_map(|piece| [LIFT, CLOSE_LIFT].map(|lift| middle(piece) + piece.normal * (lift * size)));
    part.above.iter().copied().chain(close).find_map(|place| air.of(place, occluders))
}

/// Small parts of one place, each joined with those before it that it sees and that look its way, until they are large enough.
fn grown(cell: [i64; 3], mut parts: Vec<Part>, occluders: &Reference, size: f64) -> Vec<Vec<Piece>> {
    let is_ornament = |part: &Part| part.area < ORNAMENT * size * size;
    if parts.iter().filter(|part| is_ornament(part)).count() > 1 {
        let air = Air::new(cell, occluders, size);
        parts.iter_mut().for_each(|part| part.air = air_about(part, &air, occluders, size));
    }
    // Ornaments come to what is larger.
    parts.sort_by(|a, b| b.area.total_cmp(&a.area));
    let mut grown: Vec<Part> = Vec::new();
    for part in parts {
        let fits = |of: &Part| {
            let cosine = of.normal.normalize_or_zero().dot(part.normal.normalize_or_zero());
            if of.area >= LEAST * size * size {
                return false;
            }
            if is_ornament(&part) && part.air.is_some() && part.air == of.air && cosine > ORNAMENTS_ALIKE {
                return true;
            }
            cosine > ALIKE && of.above.iter().all(|p| meet(occluders, size, *p, part.above[0], of.normal))
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
