//! From patches to any place of a surface: a grid of cells, and in each, for each of six directions, the patches whose light is mixed there. Weights
//! fall with distance and with the angle between normals, and are divided by their sum. Where a wall stands between the surfaces of a cell its plane
//! parts them, and each side mixes patches of its own: nothing comes through.
//!
//! Words, read by glsl/inc/bounced.glsl: one a cell, then records and lists. A cell's word is where its record begins, or 0. A record is six places of
//! lists, by direction (+x, -x, +y, -y, +z, -z). A list is a count and so many patches, or [`PARTED`] with a plane (four floats as bits, in cells) and the
//! places of two lists: behind the plane and before it.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use super::patches::{Patch, Patches};
use crate::reference::render::Reference;

/// First word of a list that a plane parts.
pub const PARTED: u32 = 1 << 31;
/// Planes that one place may be compared with.
pub const MOST_PLANES: u32 = 4;
/// Radius in which patches are mixed, in widths of a patch.
pub const REACH: f64 = 1.5;
/// Cells in the width of a patch.
const CELLS: f64 = 2.0;
/// Cells of a grid at most; wider ones beyond that.
const MOST_CELLS: f64 = 4e6;
/// Of the width of a patch: so far above surfaces rays run that tell what stands between them.
const LIFT: f64 = 0.05;
/// Of the width of a patch: what is so close to a plane lies in it.
const SHIFT: f64 = 1e-3;
/// Cosine between a list's direction and a plane's normal from which the plane may be a surface of the list.
const ALONG: f64 = 0.1;
/// Places of a patch in a cell that rays start from.
const PLACES: usize = 3;
/// Cosine between a direction and a normal that has no other axis nearer to it: 1 / sqrt 3, and slack.
const LOOKS: f64 = 0.55;
/// Weight of a patch at the end of its reach against one right here: a place that is near none still has light.
pub const LEAST_WEIGHT: f32 = 1e-6;

/// Where patches are mixed.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    /// Corner of the first cell, world space, metres.
    pub origin: DVec3,
    /// Width of a cell, metres.
    pub cell: f64,
    /// Cells along each axis.
    pub size: [u32; 3],
    /// Cells, records and lists.
    pub words: Vec<u32>,
    /// Radius in cells within which patches are mixed.
    pub reach: f64,
}

/// A place of a surface that stands for what lies about it.
#[derive(Clone, Copy)]
struct Place {
    at: DVec3,
    normal: DVec3,
    patch: u32,
}

impl Transfer {
    /// The grid of these patches; `occluders` as they were made with.
    pub fn new(patches: &Patches, occluders: &Reference) -> Self {
        let corners = || patches.list.iter().flat_map(|patch| patch.triangles.iter().flatten().copied());
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        if patches.list.is_empty() {
            return Self { origin: DVec3::ZERO, cell: 1.0, size: [1; 3], words: vec![0], reach: REACH * CELLS };
        }
        let mut cell = patches.size / CELLS;
        let cells = |cell: f64| ((high - low) / cell).floor() + 3.0;
        while cells(cell).element_product() > MOST_CELLS {
            cell *= 1.25;
        }
        let origin = low - cell;
        let size = cells(cell).to_array().map(|n| n as u32);
        let cell_of = |p: DVec3| ((p - origin) / cell).floor().to_array().map(|x| x as i32);
        let mut places: BTreeMap<[i32; 3], Vec<Place>> = BTreeMap::new();
        for (index, patch) in patches.list.iter().enumerate() {
            let mut held: BTreeSet<[i32; 3]> = BTreeSet::new();
            for place in places_of(patch, index as u32) {
                held.insert(cell_of(place.at));
                places.entry(cell_of(place.at)).or_default().push(place);
            }
            // Cells that the patch lies in without any of those.
            for place in more_places(patch, index as u32, cell) {
                if held.insert(cell_of(place.at)) {
                    places.entry(cell_of(place.at)).or_default().push(place);
                }
            }
        }
        // Surfaces reach into cells beside those of their places.
        let beside = 1 + (patches.off_surface / cell).ceil() as i32;
        let mut touched: BTreeSet<[i32; 3]> = BTreeSet::new();
        for at in places.keys() {
            touched.extend(around(*at, beside));
        }
        let reach = REACH * patches.size;
        let steps = (reach / cell).ceil() as i32 + 1;
        let cells: Vec<[i32; 3]> = touched.into_iter().filter(|at| inside(*at, size)).collect();
        let records: Vec<Vec<Tree>> = cells
            .par_iter()
            .map(|at| {
                let near = nearest_places(*at, beside, &places);
                let about: Vec<&Place> =
                    around(*at, steps).filter_map(|beside| places.get(&beside)).flatten().collect();
                let of = Cell { patches, occluders, reach, origin, cell };
                of.trees(DVec3::from_array(at.map(f64::from)), &near, &about)
            })
            .collect();
        let mut words = vec![0u32; size.iter().product::<u32>() as usize];
        for (at, record) in cells.iter().zip(&records) {
            let begin = words.len();
            words.resize(begin + 6, 0);
            for (side, tree) in record.iter().enumerate() {
                // Directions that no surface here looks in share a list.
                let same = record[..side].iter().position(|other| other == tree);
                words[begin + side] = match same {
                    Some(other) => words[begin + other],
                    None => tree.write(&mut words),
                };
            }
            let index = (at[2] as u32 * size[1] + at[1] as u32) * size[0] + at[0] as u32;
            words[index as usize] = begin as u32;
        }
        Self { origin, cell, size, words, reach: reach / cell }
    }

