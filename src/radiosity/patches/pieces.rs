//! Pieces of triangles by cell, direction, plane and material, without what lies inside of something.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use super::{OFF_GRID, area_and_normal, by_cosine, longest};
use crate::error::{Error, Result};
use crate::reference::render::Reference;
use crate::reference::surface::{Face, Fragment, Placement, Weights};
use crate::reference::texture::Textures;
use crate::scene::{AlphaMode, Material, Mesh, Scene};

/// Directions that are told apart along each axis of a normal.
const NORMAL_STEPS: f64 = 6.0;
/// Planes that are told apart in the width of a patch.
const PLANE_STEPS: f64 = 8.0;
/// A piece that is partly inside of something, or that something stands on, is halved until it is so much narrower than a patch.
const BURIED_STEPS: f64 = 12.0;
/// Share of the way from the middle of a piece to a corner at which it is looked at.
const INSET: f64 = 0.98;
/// Of the width of a patch: what stands so close above a piece cuts it.
const CUT_LIFT: f64 = 0.05;
/// Rays, all of which meet nothing but backs from a place inside of something.
const BURIED_RAYS: u32 = 16;
/// Pieces that a scene may come to.
const MOST_PIECES: usize = 1 << 24;

/// Cell, direction, plane within the cell, and material.
pub(super) type Key = ([i64; 3], [i64; 3], i64, usize);

/// A triangle of a patch to be.
pub(super) struct Piece {
    pub corners: [DVec3; 3],
    /// Triangle of the scene, counted over all instances.
    pub source: u32,
    pub area: f64,
    pub normal: DVec3,
    pub reflectance: DVec3,
    pub emission: DVec3,
}

/// Pieces by where they belong.
pub(super) type Gathered = BTreeMap<Key, Vec<Piece>>;

/// What is left of a scene's triangles.
pub(super) struct Found {
    pub gathered: Gathered,
    pub triangles: usize,
    pub dropped: usize,
    /// Square metres.
    pub buried: f64,
}

/// Pieces no longer than `longest`, in cells `size` metres wide; on all cores, and in the order of the triangles.
///
/// # Errors
/// More pieces than a scene may come to; an image whose bytes do not fit its size.
pub(super) fn of(scene: &Scene, occluders: &Reference, size: f64, longest: f64) -> Result<Found> {
    let textures = Textures::new(scene)?;
    let placements: Vec<Placement> =
        scene.instances.iter().map(|i| Placement::new(&i.object_to_world, &DMat4::IDENTITY)).collect();
    let mut found = Found { gathered: Gathered::new(), triangles: 0, dropped: 0, buried: 0.0 };
    let mut sources = Vec::new();
    let mut first_triangle = 0u32;
    for (instance, placement) in scene.instances.iter().zip(&placements) {
        let mesh = &scene.meshes[instance.mesh];
        let material = &scene.materials[mesh.material];
        let first = first_triangle;
        first_triangle += (mesh.indices.len() / 3) as u32;
        if material.alpha == AlphaMode::Blend || material.unlit {
            continue;
        }
        for (index, vertices) in (first..).zip(mesh.indices.chunks_exact(3)) {
            let vertices = [0, 1, 2].map(|k| vertices[k] as usize);
            let corners = vertices.map(|v| {
                let local = DVec3::from_array(mesh.positions[v].map(f64::from));
                instance.object_to_world.transform_point3(local)
            });
            found.triangles += 1;
            let doubled = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            if doubled > 0.0 && doubled.is_finite() {
                sources.push(Source {
                    mesh,
                    placement,
                    textures: &textures,
                    scene,
                    occluders,
                    vertices,
                    corners,
                    index,
                });
            } else {
                found.dropped += 1;
            }
        }
    }
    let mut pieces = 0usize;
    let mut all = Vec::with_capacity(sources.len());
    for source in &sources {
        let weights = cut(&source.corners, longest);
        pieces += weights.len();
        if pieces > MOST_PIECES {
            return Err(Error::new(format!("{}: patches of {size} m are too many", scene.name)));
        }
        all.extend(weights.into_iter().map(|weights| (source, weights)));
    }
    let run = |run: &[(&Source, [DVec3; 3])]| {
        let mut own = Vec::new();
        let buried: Vec<f64> = run.iter().map(|(source, weights)| source.gather(weights, size, &mut own)).collect();
        (own, buried)
    };
    for (own, buried) in all.par_chunks(PIECES_A_TASK).map(run).collect::<Vec<_>>() {
        buried.iter().for_each(|area| found.buried += area);
        own.into_iter().for_each(|(key, piece)| found.gathered.entry(key).or_default().push(piece));
    }
    Ok(found)
}

/// Pieces that a core takes at once.
const PIECES_A_TASK: usize = 256;

/// Where a piece belongs.
fn key(center: DVec3, normal: DVec3, size: f64, material: usize) -> Key {
    let cell = (center / size + OFF_GRID).floor();
    let code = (normal * NORMAL_STEPS + OFF_GRID).round().to_array().map(|x| x as i64);
    let plane = (normal.dot(center / size + OFF_GRID - cell) * PLANE_STEPS + OFF_GRID).round() as i64;
    (cell.to_array().map(|x| x as i64), code, plane, material)
}

