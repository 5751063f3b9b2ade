//! Patches from the triangles themselves: pieces of triangles no longer than a patch is wide, gathered by where they lie, which way they look, in
//! which plane and of what they are made. Areas are true, reflectance and emission are means over the area.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::reference::render::Reference;
use crate::scene::{AlphaMode, Scene};

mod air;
mod join;
mod pieces;
mod voxels;

use pieces::{Gathered, Piece};

/// Keeps planes and corners of models off the boundaries of cells.
const OFF_GRID: f64 = 0.137;
/// Of the width of a patch: so far above a surface pieces have to see each other.
const LIFT: f64 = 0.05;
/// Widths that are tried for a number of patches.
const TRIES: usize = 8;
/// Of its radius: what lies so close to the plane of a patch lies in it.
const FLAT: f64 = 1e-9;

/// A piece of a surface whose light is one number a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Counter-clockwise from the front, world space, metres.
    pub triangles: Vec<[DVec3; 3]>,
    /// Which of the scene's triangles each is a piece of, counted over all instances; empty where they are none.
    pub sources: Vec<u32>,
    /// Square metres.
    pub area: f64,
    /// Middle of the area.
    pub center: DVec3,
    /// Unit: the mean of its triangles'.
    pub normal: DVec3,
    /// From the middle to the farthest corner, metres.
    pub radius: f64,
    /// All of it lies in one plane.
    pub flat: bool,
    /// Linear RGB, `base * (1 - metallic)`.
    pub reflectance: DVec3,
    /// Linear RGB radiance.
    pub emission: DVec3,
}

/// All patches of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    /// In the order of their cells.
    pub list: Vec<Patch>,
    /// Width of a cell, metres.
    pub size: f64,
    /// Triangles that they come from, over all instances.
    pub triangles: usize,
    /// Triangles without area, or that are no numbers.
    pub dropped: usize,
    /// Square metres left out, since they lie inside of something or right under it.
    pub buried: f64,
    /// Of the surfaces that patches stand for: square metres, and mean reflectance.
    pub surface: (f64, DVec3),
    /// Metres that patches may lie off the surfaces that they stand for.
    pub off_surface: f64,
}

/// What patches are made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatchSource {
    /// Pieces of the triangles themselves.
    #[default]
    Triangles,
    /// Sides of the cubes of a grid that surfaces pass through, as in the thesis.
    Voxels,
}

impl Patches {
    /// Patches about `size` metres wide; `occluders` are of the same scene, seen from [`View::of_world`](crate::scene::view::View::of_world). Blended surfaces let light through and unlit ones have none to give: neither has patches.
    ///
    /// # Errors
    /// A size that is no distance or cuts the scene into too many pieces; an image whose bytes do not fit its size.
    pub fn of_size(scene: &Scene, occluders: &Reference, size: f64) -> Result<Self> {
        let (gathered, mut patches) = Self::gathered(scene, occluders, size, size)?;
        patches.list = join::joined(gathered, occluders, size).iter().map(|pieces| patch(pieces)).collect();
        patches.put_in_order();
        Ok(patches)
    }

    /// Sides of cubes `size` metres wide that surfaces pass through (A. Shcherbakov, 2017): where the next cube is empty and some surface of the cube
    /// looks that way. Staircases stand for slopes, so that areas are not true; what light is reflected is the mean over the cube's surfaces.
    ///
    /// # Errors
    /// As [`Patches::of_size`].
    pub fn of_voxels(scene: &Scene, occluders: &Reference, size: f64) -> Result<Self> {
        let (gathered, mut patches) = Self::gathered(scene, occluders, size, 0.5 * size)?;
        patches.list = voxels::sides(&gathered, size);
        patches.off_surface = size;
        patches.put_in_order();
        Ok(patches)
    }

