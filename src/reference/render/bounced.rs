//! Diffuse bounced light by path tracing: what did not come straight from a punctual light (J. T. Kajiya, "The Rendering Equation", 1986).
//!
//! Surfaces are Lambert with the reflectance `base * (1 - metallic)`, whatever the picture's shading is. A path leaves a surface by the cosine of its
//! normal; at every surface it meets it takes the light that punctual lights send there, each past what stands in its way. Of more than
//! [`FEW_LIGHTS`] one is chosen by what it would send unhindered. Emission is found both by the way a path takes and by a place that is drawn on
//! what emits, weighted by how likely either was (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995,
//! the balance heuristic). From the fourth surface on a path goes on by chance (Russian roulette), so that nothing is cut off. The back of a single-sided surface takes light and sends none; blended surfaces let it through.
//!
//! Not in it: mirrors and gloss, and `--ambient`, which is no light of the scene.

mod emitters;

use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{Hit, Reference};
use crate::math::random::Random;
use crate::reference::ray::{Crossing, Ray};
use crate::reference::shade::Shader;
use crate::reference::surface::{Fragment, Surface, Weights};
use crate::scene::AlphaMode;
use crate::scene::view::View;
use emitters::Emitters;

/// As many lights are all looked at from every surface.
const FEW_LIGHTS: usize = 4;
/// Surfaces of a path before chance ends it.
const SURE_SURFACES: u32 = 3;
/// Most likely a path goes on: where nothing absorbs it would not end.
const MOST_LIKELY: f64 = 0.95;

/// What paths are drawn by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Paths {
    /// Of each pixel, at least 1.
    pub count: u32,
    /// Every seed is as good as another.
    pub seed: u64,
}

/// Bounced light of a picture, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounced {
    /// Linear RGB radiance towards the eye, to be added to that without it.
    pub rgb: Vec<[f64; 3]>,
    /// Standard error of the picture's pixels, root mean square over its mean, from two halves of the paths; `None` of a single path.
    pub standard_error: Option<f64>,
}

/// What lights the scene.
struct Light<'a> {
    shader: &'a Shader<'a>,
    emitters: &'a Emitters,
}

/// A surface that a path stands on.
#[derive(Clone, Copy)]
struct Stand {
    surface: Surface,
    /// Unit, on the side that the path is on.
    geometric: DVec3,
    /// It reflects and emits.
    active: bool,
}

impl Stand {
    fn reflectance(&self) -> DVec3 {
        let surface = &self.surface;
        if self.active && !surface.unlit { surface.base_color * (1.0 - surface.metallic) } else { DVec3::ZERO }
    }
}