    /// Whether every record, list and patch lies in what it points into.
    ///
    /// # Errors
    /// The word, in words.
    pub fn check(&self, patches: usize) -> Result<(), String> {
        let cells = self.size.iter().try_fold(1usize, |all, n| all.checked_mul(*n as usize));
        let cells = cells.filter(|n| *n > 0 && *n <= self.words.len()).ok_or("has fewer words than cells")?;
        let word = |at: usize| self.words.get(at).copied().ok_or_else(|| format!("word {at} is not there"));
        for cell in 0..cells {
            let record = self.words[cell] as usize;
            if record == 0 {
                continue;
            }
            let mut open: Vec<(usize, u32)> = Vec::new();
            for side in 0..6 {
                open.push((word(record + side)? as usize, MOST_PLANES));
            }
            while let Some((list, planes)) = open.pop() {
                let head = word(list)?;
                if head == PARTED {
                    let left = planes.checked_sub(1).ok_or_else(|| format!("word {list} parts what is parted"))?;
                    open.extend([(word(list + 5)? as usize, left), (word(list + 6)? as usize, left)]);
                    continue;
                }
                for k in 1..=head as usize {
                    if word(list + k)? as usize >= patches {
                        return Err(format!("word {} is no patch of {patches}", list + k));
                    }
                }
            }
        }
        Ok(())
    }

    /// Patches and their weights at a place of a surface, which sum to 1; none where no surface is near. The twin of glsl/inc/bounced.glsl.
    pub fn weights(&self, patches: &[Patch], at: DVec3, normal: DVec3) -> Vec<(u32, f64)> {
        let place = (at - self.origin) / self.cell;
        let [x, y, z] = std::array::from_fn(|axis| place[axis].clamp(0.0, f64::from(self.size[axis] - 1)) as u32);
        let index = (z * self.size[1] + y) * self.size[0] + x;
        let record = self.words[index as usize] as usize;
        if record == 0 {
            return Vec::new();
        }
        let mut list = self.words[record + side_of(normal)] as usize;
        for _ in 0..MOST_PLANES {
            if self.words[list] != PARTED {
                break;
            }
            let plane = [1, 2, 3, 4].map(|k| f64::from(f32::from_bits(self.words[list + k])));
            let before = DVec3::new(plane[0], plane[1], plane[2]).dot(place) + plane[3] >= 0.0;
            list = self.words[list + if before { 6 } else { 5 }] as usize;
        }
        let count = self.words[list] as usize;
        let mut weights: Vec<(u32, f64)> = self.words[list + 1..list + 1 + count]
            .iter()
            .map(|&index| {
                let patch = &patches[index as usize];
                let apart = patch.center.distance(at) / self.cell / self.reach;
                let near = (1.0 - apart * apart).max(0.0);
                (index, patch.area * (near * near + f64::from(LEAST_WEIGHT)) * facing(patch.normal, normal))
            })
            .collect();
        let sum: f64 = weights.iter().map(|w| w.1).sum();
        weights.iter_mut().for_each(|weight| weight.1 /= sum);
        weights
    }
}

