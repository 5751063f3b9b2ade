//! Closed forms, sides, clipping, masks and blending.

use std::f64::consts::PI;

use glam::{DMat4, Vec3};

use super::*;
use crate::scene::lighting::{Attenuation, Lighting, ResolvedLight};
use crate::scene::shading::Shading;
use crate::scene::{Camera, IDENTITY_UV, Image, Instance, LightKind, Material, Mesh, Projection, Sampler, Texture};

const PERSPECTIVE: Projection = Projection::Perspective { yfov: PI / 2.0, aspect: None, znear: 0.1, zfar: Some(50.0) };

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
        shadow: false,
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
