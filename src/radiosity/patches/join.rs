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
/// Of the same: what has grown so large takes no more of them in.
const MOST: f64 = 1.5;
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
    let mut places: BTreeMap<Place, Vec<Part>> = BTreeMap::new();
    for (cell, parts) in parts {
        for pieces in parts {
            let part = Part::new(pieces, size);
            let emits = part.pieces.iter().any(|piece| piece.emission.max_element() > 0.0);
            places.entry((cell, part.side(), emits)).or_default().push(part);
        }
    }
    let places: Vec<(Place, Vec<Part>)> = places.into_iter().collect();
    let grown: Vec<(Place, Vec<Part>)> =
        places.into_par_iter().map(|(place, parts)| (place, grown(place.0, parts, occluders, size))).collect();
    let mut grown: BTreeMap<Place, Vec<Part>> = grown.into_iter().collect();
    taken_in(&mut grown, occluders, size);
    grown.into_values().flatten().map(|part| part.pieces).collect()
}

/// Ornaments that are left come to the nearest patch that they see, of those about them that look their way.
fn taken_in(grown: &mut BTreeMap<Place, Vec<Part>>, occluders: &Reference, size: f64) {
    let is_ornament = |part: &Part| part.area < ORNAMENT * size * size;
    let mut lone: Vec<(Place, Part)> = Vec::new();
    for (place, parts) in grown.iter_mut() {
        let (own, rest): (Vec<Part>, Vec<Part>) = std::mem::take(parts).into_iter().partition(is_ornament);
        lone.extend(own.into_iter().map(|part| (*place, part)));
        *parts = rest;
    }
    for ((cell, side, emits), part) in lone {
        let mut best: Option<(f64, Place, usize)> = None;
        for k in 0..27 {
            let beside = std::array::from_fn(|axis| cell[axis] + [k % 3, k / 3 % 3, k / 9][axis] - 1);
            let place = (beside, side, emits);
            for (index, of) in grown.get(&place).into_iter().flatten().enumerate() {
                let apart = of.above.iter().map(|p| p.distance(part.above[0])).fold(f64::INFINITY, f64::min);
                let fits = !is_ornament(of) && of.takes(&part, size) && apart < size;
                let nearer = best.is_none_or(|(least, ..)| apart < least);
                let sees = |p: &DVec3| meet(occluders, size, *p, part.above[0], of.normal);
                if fits && nearer && of.above.iter().any(sees) {
                    best = Some((apart, place, index));
                }
            }
        }
        match best {
            Some((_, place, index)) => {
                if let Some(of) = grown.get_mut(&place).and_then(|parts| parts.get_mut(index)) {
                    of.join(part);
                }
            }
            None => grown.entry((cell, side, emits)).or_default().push(part),
        }
    }
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

    /// An ornament may join it, as far as sizes and directions tell.
    fn takes(&self, ornament: &Self, size: f64) -> bool {
        let cosine = self.normal.normalize_or_zero().dot(ornament.normal.normalize_or_zero());
        cosine > ORNAMENTS_ALIKE && self.area < MOST * size * size
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
fn grown(cell: [i64; 3], mut parts: Vec<Part>, occluders: &Reference, size: f64) -> Vec<Part> {
    let is_ornament = |part: &Part| part.area < ORNAMENT * size * size;
    if parts.len() > 1 && parts.iter().any(is_ornament) {
        let air = Air::new(cell, occluders, size);
        parts.iter_mut().for_each(|part| part.air = air_about(part, &air, occluders, size));
    }
    // Ornaments come to what is larger.
    parts.sort_by(|a, b| b.area.total_cmp(&a.area));
    let mut grown: Vec<Part> = Vec::new();
    for part in parts {
        let fits = |of: &Part| {
            if is_ornament(&part) && part.air.is_some() && part.air == of.air && of.takes(&part, size) {
                return true;
            }
            if of.area.max(part.area) >= LEAST * size * size {
                return false;
            }
            let cosine = of.normal.normalize_or_zero().dot(part.normal.normalize_or_zero());
            cosine > ALIKE && of.above.iter().all(|p| meet(occluders, size, *p, part.above[0], of.normal))
        };
        match grown.iter_mut().find(|of| fits(of)) {
            Some(of) => of.join(part),
            None => grown.push(part),
        }
    }
    grown
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
