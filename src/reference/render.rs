//! The reference picture: one ray through each pixel's centre, f64 throughout. Blended surfaces are mixed in the order in which the ray
//! meets them, whatever a rasteriser's draws were sorted by.

mod bounced;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, DVec4};
use rayon::prelude::*;

use super::bvh::Bvh;
use super::ray::{Crossing, Ray, plane_weights};
use super::shade::Shader;
use super::smooth::Groups;
use super::surface::{Face, Fragment, Placement, Surface, Weights};
use super::texture::Textures;
use crate::error::{Error, Result};
use crate::math::samples::locations;
use crate::scene::view::View;
use crate::scene::{AlphaMode, Material, Scene};

pub use bounced::{Bounced, Paths};

/// A scene prepared for one view: triangles in view space, their hierarchy, decoded textures.
pub struct Reference<'a> {
    scene: &'a Scene,
    view: View,
    textures: Textures,
    /// One an instance.
    placements: Vec<Placement>,
    bvh: Bvh,
    /// One a triangle of the hierarchy.
    owners: Vec<Owner>,
    any_blended: bool,
    /// Views whose pixels have the places of samples in their middle; empty for one sample a pixel.
    sample_views: Vec<View>,
}

#[derive(Debug, Clone, Copy)]
struct Owner {
    instance: u32,
    /// Of the instance's mesh.
    triangle: u32,
    /// Smooth group, counted over all instances.
    group: u32,
}

/// What the ray through a pixel's centre meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The point.
    pub surface: Surface,
    /// Counted over all instances in their order.
    pub triangle: u32,
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Distance along -Z, metres.
    pub depth: f64,
}

/// A reference picture, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Linear RGB radiance; alpha is 1 on an opaque surface, what blended ones cover before the sky, and everything is 0 elsewhere.
    pub rgba: Vec<[f64; 4]>,
    /// Distance of the opaque surface along -Z in metres, infinite where none is.
    pub depth: Vec<f64>,
    /// Smooth group of an instance (see `reference::smooth`), counted over all instances; `u32::MAX` where nothing is. Blended surfaces
    /// in front are mixed into the number.
    pub surface_id: Vec<u32>,
}

/// An element of each of a [`Picture`]'s three lists.
type Pixel = ([f64; 4], f64, u32);

impl<'a> Reference<'a> {
    /// Prepares a validated scene.
    ///
    /// # Errors
    /// More triangles than 32 bits can count; an image whose bytes do not fit its size.
    pub fn new(scene: &'a Scene, view: &View) -> Result<Self> {
        let count = scene.triangle_count();
        if count >= u32::MAX as usize {
            return Err(Error::new(format!("{count} triangles: the reference renderer takes fewer than {}", u32::MAX)));
        }
        let to_view = &view.world_to_view;
        let placements: Vec<Placement> =
            scene.instances.iter().map(|i| Placement::new(&i.object_to_world, to_view)).collect();
        let groups: Vec<Groups> = scene.meshes.par_iter().map(Groups::new).collect();
        let mut corners = Vec::with_capacity(count);
        let mut owners = Vec::with_capacity(count);
        let mut first_group = 0;
        for (id, (instance, placement)) in scene.instances.iter().zip(&placements).enumerate() {
            let mesh = &scene.meshes[instance.mesh];
            let to_view = |p: &[f32; 3]| placement.object_to_view.transform_point3(DVec3::from_array(p.map(f64::from)));
            let positions: Vec<DVec3> = mesh.positions.iter().map(to_view).collect();
            let groups = &groups[instance.mesh];
            for (triangle, vertices) in mesh.indices.chunks_exact(3).enumerate() {
                corners.push([0, 1, 2].map(|k| positions[vertices[k] as usize]));
                let group = first_group + groups.of_triangle[triangle];
                owners.push(Owner { instance: id as u32, triangle: triangle as u32, group });
            }
            first_group += groups.count;
        }
        Ok(Self {
            scene,
            view: view.clone(),
            textures: Textures::new(scene)?,
            placements,
            bvh: Bvh::new(corners),
            owners,
            sample_views: Vec::new(),
            any_blended: scene.materials.iter().any(|material| material.alpha == AlphaMode::Blend),
        })
    }

    /// The same with a ray for each of so many samples of a pixel: colours are their mean, the rest is that of the centre.
    pub fn of_samples(mut self, samples: u32) -> Self {
        let moved = |place: &[u32; 2]| {
            let [x, y] = place.map(|sixteenths| f64::from(sixteenths) / 16.0 - 0.5);
            self.view.moved(x, y)
        };
        self.sample_views = if samples == 1 { Vec::new() } else { locations(samples).iter().map(moved).collect() };
        self
    }