impl Reference<'_> {
    /// Traces the bounced light of every pixel. `progress` gets the number of rows done so far, from any thread. The same numbers wherever and on
    /// however many cores.
    pub fn bounced(&self, shader: &Shader, paths: Paths, progress: &(dyn Fn(u64) + Sync)) -> Bounced {
        let View { width, height, .. } = self.view;
        let done = AtomicU64::new(0);
        let light = &Light { shader, emitters: &Emitters::new(self) };
        let row = |y: u32| -> Vec<[DVec3; 2]> {
            let row = (0..width).map(|x| self.halves([x, y], light, paths)).collect();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            row
        };
        let pixels: Vec<[DVec3; 2]> = (0..height).into_par_iter().flat_map_iter(row).collect();
        let [first, second] = [paths.count.div_ceil(2), paths.count / 2].map(f64::from);
        let rgb = pixels.iter().map(|[a, b]| ((*a + *b) / (first + second)).to_array()).collect();
        let standard_error = (paths.count > 1).then(|| standard_error(&pixels, [first, second]));
        Bounced { rgb, standard_error }
    }

    /// Something that stops light lies between two points, world space where the view is [`View::of_world`]; neither end counts.
    pub fn is_blocked(&self, from: DVec3, to: DVec3) -> bool {
        // No scene has so many triangles.
        self.is_blocked_past(from, to, [u32::MAX; 2])
    }

    /// The same past two triangles, such as those that both points lie on.
    pub fn is_blocked_past(&self, from: DVec3, to: DVec3, past: [u32; 2]) -> bool {
        let way = to - from;
        let min = 1e-7 * (1.0 + from.length() / way.length());
        let ray = Ray { origin: from, direction: way, min, max: 1.0 - min };
        self.bvh.any(&ray, |crossing| !past.contains(&crossing.triangle) && self.stands_in_way(crossing, way))
    }

    /// The hierarchy of all triangles.
    pub fn hierarchy(&self) -> &super::Bvh {
        &self.bvh
    }

    /// Whether a triangle of the hierarchy stops light: wherever it is met, nowhere, or (none) where its mask says.
    pub fn stops_light(&self, triangle: u32) -> Option<bool> {
        let instance = &self.scene.instances[self.owners[triangle as usize].instance as usize];
        match self.scene.materials[self.scene.meshes[instance.mesh].material].alpha {
            AlphaMode::Opaque => Some(true),
            AlphaMode::Blend => Some(false),
            AlphaMode::Mask(_) => None,
        }
    }

    /// What stops light between two points: a point of its plane and the plane's normal, of unit length.
    pub fn blocked_by(&self, from: DVec3, to: DVec3) -> Option<[DVec3; 2]> {
        let way = to - from;
        let min = 1e-7 * (1.0 + from.length() / way.length());
        let ray = Ray { origin: from, direction: way, min, max: 1.0 - min };
        let crossing = self.bvh.nearest(&ray, |crossing| self.stands_in_way(crossing, way))?;
        let [a, b, c] = self.bvh.corners(crossing.triangle);
        Some([from + way * crossing.t, (b - a).cross(c - a).normalize_or_zero()])
    }

    /// Light that goes this way meets a surface on a side that may send it on.
    pub fn meets_a_patch(&self, from: DVec3, direction: DVec3) -> bool {
        self.met(from, direction).is_some_and(|(stand, _)| stand.active && !stand.surface.unlit)
    }

    /// Light that goes this way meets the back of a surface that has none.
    pub fn meets_a_back(&self, from: DVec3, direction: DVec3) -> bool {
        self.met(from, direction).is_some_and(|(stand, _)| !stand.active)
    }

    /// Irradiance straight from punctual lights at a place of a surface, past what stands in their way; lux by channel.
    pub fn irradiance(&self, shader: &Shader, position: DVec3, normal: DVec3) -> DVec3 {
        let reaches = |way: DVec3, ends: bool| {
            let min = 1e-7 * (1.0 + position.length() / way.length());
            let ray = Ray { origin: position, direction: way, min, max: if ends { 1.0 - 1e-7 } else { f64::INFINITY } };
            !self.bvh.any(&ray, |crossing| self.stands_in_way(crossing, way))
        };
        shader.sent(position, normal).iter().filter(|s| reaches(s.way, s.ends)).map(|s| s.irradiance).sum()
    }

    /// Mean irradiance of bounced light at places with their unit normals, so many paths from each; lux by channel.
    pub fn bounced_irradiance(&self, shader: &Shader, places: &[[DVec3; 2]], paths: Paths) -> DVec3 {
        let light = &Light { shader, emitters: &Emitters::new(self) };
        let mut random = Random::new(paths.seed);
        let mut sum = DVec3::ZERO;
        for &[position, normal] in places {
            let surface = Surface { position, normal, ..Surface::default() };
            let stand = Stand { surface, geometric: normal, active: true };
            (0..paths.count).for_each(|_| sum += self.gathered(&stand, light, &mut random));
        }
        sum * PI / (places.len() as f64 * f64::from(paths.count))
    }

    /// Sums over the even and over the odd paths of a pixel.
    fn halves(&self, at: [u32; 2], light: &Light, paths: Paths) -> [DVec3; 2] {
        let pixel = u64::from(at[1]) << 32 | u64::from(at[0]);
        let mut random = Random::new(Random::new(paths.seed ^ pixel.wrapping_mul(0xD6E8_FEB8_6659_FD93)).next_u64());
        let mut halves = [DVec3::ZERO; 2];
        let views: &[View] =
            if self.sample_views.is_empty() { std::slice::from_ref(&self.view) } else { &self.sample_views };
        for (view_index, view) in views.iter().enumerate() {
            let opaque = self.surface_in(view, at);
            let blended = self.blended_in(view, at);
            let eye = |hit: &Hit| self.stand_of_hit(view, at, hit);
            for path in (view_index..paths.count as usize).step_by(views.len()) {
                let send = |hit: &Hit, random: &mut Random| self.sent(&eye(hit), light, random);
                let behind = opaque.as_ref().map_or(DVec3::ZERO, |hit| send(hit, &mut random));
                let mixed = blended.iter().fold(behind, |sum, hit| {
                    let alpha = hit.surface.alpha.clamp(0.0, 1.0);
                    send(hit, &mut random) * alpha + sum * (1.0 - alpha)
                });
                halves[path % 2] += mixed;
            }
        }
        halves
    }

    fn stand_of_hit(&self, view: &View, at: [u32; 2], hit: &Hit) -> Stand {
        let (_, direction) = view.ray(f64::from(at[0]), f64::from(at[1]));
        let face = self.face(direction, hit.triangle);
        let geometric = if face.back { -face.front } else { face.front };
        Stand { surface: hit.surface, geometric, active: true }
    }

    /// Bounced light that leaves a surface in any direction: one path.
    fn sent(&self, from: &Stand, light: &Light, random: &mut Random) -> DVec3 {
        let reflectance = from.reflectance();
        if reflectance == DVec3::ZERO { DVec3::ZERO } else { reflectance * self.gathered(from, light, random) }
    }

    /// An estimate of irradiance over pi: radiance from a direction drawn by its cosine.
    fn gathered(&self, from: &Stand, light: &Light, random: &mut Random) -> DVec3 {
        let (mut sum, mut weight, mut stand) = (DVec3::ZERO, DVec3::ONE, *from);
        for surfaces in 0u32.. {
            sum += weight * self.emitted(&stand, light.emitters, random);
            let direction = by_cosine(stand.surface.normal, random);
            // A normal that is not that of the plane sees below it, where nothing comes from.
            if direction.dot(stand.geometric) <= 0.0 {
                break;
            }
            let Some((next, triangle)) = self.met(stand.surface.position, direction) else { break };
            if !next.active {
                break;
            }
            if next.surface.emissive != DVec3::ZERO {
                let way = next.surface.position - stand.surface.position;
                let drawn =
                    light.emitters.density(triangle) * way.length_squared() / next.geometric.dot(direction).abs();
                let taken = stand.surface.normal.dot(direction) / PI;
                sum += weight * next.surface.emissive * (taken / (taken + drawn));
            }
            let reflectance = next.reflectance();
            if reflectance == DVec3::ZERO {
                break;
            }
            weight *= reflectance;
            sum += weight * self.lit(&next, light.shader, random) / PI;
            if surfaces >= SURE_SURFACES {
                let goes_on = weight.max_element().min(MOST_LIKELY);
                if random.unit_f64() >= goes_on {
                    break;
                }
                weight /= goes_on;
            }
            stand = next;
        }
        sum
    }

    /// Radiance from a place that is drawn on what emits, by its share of irradiance over pi and how likely a path would have found it.
    fn emitted(&self, at: &Stand, emitters: &Emitters, random: &mut Random) -> DVec3 {
        let Some((triangle, weights)) = emitters.draw(random) else { return DVec3::ZERO };
        let corners = self.bvh.corners(triangle);
        let place = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        let way = place - at.surface.position;
        let squared = way.length_squared();
        let direction = way / squared.sqrt();
        let cosine = at.surface.normal.dot(direction);
        if !(cosine > 0.0 && direction.dot(at.geometric) > 0.0) {
            return DVec3::ZERO;
        }
        let crossing = Crossing { triangle, t: 1.0, weights };
        let fragment = self.bare_fragment(&crossing, direction);
        let facing = -fragment.face.front.dot(direction) * if fragment.face.back { -1.0 } else { 1.0 };
        let sends = !fragment.face.back || fragment.material.double_sided;
        let seen = facing > 0.0 && sends && self.exists_bare(&fragment);
        if !seen {
            return DVec3::ZERO;
        }
        let min = 1e-7 * (1.0 + at.surface.position.length() / squared.sqrt());
        let ray = Ray { origin: at.surface.position, direction: way, min, max: 1.0 - 1e-7 };
        if self.bvh.any(&ray, |crossing| crossing.triangle != triangle && self.stands_in_way(crossing, way)) {
            return DVec3::ZERO;
        }
        let drawn = emitters.density(triangle) * squared / facing;
        let taken = cosine / PI;
        fragment.surface(place).emissive * (taken / (taken + drawn))
    }

    /// The nearest surface that light meets on its way, and its triangle.
    fn met(&self, origin: DVec3, direction: DVec3) -> Option<(Stand, u32)> {
        let ray = Ray { origin, direction, min: 1e-7 * (1.0 + origin.length()), max: f64::INFINITY };
        let crossing = self.bvh.nearest(&ray, |crossing| self.stands_in_way(crossing, direction))?;
        let fragment = self.bare_fragment(&crossing, direction);
        let surface = fragment.surface(origin + direction * crossing.t);
        let back = fragment.face.back;
        let geometric = if back { -fragment.face.front } else { fragment.face.front };
        Some((Stand { surface, geometric, active: !back || fragment.material.double_sided }, crossing.triangle))
    }

    /// Irradiance from punctual lights past what stands in their way.
    fn lit(&self, at: &Stand, shader: &Shader, random: &mut Random) -> DVec3 {
        let Surface { position, normal, .. } = at.surface;
        let reaches = |way: DVec3, ends: bool| {
            if way.dot(at.geometric) <= 0.0 {
                return false;
            }
            let min = 1e-7 * (1.0 + position.length() / way.length());
            let max = if ends { 1.0 - 1e-7 } else { f64::INFINITY };
            let ray = Ray { origin: position, direction: way, min, max };
            !self.bvh.any(&ray, |crossing| self.stands_in_way(crossing, way))
        };
        let sent = shader.sent(position, normal);
        if sent.len() <= FEW_LIGHTS {
            return sent.iter().filter(|s| reaches(s.way, s.ends)).map(|s| s.irradiance).sum();
        }
        let total: f64 = sent.iter().map(|s| s.irradiance.element_sum()).sum();
        let mut left = random.unit_f64() * total;
        let chosen = sent.iter().find(|s| {
            left -= s.irradiance.element_sum();
            left < 0.0
        });
        let Some(chosen) = chosen.or(sent.last()) else { return DVec3::ZERO };
        let share = chosen.irradiance.element_sum() / total;
        if share > 0.0 && reaches(chosen.way, chosen.ends) { chosen.irradiance / share } else { DVec3::ZERO }
    }

    /// Both faces of what is opaque, and of what a mask leaves, stand in the way of light; parallax is for the eye.
    pub(super) fn stands_in_way(&self, crossing: &Crossing, direction: DVec3) -> bool {
        match self.material(crossing).alpha {
            AlphaMode::Opaque => true,
            AlphaMode::Blend => false,
            AlphaMode::Mask(_) => self.exists_bare(&self.bare_fragment(crossing, direction)),
        }
    }

    fn exists_bare(&self, fragment: &Fragment) -> bool {
        match fragment.material.alpha {
            AlphaMode::Opaque => true,
            AlphaMode::Blend => false,
            AlphaMode::Mask(cutoff) => fragment.unshifted_base().w >= f64::from(cutoff),
        }
    }

    /// A point without a footprint: the finest level of every map.
    fn bare_fragment(&self, crossing: &Crossing, direction: DVec3) -> Fragment<'_> {
        let weights = Weights { at: crossing.weights, dx: DVec3::ZERO, dy: DVec3::ZERO };
        self.fragment_of(crossing, direction, weights, -direction.normalize())
    }
}