    fn put_in_order(&mut self) {
        let low = self.list.iter().map(|patch| patch.center).fold(DVec3::INFINITY, DVec3::min);
        let size = self.size;
        self.list.sort_by_cached_key(|patch| order(patch, low, size));
    }

    /// Pieces no longer than `longest` by cells `size` metres wide, and what is said of them.
    fn gathered(scene: &Scene, occluders: &Reference, size: f64, longest: f64) -> Result<(Gathered, Self)> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Error::usage(format!("patches of {size} m have no size")));
        }
        let found = pieces::of(scene, occluders, size, longest)?;
        let mut patches = Self {
            list: Vec::new(),
            size,
            triangles: found.triangles,
            dropped: found.dropped,
            buried: found.buried,
            surface: (0.0, DVec3::ZERO),
            off_surface: 0.0,
        };
        let gathered = found.gathered;
        let all = || gathered.values().flatten();
        let area: f64 = all().map(|piece| piece.area).sum();
        let reflected: DVec3 = all().map(|piece| piece.reflectance * piece.area).sum();
        patches.surface = (area, if area > 0.0 { reflected / area } else { DVec3::ZERO });
        Ok((gathered, patches))
    }

    /// Of a width, from either source.
    ///
    /// # Errors
    /// As [`Patches::of_size`].
    pub fn of(scene: &Scene, occluders: &Reference, size: f64, source: PatchSource) -> Result<Self> {
        match source {
            PatchSource::Triangles => Self::of_size(scene, occluders, size),
            PatchSource::Voxels => Self::of_voxels(scene, occluders, size),
        }
    }

    /// About `count` patches: widths are tried until they come to as many, or to as near as some tries come.
    ///
    /// # Errors
    /// A scene without surfaces, or as [`Patches::of_size`].
    pub fn of_count(scene: &Scene, occluders: &Reference, count: usize, source: PatchSource) -> Result<Self> {
        let area = area_of(scene);
        if !(area > 0.0 && area.is_finite()) || count == 0 {
            return Err(Error::new(format!("{}: there is nothing to cut into patches", scene.name)));
        }
        // Widths that came to more, and to no more.
        let mut bracket: [Option<(f64, usize)>; 2] = [None; 2];
        let mut size = (area / count as f64).sqrt();
        let mut best: Option<Self> = None;
        for _ in 0..TRIES {
            let tried = Self::of(scene, occluders, size, source)?;
            let found = tried.list.len();
            bracket[usize::from(found <= count)] = Some((size, found));
            if best.as_ref().is_none_or(|best| found.abs_diff(count) < best.list.len().abs_diff(count)) {
                best = Some(tried);
            }
            if found.abs_diff(count) * 50 < count {
                break;
            }
            size = match bracket {
                // Numbers are about a power of widths.
                [Some((small, more)), Some((large, fewer))] if fewer > 0 => {
                    let [more, fewer, wanted] = [more, fewer, count].map(|n| (n as f64).ln());
                    small * (large / small).powf(((more - wanted) / (more - fewer)).clamp(0.1, 0.9))
                }
                [Some((small, _)), Some((large, _))] => (small * large).sqrt(),
                // As many as there are squares of that width, about.
                _ => size * (found.max(1) as f64 / count as f64).sqrt().clamp(0.5, 2.0),
            };
        }
        best.ok_or_else(|| Error::new("no width was tried"))
    }

    /// How far the area of all patches is from that of the surfaces they stand for, relative to it; and their mean reflectance from theirs, the largest
    /// of three channels.
    pub fn simplified(&self) -> [f64; 2] {
        let (area, reflectance) = self.surface;
        let own = self.area();
        if !(area > 0.0 && own > 0.0) {
            return [0.0; 2];
        }
        let mean = self.list.iter().map(|patch| patch.reflectance * patch.area).sum::<DVec3>() / own;
        [own / area - 1.0, (mean - reflectance).abs().max_element()]
    }

    /// Square metres of all patches.
    pub fn area(&self) -> f64 {
        self.list.iter().map(|patch| patch.area).sum()
    }
}

