//! The reference picture: one ray through each pixel's centre, f64 throughout. Blended surfaces are mixed in the order in which the ray
//! meets them, whatever a rasteriser's draws were sorted by.

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
            let color = (shader.radiance(&hit.surface) * alpha).extend(alpha);
            let mixed = color + DVec4::from_array(rgba) * (1.0 - alpha);
            // FNV-1a's step: which surfaces, and in which order.
            let group = self.owners[hit.triangle as usize].group;
            (mixed.to_array(), depth, (id ^ group).wrapping_mul(16_777_619))
        })
    }

    fn pixel(&self, hit: Option<Hit>, shader: &Shader) -> Pixel {
        match hit {
            Some(hit) => {
                let rgba = shader.radiance(&hit.surface).extend(1.0).to_array();
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
        let Owner { instance, triangle, .. } = self.owners[crossing.triangle as usize];
        let mesh = &self.scene.meshes[self.scene.instances[instance as usize].mesh];
        let first = triangle as usize * 3;
        Fragment {
            mesh,
            material: &self.scene.materials[mesh.material],
            placement: &self.placements[instance as usize],
            textures: &self.textures,
            vertices: [0, 1, 2].map(|k| mesh.indices[first + k] as usize),
            weights: self.weights(view, pixel, crossing),
            face: self.face(direction, crossing.triangle),
            to_viewer: if view.lens.is_perspective() { -direction.normalize() } else { DVec3::Z },
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
mod tests {
    use std::f64::consts::PI;

    use glam::{DMat4, Vec3};

    use super::*;
    use crate::scene::lighting::{Attenuation, Lighting, ResolvedLight};
    use crate::scene::shading::Shading;
    use crate::scene::{Camera, IDENTITY_UV, Image, Instance, LightKind, Material, Mesh, Projection, Sampler, Texture};

    const PERSPECTIVE: Projection =
        Projection::Perspective { yfov: PI / 2.0, aspect: None, znear: 0.1, zfar: Some(50.0) };

    fn view(projection: Projection, width: u32, height: u32) -> View {
        let camera = Camera { name: "test".into(), camera_to_world: DMat4::IDENTITY, projection };
        View::new(&camera, width, height).expect("a good camera")
    }

    /// A square of side 2 in the plane z = 0, seen from +z; (0, 0) of its texture is the upper left corner.
    fn square() -> Mesh {
        Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], Vec::new()],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..Mesh::default()
        }
    }

    fn scene(material: Material, transforms: &[DMat4]) -> Scene {
        let instances = transforms.iter().map(|&object_to_world| Instance { mesh: 0, object_to_world }).collect();
        Scene { meshes: vec![square()], materials: vec![material], instances, ..Scene::default() }
    }

    fn away(z: f64) -> DMat4 {
        DMat4::from_translation(DVec3::new(0.0, 0.0, -z))
    }

    fn lighting(ambient: f32, lights: Vec<ResolvedLight>) -> Lighting {
        Lighting {
            lights,
            ambient: Vec3::splat(ambient),
            attenuation: Attenuation::PHYSICAL,
            absent: 0,
            unbounded: 0,
            default_light: false,
        }
    }

    fn draw(scene: &Scene, view: &View, lighting: &Lighting) -> Picture {
        let reference = Reference::new(scene, view).expect("a good scene");
        reference.render(&Shader::new(lighting, view, Shading::Lambert), &|_| ())
    }

    fn hit(scene: &Scene, projection: Projection) -> Option<Hit> {
        Reference::new(scene, &view(projection, 9, 9)).expect("a good scene").surface(4, 4)
    }

    #[test]
    fn a_plane_under_a_point_light_is_the_closed_form() {
        let material = Material { base_color: [0.5; 4], metallic: 0.0, ..Material::default() };
        let scene = scene(material, &[away(2.0) * DMat4::from_scale(DVec3::splat(4.0))]);
        let lamp = DVec3::new(0.5, -0.25, -1.25);
        let light = ResolvedLight {
            kind: LightKind::Point,
            position: lamp,
            direction: DVec3::NEG_Z,
            intensity: DVec3::splat(3.0),
            range: f64::INFINITY,
        };
        let view = view(PERSPECTIVE, 12, 8);
        let picture = draw(&scene, &view, &lighting(0.0, vec![light]));
        for (x, y) in (0..8).flat_map(|y| (0..12).map(move |x| (x, y))) {
            let p = view.image_point(f64::from(x), f64::from(y)) * 2.0;
            let to_lamp = lamp - DVec3::new(p.x, p.y, -2.0);
            let expected = 3.0 * 0.75 / to_lamp.length().powi(3) * 0.5 / PI;
            let found = picture.rgba[(y * 12 + x) as usize];
            assert!((found[1] - expected).abs() < 1e-12 && found[3] == 1.0, "{x} {y}: {found:?} {expected}");
            assert!((picture.depth[(y * 12 + x) as usize] - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn emission_and_ambient_furnaces() {
        let glowing = Material { emissive: [2.0; 3], ..Material::default() };
        let picture = draw(&scene(glowing, &[away(1.5)]), &view(PERSPECTIVE, 16, 16), &lighting(0.0, Vec::new()));
        let covered = picture.rgba.iter().filter(|&&p| p == [2.0, 2.0, 2.0, 1.0]).count();
        let empty = picture.rgba.iter().filter(|&&p| p == [0.0; 4]).count();
        // tan 45 degrees shows 3 x 3 m at 1.5 m; pixels of 3/16 m: |i - 7.5| * 3/16 < 1 for 10 columns.
        assert_eq!((covered, empty), (100, 156));
        assert_eq!(picture.depth.iter().filter(|d| d.is_infinite()).count(), empty);
        assert_eq!(picture.surface_id.iter().filter(|&&id| id == u32::MAX).count(), empty);
        let white = scene(Material::default(), &[away(0.5)]);
        let picture = draw(&white, &view(PERSPECTIVE, 4, 4), &lighting(1.0, Vec::new()));
        assert!(picture.rgba.iter().all(|&p| p == [1.0; 4]));
    }

    #[test]
    fn sides_and_mirrors() {
        let turned = away(3.0) * DMat4::from_rotation_y(PI);
        let mirrored = away(3.0) * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let mirrored_through = away(3.0) * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
        for (transform, front) in [(away(3.0), true), (turned, false), (mirrored, true), (mirrored_through, false)] {
            let single = hit(&scene(Material::default(), &[transform]), PERSPECTIVE);
            assert_eq!(single.is_some(), front, "{transform}");
            let material = Material { double_sided: true, ..Material::default() };
            let double = hit(&scene(material, &[transform]), PERSPECTIVE).expect("a hit");
            assert!((double.surface.normal - DVec3::Z).length() < 1e-12, "{}", double.surface.normal);
        }
        // A single-sided back does not hide what is behind it.
        let behind = hit(&scene(Material::default(), &[turned, away(4.0)]), PERSPECTIVE).expect("a hit");
        assert_eq!((behind.instance, behind.triangle / 2), (1, 1));
        assert!((behind.depth - 4.0).abs() < 1e-12);
    }

    #[test]
    fn near_and_far_clip_in_both_projections() {
        let parallel = Projection::Orthographic { xmag: 2.0, ymag: 2.0, znear: -1.0, zfar: 5.0 };
        let depth = |z: f64, projection| hit(&scene(Material::default(), &[away(z)]), projection).map(|h| h.depth);
        assert_eq!([-1.5, 5.5].map(|z| depth(z, parallel)), [None, None]);
        assert_eq!([-0.5, 0.0, 4.5].map(|z| depth(z, parallel)), [-0.5, 0.0, 4.5].map(Some));
        assert_eq!([0.05, 51.0, -1.0].map(|z| depth(z, PERSPECTIVE)), [None; 3]);
        assert!(depth(0.2, PERSPECTIVE).is_some_and(|d| (d - 0.2).abs() < 1e-15));
        let off_centre = Reference::new(&scene(Material::default(), &[away(2.0)]), &view(parallel, 8, 8))
            .expect("a good scene")
            .surface(5, 2);
        assert_eq!(off_centre.map(|h| h.surface.position), Some(DVec3::new(0.75, 0.75, -2.0)));
    }

    /// 8 x 8 texels: the left half has alpha 0, the right half alpha 1.
    fn half_masked() -> (Image, Texture) {
        let rgba8 = (0..64).flat_map(|i| [255, 255, 255, if i % 8 < 4 { 0 } else { 255 }]).collect();
        let sampler = Sampler { mag_linear: false, min_linear: false, mipmapped: false, ..Sampler::default() };
        let image = Image { name: "mask".into(), width: 8, height: 8, rgba8 };
        (image, Texture { image: 0, sampler, uv_set: 0, uv_transform: IDENTITY_UV })
    }

    #[test]
    fn a_masked_fragment_does_not_exist() {
        let (image, texture) = half_masked();
        let mut material =
            Material { base_color_texture: Some(texture), alpha: AlphaMode::Mask(0.5), ..Material::default() };
        let drawn = |material: &Material| {
            let scene = Scene { images: vec![image.clone()], ..scene(material.clone(), &[away(0.5), away(0.75)]) };
            let view = view(PERSPECTIVE, 4, 4);
            let reference = Reference::new(&scene, &view).expect("a good scene");
            [0, 3].map(|x| reference.surface(x, 1).map(|hit| hit.instance))
        };
        assert_eq!(drawn(&material), [None, Some(0)]);
        material.alpha = AlphaMode::Opaque;
        assert_eq!(drawn(&material), [Some(0), Some(0)]);
        material.alpha = AlphaMode::Blend;
        assert_eq!(drawn(&material), [None, None]);
    }

    #[test]
    fn blended_surfaces_are_mixed_in_the_order_of_the_ray() {
        let pane = |red: f32| Material {
            base_color: [red, 0.0, 0.0, 0.25],
            alpha: AlphaMode::Blend,
            unlit: true,
            ..Material::default()
        };
        let wall = Material { base_color: [0.5, 0.5, 0.5, 1.0], unlit: true, ..Material::default() };
        // The scene's order is not the ray's, and one pane stands behind the wall.
        let mut scene = scene(pane(0.4), &[away(0.3), away(0.6), away(0.9), away(0.5)]);
        scene.materials.extend([pane(0.8), wall]);
        for (mesh, material) in [(1, 1), (2, 2)] {
            scene.meshes.push(Mesh { material, ..square() });
            scene.instances[mesh].mesh = mesh;
        }
        scene.instances[0].object_to_world = away(0.95);
        let view = view(PERSPECTIVE, 3, 3);
        let reference = Reference::new(&scene, &view).expect("a good scene");
        let depths: Vec<f64> = reference.blended(1, 1).iter().map(|hit| hit.depth).collect();
        assert_eq!(depths, [0.6, 0.5]);
        let picture = draw(&scene, &view, &lighting(0.0, Vec::new()));
        let behind = 0.5 * 0.75 + 0.8 * 0.25;
        let [red, green, _, alpha] = picture.rgba[4];
        assert!((red - (behind * 0.75 + 0.4 * 0.25)).abs() < 1e-7 && (green - 0.5 * 0.75 * 0.75).abs() < 1e-7);
        assert!((alpha - 1.0).abs() < 1e-15 && picture.depth[4] == 0.9);
    }

    #[test]
    fn weights_have_the_quads_fine_differences() {
        let scene = scene(Material::default(), &[away(0.9) * DMat4::from_rotation_y(0.5)]);
        let view = view(PERSPECTIVE, 6, 6);
        let reference = Reference::new(&scene, &view).expect("a good scene");
        let weights = |x: u32, y: u32| {
            let (origin, direction) = view.ray(f64::from(x), f64::from(y));
            let corners = reference.bvh.corners(0);
            let crossing = Crossing { triangle: 0, t: 0.0, weights: plane_weights(origin, direction, corners) };
            reference.weights(&reference.view, [x, y], &crossing)
        };
        let [left, right, next] = [2, 3, 4].map(|x| weights(x, 3));
        assert!((left.dx - (right.at - left.at)).length() < 1e-12);
        assert!((left.dx - right.dx).length() < 1e-12);
        assert!((next.dx - right.dx).length() > 1e-6, "perspective changes the difference from quad to quad");
        assert!((right.dy - (right.at - weights(3, 2).at)).length() < 1e-12);
        assert!((weights(3, 2).dy - right.dy).length() < 1e-12);
    }
}