    /// The opaque surface under the centre of a pixel, row 0 at the top.
    pub fn surface(&self, x: u32, y: u32) -> Option<Hit> {
        self.surface_in(&self.view, [x, y])
    }

    fn surface_in(&self, view: &View, at: [u32; 2]) -> Option<Hit> {
        let ray = ray(view, at);
        let exists = |crossing: &Crossing| !self.blends(crossing) && self.exists(view, at, ray.direction, crossing);
        let crossing = self.bvh.nearest(&ray, exists)?;
        Some(self.hit(view, at, &ray, &crossing))
    }

    /// The blended surfaces in front of the opaque one, farthest first.
    pub fn blended(&self, x: u32, y: u32) -> Vec<Hit> {
        self.blended_in(&self.view, [x, y])
    }

    fn blended_in(&self, view: &View, at: [u32; 2]) -> Vec<Hit> {
        if !self.any_blended {
            return Vec::new();
        }
        let mut ray = ray(view, at);
        ray.max = self.surface_in(view, at).map_or(ray.max, |opaque| opaque.depth);
        let exists = |crossing: &Crossing| self.blends(crossing) && self.exists(view, at, ray.direction, crossing);
        let mut crossings = self.bvh.all(&ray, exists);
        // A ray through an edge meets both triangles of it; the surface is there once.
        crossings.dedup_by(|b, a| self.is_same_point(&ray, a, b));
        crossings.iter().map(|crossing| self.hit(view, at, &ray, crossing)).collect()
    }

    fn is_same_point(&self, ray: &Ray, a: &Crossing, b: &Crossing) -> bool {
        let back = |crossing: &Crossing| self.face(ray.direction, crossing.triangle).back;
        let instance = |crossing: &Crossing| self.owners[crossing.triangle as usize].instance;
        let on_edge = a.weights.min_element().min(b.weights.min_element()) < 1e-9;
        on_edge && instance(a) == instance(b) && (a.t - b.t).abs() <= 1e-9 * a.t.abs() && back(a) == back(b)
    }

    fn hit(&self, view: &View, pixel: [u32; 2], ray: &Ray, crossing: &Crossing) -> Hit {
        let position = ray.origin + ray.direction * crossing.t;
        let surface = self.fragment(view, pixel, ray.direction, crossing).surface(position);
        let instance = self.owners[crossing.triangle as usize].instance;
        Hit { surface, triangle: crossing.triangle, instance, depth: crossing.t }
    }

    /// Draws the picture. `progress` gets the number of rows done so far, from any thread.
    pub fn render(&self, shader: &Shader, progress: &(dyn Fn(u64) + Sync)) -> Picture {
        let View { width, height, .. } = self.view;
        let done = AtomicU64::new(0);
        let row = |y: u32| {
            let row: Vec<Pixel> = (0..width).map(|x| self.sampled([x, y], shader)).collect();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            row
        };
        let rows: Vec<Vec<Pixel>> = (0..height).into_par_iter().map(row).collect();
        let pixels = width as usize * height as usize;
        let mut picture = Picture {
            width,
            height,
            rgba: Vec::with_capacity(pixels),
            depth: Vec::with_capacity(pixels),
            surface_id: Vec::with_capacity(pixels),
        };
        for (rgba, depth, surface_id) in rows.into_iter().flatten() {
            picture.rgba.push(rgba);
            picture.depth.push(depth);
            picture.surface_id.push(surface_id);
        }
        picture
    }

    /// The mean of a pixel's samples.
    fn sampled(&self, at: [u32; 2], shader: &Shader) -> Pixel {
        let (centre, depth, id) = self.mixed(&self.view, at, shader);
        if self.sample_views.is_empty() {
            return (centre, depth, id);
        }
        let of = |view: &View| DVec4::from_array(self.mixed(view, at, shader).0);
        let mean = self.sample_views.iter().map(of).sum::<DVec4>() / self.sample_views.len() as f64;
        (mean.to_array(), depth, id)
    }

    /// The opaque surface of a pixel with the blended ones over it.
    fn mixed(&self, view: &View, at: [u32; 2], shader: &Shader) -> Pixel {
        let opaque = self.pixel(self.surface_in(view, at), shader);
        self.blended_in(view, at).iter().fold(opaque, |(rgba, depth, id), hit| {
            let alpha = hit.surface.alpha.clamp(0.0, 1.0);
            let color = (self.radiance(shader, hit) * alpha).extend(alpha);
            let mixed = color + DVec4::from_array(rgba) * (1.0 - alpha);
            // FNV-1a's step: which surfaces, and in which order.
            let group = self.owners[hit.triangle as usize].group;
            (mixed.to_array(), depth, (id ^ group).wrapping_mul(16_777_619))
        })
    }

