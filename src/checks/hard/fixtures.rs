//! Small scenes: one mesh, some lights, one camera.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use crate::error::Result;
use crate::plan::{Plan, Request};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::shading::Shading;
use crate::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene};

/// Unit roundoff of f32: what one rounding can do, relatively.
pub const UNIT: f64 = 1.0 / 16_777_216.0;

/// Slices round the axis of a sphere and stacks along it.
const SPHERE: [u32; 2] = [48, 24];

/// 64 x 48 pixels; no light has a range or a window.
pub fn request(shading: Shading) -> Request {
    let rules = LightRules { range: RangeRule::Infinite, ..LightRules::default() };
    Request { width: 64, height: 48, shading, rules, ..crate::checks::forward() }
}

/// The plan of `request` on the renderer's device.
pub fn plan(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Plan> {
    Plan::new(scene, request, &renderer.limits())
}

/// `mesh` where it was modelled, in a dielectric of three different channels.
pub fn scene(mesh: Mesh, lights: Vec<Light>, camera: Camera) -> Scene {
    let material = Material { base_color: [0.8, 0.6, 0.4, 1.0], metallic: 0.0, roughness: 0.5, ..Material::default() };
    Scene {
        name: "hard case".into(),
        meshes: vec![mesh],
        materials: vec![material],
        instances: vec![Instance { mesh: 0, object_to_world: DMat4::IDENTITY }],
        lights,
        cameras: vec![camera],
        ..Scene::default()
    }
}

/// A square in the plane z = 0, `2 * half` metres wide, seen from +z.
pub fn wall(half: f64) -> Mesh {
    let h = half as f32;
    Mesh {
        name: "wall".into(),
        positions: vec![[-h, -h, 0.0], [h, -h, 0.0], [h, h, 0.0], [-h, h, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

/// A sphere about the origin, seen from outside. Its colours differ along every axis, so that no mirror image equals it.
pub fn sphere(radius: f64) -> Mesh {
    let [slices, stacks] = SPHERE;
    let mut mesh = Mesh { name: "sphere".into(), ..Mesh::default() };
    let mut add = |normal: DVec3| {
        mesh.positions.push((normal * radius).as_vec3().to_array());
        mesh.normals.push(normal.as_vec3().to_array());
        mesh.colors.push((normal * 0.4 + 0.6).extend(1.0).as_vec4().to_array());
    };
    add(DVec3::Y);
    for stack in 1..stacks {
        let (sin, cos) = (PI * f64::from(stack) / f64::from(stacks)).sin_cos();
        for slice in 0..slices {
            let (z, x) = (TAU * f64::from(slice) / f64::from(slices)).sin_cos();
            add(DVec3::new(sin * x, cos, sin * z));
        }
    }
    add(DVec3::NEG_Y);
    let at = |stack: u32, slice: u32| 1 + (stack - 1) * slices + slice % slices;
    let (top, bottom) = (0, 1 + (stacks - 1) * slices);
    for slice in 0..slices {
        mesh.indices.extend([top, at(1, slice + 1), at(1, slice)]);
        for stack in 1..stacks - 1 {
            let (a, b) = (at(stack, slice), at(stack, slice + 1));
            let (c, d) = (at(stack + 1, slice), at(stack + 1, slice + 1));
            mesh.indices.extend([a, b, c, b, d, c]);
        }
        mesh.indices.extend([bottom, at(stacks - 1, slice), at(stacks - 1, slice + 1)]);
    }
    mesh
}

/// A white point light without a range of its own.
pub fn point(position: DVec3, intensity: f32) -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Point,
        color: [1.0; 3],
        intensity,
        position,
        direction: DVec3::NEG_Z,
        range: None,
        shadow: false,
    }
}

/// A white spot light of 1 cd; angles from the axis in radians.
pub fn spot(position: DVec3, axis: DVec3, inner: f32, outer: f32) -> Light {
    Light { kind: LightKind::Spot { inner, outer }, direction: axis, ..point(position, 1.0) }
}

/// A perspective camera that looks from one place at another; vertical field of view in degrees.
pub fn looking(from: [f64; 3], at: [f64; 3], degrees: f64) -> Camera {
    Camera::looking(DVec3::from_array(from), DVec3::from_array(at), degrees.to_radians())
}

/// An orthographic camera that looks along -Z; half width and half height, near and far distance, in metres.
pub fn flat(from: [f64; 3], [xmag, ymag]: [f64; 2], [znear, zfar]: [f64; 2]) -> Camera {
    Camera {
        name: "flat".into(),
        camera_to_world: DMat4::from_translation(DVec3::from_array(from)),
        projection: Projection::Orthographic { xmag, ymag, znear, zfar },
    }
}