/// Square metres of what patches are made of, inside of other things or not.
fn area_of(scene: &Scene) -> f64 {
    let mut area = 0.0;
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let material = &scene.materials[mesh.material];
        if material.alpha == AlphaMode::Blend || material.unlit {
            continue;
        }
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        for vertices in mesh.indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|k| {
                let local = DVec3::from_array(mesh.positions[vertices[k] as usize].map(f64::from));
                instance.object_to_world.transform_point3(local)
            });
            let (of_triangle, _) = area_and_normal(&corners);
            area += if of_triangle.is_finite() { sides * of_triangle } else { 0.0 };
        }
    }
    area
}

fn area_and_normal([a, b, c]: &[DVec3; 3]) -> (f64, DVec3) {
    let doubled = (*b - *a).cross(*c - *a);
    (0.5 * doubled.length(), doubled.normalize_or_zero())
}

/// Metres.
fn longest([a, b, c]: &[DVec3; 3]) -> f64 {
    a.distance(*b).max(b.distance(*c)).max(c.distance(*a))
}

/// Stratum k of `side` times `side` directions about a normal, by the cosine between them; `within` is where in the stratum, 0 to 1.
pub(super) fn by_cosine(normal: DVec3, k: u32, side: u32, within: [f64; 2]) -> DVec3 {
    let squared = (f64::from(k / side) + within[0]) / f64::from(side);
    let angle = (f64::from(k % side) + within[1]) / f64::from(side) * std::f64::consts::TAU;
    let (sine, cosine) = angle.sin_cos();
    let across = normal.any_orthonormal_vector();
    let frame = DMat3::from_cols(across, normal.cross(across), normal);
    frame * DVec3::new(squared.sqrt() * cosine, squared.sqrt() * sine, (1.0 - squared).max(0.0).sqrt())
}

/// What patches are sorted by: direction, plane, and place along a curve through all of them (G. Morton, 1966). Neighbours in the list see much
/// the same, so that blocks of their form factors are alike.
fn order(patch: &Patch, low: DVec3, size: f64) -> ([i64; 3], i64, u64) {
    let code = (patch.normal * 2.0).round().to_array().map(|x| x as i64);
    let from_low = (patch.center - low) / size;
    let plane = (patch.normal.dot(from_low) * 2.0).round() as i64;
    let curve = from_low.to_array().iter().enumerate().fold(0u64, |all, (axis, x)| {
        let steps = (x * 2.0).clamp(0.0, f64::from((1 << 20) - 1)) as u64;
        (0..20).fold(all, |all, bit| all | (steps >> bit & 1) << (3 * bit + axis))
    });
    (code, plane, curve)
}

fn patch(pieces: &[Piece]) -> Patch {
    let area: f64 = pieces.iter().map(|piece| piece.area).sum();
    let mean = |of: &dyn Fn(&Piece) -> DVec3| pieces.iter().map(|piece| of(piece) * piece.area).sum::<DVec3>() / area;
    let center = mean(&|piece| (piece.corners[0] + piece.corners[1] + piece.corners[2]) / 3.0);
    let normal = mean(&|piece| piece.normal).normalize_or_zero();
    let radius = pieces.iter().flat_map(|piece| piece.corners).map(|p| p.distance(center)).fold(0.0, f64::max);
    let in_plane = |p: &DVec3| (*p - center).dot(normal).abs() <= FLAT * radius;
    Patch {
        flat: pieces.iter().flat_map(|piece| &piece.corners).all(in_plane),
        triangles: pieces.iter().map(|piece| piece.corners).collect(),
        sources: pieces.iter().map(|piece| piece.source).collect(),
        area,
        center,
        normal,
        radius,
        reflectance: mean(&|piece| piece.reflectance),
        emission: mean(&|piece| piece.emission),
    }
}

#[cfg(test)]
mod tests;