/// How alike two normals are, 0 to 1, and a little more than 0.
fn facing(a: DVec3, b: DVec3) -> f64 {
    let alike = a.dot(b).max(0.0);
    alike * alike * alike * alike + f64::from(LEAST_WEIGHT)
}

/// Axis that a normal is nearest to: +x, -x, +y, -y, +z, -z.
fn side_of(normal: DVec3) -> usize {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(normal[axis] < 0.0)
}

fn direction(side: usize) -> DVec3 {
    DVec3::AXES[side / 2] * if side.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// At most [`PLACES`] of each patch, spread over them.
fn thinned(places: impl Iterator<Item = Place>) -> Vec<Place> {
    let mut by_patch: BTreeMap<u32, Vec<Place>> = BTreeMap::new();
    places.for_each(|place| by_patch.entry(place.patch).or_default().push(place));
    let few = |all: Vec<Place>| {
        let count = all.len().min(PLACES);
        (0..count).map(move |k| all[k * all.len() / count])
    };
    by_patch.into_values().flat_map(few).collect()
}

/// Middles of a patch's triangles, and of their edges.
fn places_of(patch: &Patch, index: u32) -> impl Iterator<Item = Place> {
    patch.triangles.iter().flat_map(move |t| {
        let middle = (t[0] + t[1] + t[2]) / 3.0;
        let normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
        let towards = |p: DVec3| Place { at: middle.lerp(p, 0.9), normal, patch: index };
        [towards(middle), towards(t[0]), towards(t[1]), towards(t[2])]
    })
}

/// Places all over a patch, less than half a cell apart.
fn more_places(patch: &Patch, index: u32, cell: f64) -> impl Iterator<Item = Place> {
    patch.triangles.iter().flat_map(move |t| {
        let normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
        let middle = (t[0] + t[1] + t[2]) / 3.0;
        let longest = t[0].distance(t[1]).max(t[1].distance(t[2])).max(t[2].distance(t[0]));
        let steps = (longest / (0.45 * cell)).ceil().clamp(1.0, 16.0) as u32;
        (0..=steps).flat_map(move |i| (0..=steps - i).map(move |j| (i, j))).map(move |(i, j)| {
            let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(steps));
            let at = t[0] * (1.0 - u - v) + t[1] * u + t[2] * v;
            Place { at: middle.lerp(at, 0.98), normal, patch: index }
        })
    })
}

/// Cells up to so many steps away along each axis.
fn around(at: [i32; 3], steps: i32) -> impl Iterator<Item = [i32; 3]> {
    let side = 2 * steps + 1;
    (0..side.pow(3)).map(move |k| {
        let away = [k % side, k / side % side, k / (side * side)];
        std::array::from_fn(|axis| at[axis] + away[axis] - steps)
    })
}

fn inside(at: [i32; 3], size: [u32; 3]) -> bool {
    (0..3).all(|axis| at[axis] >= 0 && (at[axis] as u32) < size[axis])
}

/// Places in a cell, or where it has none in those nearest to it, up to so many steps away.
fn nearest_places(at: [i32; 3], steps: i32, places: &BTreeMap<[i32; 3], Vec<Place>>) -> Vec<Place> {
    let within = |steps| around(at, steps).filter_map(|beside| places.get(&beside)).flatten().copied().collect();
    // Of patches that lie off their surface the nearest may be those of its back.
    let first = if steps > 1 { steps } else { 0 };
    (first..=steps).map(within).find(|found: &Vec<Place>| !found.is_empty()).unwrap_or_default()
}

/// What a list says.
#[derive(Debug, Clone, PartialEq)]
enum Tree {
    Patches(Vec<u32>),
    Parted { plane: [f32; 4], behind: Box<Tree>, before: Box<Tree> },
}

impl Tree {
    /// Appends the list; where it begins.
    fn write(&self, words: &mut Vec<u32>) -> u32 {
        match self {
            Self::Patches(patches) => {
                let begin = words.len() as u32;
                words.push(patches.len() as u32);
                words.extend(patches);
                begin
            }
            Self::Parted { plane, behind, before } => {
                let (behind, before) = (behind.write(words), before.write(words));
                let begin = words.len() as u32;
                words.push(PARTED);
                words.extend(plane.map(f32::to_bits));
                words.extend([behind, before]);
                begin
            }
        }
    }
}