/// A direction about `normal`, by the cosine between them (P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and Square", 1997, without the
/// low distortion).
fn by_cosine(normal: DVec3, random: &mut Random) -> DVec3 {
    let (radius2, angle) = (random.unit_f64(), random.unit_f64() * TAU);
    let (sine, cosine) = angle.sin_cos();
    let across = normal.any_orthonormal_vector();
    let frame = DMat3::from_cols(across, normal.cross(across), normal);
    frame * DVec3::new(radius2.sqrt() * cosine, radius2.sqrt() * sine, (1.0 - radius2).max(0.0).sqrt())
}

/// Half the difference of two independent halves is a sample of the error of their mean.
fn standard_error(pixels: &[[DVec3; 2]], counts: [f64; 2]) -> f64 {
    let mean = |[a, b]: &[DVec3; 2]| (*a + *b) / (counts[0] + counts[1]);
    let apart = |[a, b]: &[DVec3; 2]| (*a / counts[0] - *b / counts[1]) * 0.5;
    let squares: f64 = pixels.iter().map(|p| apart(p).length_squared() / 3.0).sum();
    let whole: f64 = pixels.iter().map(|p| mean(p).element_sum() / 3.0).sum();
    let count = pixels.len().max(1) as f64;
    if whole > 0.0 { (squares / count).sqrt() / (whole / count) } else { 0.0 }
}

#[cfg(test)]
mod tests;