    /// What leaves a surface towards the eye; rays look for what stands between it and lights that have shadows.
    fn radiance(&self, shader: &Shader, hit: &Hit) -> DVec3 {
        let position = hit.surface.position;
        let blocked = |way: DVec3, ends: bool| {
            let ray = Ray {
                origin: position,
                direction: way,
                // What the crossing of the ray through the pixel may be off by, and far less than anything that stands apart.
                min: 1e-7 * (1.0 + position.length() / way.length()),
                // A light may lie on a surface.
                max: if ends { 1.0 - 1e-7 } else { f64::INFINITY },
            };
            self.bvh.any(&ray, |crossing| self.stands_in_way(crossing, way))
        };
        shader.radiance_past(&hit.surface, &blocked)
    }

    fn pixel(&self, hit: Option<Hit>, shader: &Shader) -> Pixel {
        match hit {
            Some(hit) => {
                let rgba = self.radiance(shader, &hit).extend(1.0).to_array();
                (rgba, hit.depth, self.owners[hit.triangle as usize].group)
            }
            None => ([0.0; 4], f64::INFINITY, u32::MAX),
        }
    }

    fn material(&self, crossing: &Crossing) -> &Material {
        let instance = &self.scene.instances[self.owners[crossing.triangle as usize].instance as usize];
        &self.scene.materials[self.scene.meshes[instance.mesh].material]
    }

    fn blends(&self, crossing: &Crossing) -> bool {
        self.any_blended && self.material(crossing).alpha == AlphaMode::Blend
    }

    /// False for the back of a single-sided material and for what the alpha mask cuts out.
    fn exists(&self, view: &View, pixel: [u32; 2], direction: DVec3, crossing: &Crossing) -> bool {
        let material = self.material(crossing);
        if !material.double_sided && self.face(direction, crossing.triangle).back {
            return false;
        }
        match material.alpha {
            AlphaMode::Mask(cutoff) => self.fragment(view, pixel, direction, crossing).base().w >= f64::from(cutoff),
            AlphaMode::Opaque | AlphaMode::Blend => true,
        }
    }

    fn face(&self, direction: DVec3, triangle: u32) -> Face {
        let instance = self.owners[triangle as usize].instance as usize;
        Face::new(self.bvh.corners(triangle), self.placements[instance].mirrored, direction)
    }

    fn fragment(&self, view: &View, pixel: [u32; 2], direction: DVec3, crossing: &Crossing) -> Fragment<'_> {
        let to_viewer = if view.lens.is_perspective() { -direction.normalize() } else { DVec3::Z };
        self.fragment_of(crossing, direction, self.weights(view, pixel, crossing), to_viewer)
    }

    fn fragment_of(&self, crossing: &Crossing, direction: DVec3, weights: Weights, to_viewer: DVec3) -> Fragment<'_> {
        let Owner { instance, triangle, .. } = self.owners[crossing.triangle as usize];
        let mesh = &self.scene.meshes[self.scene.instances[instance as usize].mesh];
        let first = triangle as usize * 3;
        Fragment {
            mesh,
            material: &self.scene.materials[mesh.material],
            placement: &self.placements[instance as usize],
            textures: &self.textures,
            vertices: [0, 1, 2].map(|k| mesh.indices[first + k] as usize),
            weights,
            face: self.face(direction, crossing.triangle),
            to_viewer,
        }
    }

    /// With the differences that a fragment shader's fine derivatives give: within the 2 x 2 quad that starts at even
    /// coordinates, right minus left in the pixel's own row and lower minus upper in its own column.
    fn weights(&self, view: &View, [x, y]: [u32; 2], crossing: &Crossing) -> Weights {
        let corners = self.bvh.corners(crossing.triangle);
        let toward = |i: u32| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let difference = |dx: f64, dy: f64| {
            let (origin, direction) = view.ray(f64::from(x) + dx, f64::from(y) + dy);
            (plane_weights(origin, direction, corners) - crossing.weights) * (dx + dy)
        };
        Weights { at: crossing.weights, dx: difference(toward(x), 0.0), dy: difference(0.0, toward(y)) }
    }
}

fn ray(view: &View, [x, y]: [u32; 2]) -> Ray {
    let (origin, direction) = view.ray(f64::from(x), f64::from(y));
    // The direction has z = -1 and the origin z = 0, so the parameter of the ray is the depth.
    Ray { origin, direction, min: view.znear, max: view.zfar.unwrap_or(f64::INFINITY) }
}

#[cfg(test)]
mod tests;
