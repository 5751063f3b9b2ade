use glam::{DMat4, Vec3};

use super::*;
use crate::scene::lighting::{Attenuation, LightRules, Lighting, ResolvedLight};
use crate::scene::shading::Shading;
use crate::scene::{Camera, Instance, LightKind, Material, Mesh, Projection, Scene, builtin};

fn lighting(lights: Vec<ResolvedLight>) -> Lighting {
    Lighting {
        lights,
        ambient: Vec3::ZERO,
        attenuation: Attenuation::PHYSICAL,
        absent: 0,
        unbounded: 0,
        default_light: false,
    }
}

fn traced(scene: &Scene, size: [u32; 2], lighting: &Lighting, paths: Paths) -> Bounced {
    let view = View::new(&scene.cameras[0], size[0], size[1]).expect("a good camera");
    let shader = Shader::new(lighting, &view, Shading::Lambert);
    Reference::new(scene, &view).expect("a reference").bounced(&shader, paths, &|_| {})
}

fn mean(bounced: &Bounced) -> f64 {
    bounced.rgb.iter().flatten().sum::<f64>() / (bounced.rgb.len() * 3) as f64
}

/// A square of 1 m about the origin in the plane z = 0, seen from +z.
fn square(material: usize) -> Mesh {
    Mesh {
        positions: vec![[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
        ..Mesh::default()
    }
}

/// A small dark square that a square of 1 m, 1 m in front of it, shines on with radiance 1; the eye looks past the edge of that.
fn below_an_emitter(emitter: Material) -> Scene {
    let grey = Material { base_color: [0.8, 0.8, 0.8, 1.0], metallic: 0.0, ..Material::default() };
    let facing = DMat4::from_translation(DVec3::Z) * DMat4::from_rotation_x(std::f64::consts::PI);
    Scene {
        name: "below an emitter".into(),
        meshes: vec![square(0), square(1)],
        materials: vec![grey, emitter],
        instances: vec![
            Instance { mesh: 0, object_to_world: DMat4::from_scale(DVec3::new(0.02, 0.02, 1.0)) },
            Instance { mesh: 1, object_to_world: facing },
        ],
        cameras: vec![Camera {
            name: "eye".into(),
            camera_to_world: DMat4::from_translation(DVec3::Z * 0.5),
            projection: Projection::Orthographic { xmag: 0.009, ymag: 0.009, znear: 0.0, zfar: 2.0 },
        }],
        ..Scene::default()
    }
}

fn emitter() -> Material {
    Material { base_color: [0.0, 0.0, 0.0, 1.0], metallic: 0.0, emissive: [1.0; 3], ..Material::default() }
}

/// Share of what leaves a place that meets a unit square in front of it, 1 m away: four times Howell's configuration factor of a corner (B-3),
/// 1 / (2 pi) (X / sqrt(1 + X^2) atan(Y / sqrt(1 + X^2)) + the same turned round) with X = Y = 1/2.
fn share_of_square() -> f64 {
    let side = 0.5 / 1.25f64.sqrt();
    4.0 * 2.0 * side * side.atan() / std::f64::consts::TAU
}

#[test]
fn a_place_below_an_emitter_has_the_closed_form() {
    let paths = Paths { count: 4000, seed: 1 };
    let found = mean(&traced(&below_an_emitter(emitter()), [4, 4], &lighting(Vec::new()), paths));
    let exact = 0.8 * share_of_square();
    // A path meets the square or does not: the deviation of 64,000 of them is 0.8 sqrt(f (1 - f) / 64000) = 1.4e-3.
    assert!((found - exact).abs() < 5e-3, "{found} for {exact}");
}

#[test]
fn the_back_of_a_surface_sends_nothing_and_glass_stands_in_nobodys_way() {
    let paths = Paths { count: 500, seed: 1 };
    let mut turned = below_an_emitter(emitter());
    turned.instances[1].object_to_world = DMat4::from_translation(DVec3::Z);
    let found = |scene: &Scene| mean(&traced(scene, [4, 4], &lighting(Vec::new()), paths));
    assert_eq!(found(&turned), 0.0);
    turned.materials[1].double_sided = true;
    assert!((found(&turned) - 0.8 * share_of_square()).abs() < 0.015);
    let glass = Material { alpha: AlphaMode::Blend, ..emitter() };
    assert_eq!(found(&below_an_emitter(glass)), 0.0);
}

#[test]
fn a_white_furnace_has_radiance_one() {
    let rules = LightRules { emission_lights: true, ..LightRules::default() };
    for (albedo, count, most) in [(0.5, 200, 0.004), (0.9, 300, 0.02)] {
        let scene = builtin::load(&format!("furnace:albedo={albedo}")).expect("a built-in scene");
        let lighting = Lighting::new(&scene, &rules).expect("rules");
        assert!(lighting.lights.is_empty(), "a scene that emits needs no default light");
        let bounced = traced(&scene, [12, 12], &lighting, Paths { count, seed: 3 });
        let whole = mean(&bounced) + (1.0 - albedo);
        assert!((whole - 1.0).abs() < most, "albedo {albedo}: {whole}");
        assert!(bounced.rgb.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    }
}

#[test]
fn many_lights_send_what_one_of_their_sum_does() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let lamp = |intensity: f64| ResolvedLight {
        kind: LightKind::Point,
        position: DVec3::from_array(scene.lights[0].position.to_array()),
        direction: DVec3::NEG_Z,
        intensity: DVec3::splat(intensity),
        range: f64::INFINITY,
        shadow: false,
    };
    let paths = Paths { count: 64, seed: 9 };
    let one = traced(&scene, [24, 24], &lighting(vec![lamp(16.0)]), paths);
    let many = traced(&scene, [24, 24], &lighting(vec![lamp(1.0); 16]), Paths { seed: 10, ..paths });
    let apart = (mean(&one) - mean(&many)).abs() / mean(&one);
    assert!(apart < 0.03, "{apart}");
}

#[test]
fn the_same_seed_is_the_same_picture_and_errors_are_those_that_are_found() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let lights = Lighting::new(&scene, &LightRules::default()).expect("rules");
    let of = |count: u32, seed: u64| traced(&scene, [16, 16], &lights, Paths { count, seed });
    assert_eq!(of(8, 5), of(8, 5));
    assert_ne!(of(8, 5).rgb, of(8, 6).rgb);
    assert_eq!(of(1, 5).standard_error, None);
    // The error that is said against the one that many more paths show.
    let (few, many) = (of(16, 1), of(1024, 2));
    let squares: f64 = few.rgb.iter().flatten().zip(many.rgb.iter().flatten()).map(|(a, b)| (a - b).powi(2)).sum();
    let found = (squares / (few.rgb.len() * 3) as f64).sqrt() / mean(&few);
    let said = few.standard_error.expect("two halves");
    assert!((0.6..1.6).contains(&(said / found)), "{said} for {found}");
    assert!(many.standard_error.expect("two halves") < said / 4.0);
}