/// Barycentric corners of the pieces of a triangle, each cut across its longest edge until that is no longer than `size`.
fn cut(corners: &[DVec3; 3], size: f64) -> Vec<[DVec3; 3]> {
    let mut open = vec![[DVec3::X, DVec3::Y, DVec3::Z]];
    let mut pieces = Vec::new();
    while let Some(weights) = open.pop() {
        if longest(&placed(corners, &weights)) <= size || pieces.len() + open.len() > MOST_PIECES {
            pieces.push(weights);
        } else {
            open.extend(halves(corners, &weights));
        }
    }
    pieces
}

/// Where barycentric corners are.
fn placed(corners: &[DVec3; 3], weights: &[DVec3; 3]) -> [DVec3; 3] {
    weights.map(|w| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z)
}

/// Both parts of a piece, cut across its longest edge; barycentric corners.
fn halves(corners: &[DVec3; 3], &[a, b, c]: &[DVec3; 3]) -> [[DVec3; 3]; 2] {
    let [p, q, r] = placed(corners, &[a, b, c]);
    let lengths = [p.distance(q), q.distance(r), r.distance(p)];
    let longest = (0..3).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
    let [p, q, r] = [[a, b, c], [b, c, a], [c, a, b]][longest];
    let middle = (p + q) * 0.5;
    [[p, middle, r], [middle, q, r]]
}

/// A triangle that is cut.
struct Source<'a> {
    mesh: &'a Mesh,
    placement: &'a Placement,
    textures: &'a Textures,
    scene: &'a Scene,
    occluders: &'a Reference<'a>,
    vertices: [usize; 3],
    corners: [DVec3; 3],
    /// Of the triangle, counted over all instances.
    index: u32,
}

impl Source<'_> {
    /// Adds a piece, and its back where it has one, but for what lies inside of something: square metres of that.
    fn gather(&self, weights: &[DVec3; 3], size: f64, gathered: &mut Vec<(Key, Piece)>) -> f64 {
        let mut buried = 0.0;
        for back in [false, true] {
            if back && !self.material().double_sided {
                continue;
            }
            let mut open = vec![*weights];
            while let Some(weights) = open.pop() {
                let piece = self.piece(&weights, back);
                let (area, normal) = area_and_normal(&piece);
                if area == 0.0 {
                    continue;
                }
                let middle = (piece[0] + piece[1] + piece[2]) / 3.0;
                let places =
                    [middle, middle.lerp(piece[0], INSET), middle.lerp(piece[1], INSET), middle.lerp(piece[2], INSET)];
                let inside = places.map(|place| self.is_buried(place, normal));
                let above = places.map(|place| place + normal * (CUT_LIFT * size));
                let cut_through = above[1..].iter().any(|place| self.occluders.is_blocked(above[0], *place));
                let mixed = cut_through || inside.iter().any(|x| *x != inside[0]);
                if mixed && longest(&piece) > size / BURIED_STEPS {
                    open.extend(halves(&self.corners, &weights));
                } else if inside[0] || cut_through {
                    buried += area;
                } else {
                    self.add(&weights, back, size, gathered);
                }
            }
        }
        buried
    }

    fn material(&self) -> &Material {
        &self.scene.materials[self.mesh.material]
    }

    /// World space, counter-clockwise from the side that is meant, first the corner that comes first in the weights.
    fn piece(&self, weights: &[DVec3; 3], back: bool) -> [DVec3; 3] {
        let mut piece = placed(&self.corners, weights);
        if self.placement.mirrored != back {
            piece.swap(1, 2);
        }
        piece
    }

    /// Whatever leaves the place meets nothing but backs.
    fn is_buried(&self, place: DVec3, normal: DVec3) -> bool {
        let side = BURIED_RAYS.isqrt();
        (0..side * side).all(|k| self.occluders.meets_a_back(place, by_cosine(normal, k, side, [0.5; 2])))
    }

    fn add(&self, weights: &[DVec3; 3], back: bool, size: f64, gathered: &mut Vec<(Key, Piece)>) {
        let piece = self.piece(weights, back);
        let (area, normal) = area_and_normal(&piece);
        let center = (piece[0] + piece[1] + piece[2]) / 3.0;
        let at = (weights[0] + weights[1] + weights[2]) / 3.0;
        let fragment = Fragment {
            mesh: self.mesh,
            material: self.material(),
            placement: self.placement,
            textures: self.textures,
            vertices: self.vertices,
            weights: Weights { at, dx: DVec3::ZERO, dy: DVec3::ZERO },
            face: Face { front: if back { -normal } else { normal }, back },
            to_viewer: normal,
        };
        let surface = fragment.surface(center);
        if matches!(self.material().alpha, AlphaMode::Mask(cutoff) if surface.alpha < f64::from(cutoff)) {
            return;
        }
        let piece = Piece {
            corners: piece,
            source: self.index,
            area,
            normal,
            reflectance: surface.base_color * (1.0 - surface.metallic),
            emission: surface.emissive,
        };
        gathered.push((key(center, normal, size, self.mesh.material), piece));
    }
}