/// What the lists of a cell are made from.
struct Cell<'a> {
    patches: &'a Patches,
    occluders: &'a Reference<'a>,
    reach: f64,
    origin: DVec3,
    cell: f64,
}

impl Cell<'_> {
    /// A list for each direction, of the surfaces that look there; where none does, of whatever surface is here: a map may bend normals.
    fn trees(&self, at: DVec3, near: &[Place], about: &[&Place]) -> Vec<Tree> {
        let middle = self.origin + (at + 0.5) * self.cell;
        let of = |side: Option<usize>| -> Option<Tree> {
            let towards = side.map_or(DVec3::ZERO, direction);
            let looks = |place: &Place| side.is_none() || place.normal.dot(towards) > LOOKS;
            let own: Vec<Place> = thinned(near.iter().copied().filter(&looks));
            if own.is_empty() {
                return None;
            }
            // A patch is looked at where it comes nearest, and only where its weight can be more than the least.
            let reach = self.reach + 0.5 * 3f64.sqrt() * self.cell;
            let is_near = |place: &Place| self.patches.list[place.patch as usize].center.distance(middle) < reach;
            let mut others: Vec<Place> = about.iter().map(|p| **p).filter(|p| looks(p) && is_near(p)).collect();
            let away = |place: &Place| place.at.distance_squared(middle);
            others.sort_by(|a, b| a.patch.cmp(&b.patch).then(away(a).total_cmp(&away(b))));
            others.dedup_by_key(|place| place.patch);
            Some(self.parted(&own, &others, towards, MOST_PLANES))
        };
        let mut any = None;
        let sides = (0..6).map(|side| {
            of(Some(side))
                .unwrap_or_else(|| any.get_or_insert_with(|| of(None).unwrap_or(Tree::Patches(Vec::new()))).clone())
        });
        sides.collect()
    }

    /// Surfaces of the list look `towards` about there, or anywhere.
    fn parted(&self, own: &[Place], others: &[Place], towards: DVec3, planes: u32) -> Tree {
        let lift = |place: &Place| place.at + place.normal * (LIFT * self.patches.size);
        let mut dividing: Option<[DVec3; 2]> = None;
        let mut seen = Vec::new();
        for other in others {
            let blocked = own
                .iter()
                .filter(|p| p.patch != other.patch)
                .find_map(|p| self.occluders.blocked_by(lift(p), lift(other)).map(|plane| (p, plane)));
            match blocked {
                None => seen.push(other.patch),
                Some((_, plane)) if own.iter().any(|p| !self.occluders.is_blocked(lift(p), lift(other))) => {
                    dividing = dividing.or(Some(plane));
                }
                Some(_) => {}
            }
        }
        if let Some([point, normal]) = dividing.filter(|_| planes > 0) {
            // Surfaces that lie in the plane are before it in the direction that they look in: rounding must not part them from themselves.
            let lies_in = |p: &&Place| {
                (p.at - point).dot(normal).abs() < SHIFT * self.patches.size && p.normal.dot(normal).abs() > 0.9
            };
            let own_side = |p: &Place| p.normal.dot(normal).signum();
            let looks = match towards.dot(normal) {
                along if along.abs() > ALONG => along.signum(),
                _ => own.iter().find(lies_in).map_or(0.0, own_side),
            };
            let point = point - normal * (looks * 2.0 * SHIFT * self.patches.size);
            let before = |place: &&Place| (place.at - point).dot(normal) >= 0.0;
            let (front, back): (Vec<&Place>, Vec<&Place>) = own.iter().partition(before);
            if !front.is_empty() && !back.is_empty() {
                let of = |part: Vec<&Place>| {
                    let part: Vec<Place> = part.into_iter().copied().collect();
                    Box::new(self.parted(&part, others, towards, planes - 1))
                };
                let to_origin = normal.dot(self.origin - point) / self.cell;
                let plane = normal.extend(to_origin).as_vec4().to_array();
                return Tree::Parted { plane, behind: of(back), before: of(front) };
            }
        }
        own.iter().for_each(|place| seen.push(place.patch));
        seen.sort_unstable();
        seen.dedup();
        Tree::Patches(seen)
    }
}

#[cfg(test)]
mod tests;
