//! What every procedural scene promises: sound triangles, the right way round, closed where they should be.

use std::f64::consts::TAU;

use glam::DVec3;

use super::*;
use crate::error::ErrorKind;
use crate::math::random::Random;
use crate::scene::{Material, Mesh};

const SPECS: [&str; 9] = [
    "cornell",
    "atrium",
    "atrium:detail=2",
    "corridor",
    "corridor:door=0",
    "corridor:door=0.001",
    "terrain",
    "terrain:albedo=0,detail=2",
    "furnace:albedo=0.25",
];

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64)
}

fn load_sound(spec: &str) -> Scene {
    load(spec).unwrap_or_else(|error| panic!("{spec}: {error}"))
}

/// Corners of every triangle of a mesh.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    mesh.indices.chunks_exact(3).map(move |t| [t[0], t[1], t[2]].map(|i| wide(mesh.positions[i as usize])))
}

/// Corners of every triangle of a scene, in world space.
fn world_triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    for instance in &scene.instances {
        let place = |p: DVec3| instance.object_to_world.transform_point3(p);
        all.extend(triangles(&scene.meshes[instance.mesh]).map(|corners| corners.map(place)));
    }
    all
}

fn geometric_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Distance along a ray to the nearest triangle, either side (Moeller and Trumbore, 1997).
fn hit(triangles: &[[DVec3; 3]], origin: DVec3, direction: DVec3) -> Option<f64> {
    let nearest = triangles.iter().filter_map(|&[a, b, c]| {
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let to_origin = origin - a;
        let u = to_origin.dot(p) / determinant;
        let q = to_origin.cross(ab);
        let v = direction.dot(q) / determinant;
        let distance = ac.dot(q) / determinant;
        (u >= -1e-12 && v >= -1e-12 && u + v <= 1.0 + 1e-12 && distance > 0.0).then_some(distance)
    });
    nearest.min_by(f64::total_cmp)
}

#[test]
fn every_description_belongs_to_an_entry_and_names_its_parameters() {
    assert_eq!(NAMES.len(), ENTRIES.len());
    for ((name, description), entry) in NAMES.iter().zip(ENTRIES) {
        assert_eq!(*name, entry.name);
        for parameter in entry.parameters {
            let shown = format!("{}={}", parameter.key, parameter.default);
            assert!(description.contains(&shown), "{name}: {description} lacks {shown}");
            assert!(description.contains(&parameter.high.to_string()), "{name}: {description}");
        }
    }
}

#[test]
fn triangles_have_area_and_normals_agree_with_the_winding() {
    for spec in SPECS {
        let scene = load_sound(spec);
        assert_eq!(scene.name, format!("builtin:{spec}"));
        for mesh in &scene.meshes {
            for (index, normal) in mesh.normals.iter().enumerate() {
                let length = wide(*normal).length();
                assert!((length - 1.0).abs() < 1e-4, "{spec}, {}: normal {index} has length {length}", mesh.name);
            }
            for (corners, ids) in triangles(mesh).zip(mesh.indices.chunks_exact(3)) {
                let normal = geometric_normal(corners);
                assert!(normal.length() * 0.5 > 1e-10, "{spec}, {}: {ids:?} has no area", mesh.name);
                for &id in ids {
                    let shading = wide(mesh.normals[id as usize]);
                    assert!(shading.dot(normal) > 0.0, "{spec}, {}: {ids:?} faces away", mesh.name);
                }
            }
        }
    }
}

#[test]
fn scenes_are_deterministic_and_have_cameras_materials_and_places_for_every_mesh() {
    for spec in SPECS {
        let (scene, again) = (load_sound(spec), load_sound(spec));
        assert_eq!(world_triangles(&scene), world_triangles(&again), "{spec}");
        assert!(scene.cameras.iter().all(|camera| !camera.name.is_empty()) && !scene.cameras.is_empty());
        for (index, mesh) in scene.meshes.iter().enumerate() {
            assert!(scene.instances.iter().any(|i| i.mesh == index), "{spec}: {} is nowhere", mesh.name);
        }
        let usual = |m: &Material| (0.3..=1.0).contains(&m.roughness) && (m.metallic == 0.0 || m.name == "brass");
        assert!(scene.materials.iter().all(usual), "{spec}");
        assert!(scene.instances.iter().all(|i| i.object_to_world.determinant() > 0.0), "{spec}");
    }
}

#[test]
fn atrium_grows_with_detail_as_promised() {
    let counts = [1, 2, 3, 4].map(|detail| load_sound(&format!("atrium:detail={detail}")).triangle_count());
    assert!((58_000..70_000).contains(&counts[0]), "{counts:?}");
    assert!((235_000..270_000).contains(&counts[3]), "{counts:?}");
    assert!(counts.is_sorted_by(|a, b| a < b), "{counts:?}");
}

#[test]
fn atrium_has_its_size_its_lights_and_an_open_roof() {
    let scene = load_sound("atrium");
    let size = scene.bounds().max - scene.bounds().min;
    assert!((size - DVec3::new(30.0, 12.0, 14.0)).abs().max_element() < 1.0, "{size}");
    assert_eq!(scene.lights.len(), 256);
    assert_eq!(scene.cameras.len(), 3);
    let triangles = world_triangles(&scene);
    assert_eq!(hit(&triangles, DVec3::new(0.3, 2.0, 0.2), DVec3::Y), None);
    // Under the gallery there is no sky, and the floor is at height 0.
    assert!(hit(&triangles, DVec3::new(0.3, 2.0, 5.9), DVec3::Y).is_some_and(|d| (d - 2.8).abs() < 1e-4));
    assert!(hit(&triangles, DVec3::new(5.3, 2.0, 0.2), DVec3::NEG_Y).is_some_and(|d| (d - 2.0).abs() < 1e-6));
    // Through the arch of bay 0, which has no curtain, to the outer wall; above the arch to its wall.
    assert!(hit(&triangles, DVec3::new(-10.4, 2.0, 0.0), DVec3::NEG_Z).is_some_and(|d| (d - 7.0).abs() < 1e-4));
    assert!(hit(&triangles, DVec3::new(-10.4, 4.6, 0.0), DVec3::NEG_Z).is_some_and(|d| d < 4.5));
}

#[test]
fn furnace_walls_look_inward_and_their_emission_balances_their_albedo() {
    for (spec, albedo) in [("furnace", 0.5), ("furnace:albedo=0.9", 0.9), ("furnace:albedo=0", 0.0)] {
        let scene = load_sound(spec);
        let all = world_triangles(&scene);
        assert_eq!(all.len(), 6 * 4 * 4 * 2);
        for corners in all {
            assert!(geometric_normal(corners).dot(corners[0]) < 0.0);
        }
        let material = &scene.materials[0];
        assert_eq!(material.base_color[0], albedo as f32);
        assert!((material.base_color[0] + material.emissive[0] - 1.0).abs() <= f32::EPSILON);
    }
}

#[test]
fn cornell_walls_look_inward_and_blocks_outward() {
    let scene = load_sound("cornell");
    let center = DVec3::new(0.0, 2.75, 0.0);
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let block = mesh.name == "block";
        let middle = if block { instance.object_to_world.transform_point3(DVec3::Y * 0.5) } else { center };
        for corners in triangles(mesh) {
            let corners = corners.map(|p| instance.object_to_world.transform_point3(p));
            let outward = geometric_normal(corners).dot(corners[0] - middle);
            assert!(if block { outward > 0.0 } else { outward < 0.0 }, "{}", mesh.name);
        }
    }
    assert!(scene.materials.iter().any(|material| material.emissive[0] > 0.0));
    assert_eq!(scene.lights.len(), 1);
}

#[test]
fn a_closed_corridor_has_no_gap_and_an_open_one_has_its_door() {
    let through = |door: &str| {
        let triangles = world_triangles(&load_sound(&format!("corridor:door={door}")));
        let mut open = 0;
        for row in 0..=26 {
            for column in 0..=40 {
                let origin = DVec3::new(-0.5, row as f64 * 0.1, column as f64 * 0.1 - 2.0);
                // The wall is hit 0.475 m away.
                open += usize::from(hit(&triangles, origin, DVec3::X).is_none_or(|d| d > 0.6));
            }
        }
        open
    };
    assert_eq!(through("0"), 0);
    // 1.2 m x 2 m less the sill, sampled every 0.1 m.
    assert!((200..=280).contains(&through("1.2")), "{}", through("1.2"));
}

#[test]
fn no_ray_leaves_the_corridor() {
    for spec in ["corridor", "corridor:door=0"] {
        let triangles = world_triangles(&load_sound(spec));
        let mut random = Random::new(5);
        for room in [-2.0, 1.0] {
            for _ in 0..1500 {
                let (height, turn) = (random.range(-1.0, 1.0), random.range(0.0, TAU));
                let around = (1.0 - height * height).sqrt();
                let direction = DVec3::new(around * turn.cos(), height, around * turn.sin());
                let origin = DVec3::new(room, 1.3, 0.1);
                assert!(hit(&triangles, origin, direction).is_some_and(|d| d < 9.0), "{spec}: {direction}");
            }
        }
    }
}

#[test]
fn terrain_colours_are_bounded_by_the_albedo() {
    let scene = load_sound("terrain:albedo=0.05");
    for material in &scene.materials {
        let brightest = material.base_color[..3].iter().fold(0.0f32, |a, &b| a.max(b));
        assert!((brightest - 0.05).abs() < 1e-6, "{}: {brightest}", material.name);
    }
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["first-person", "top-down"]);
}

#[test]
fn bad_specs_are_refused_with_what_is_known() {
    let bad = [
        ("sponza", "atrium"),
        ("", "cornell"),
        ("cornell:", "key=value"),
        ("cornell:size=2", "takes none"),
        ("atrium:details=2", "known: detail"),
        ("atrium:detail=5", "from 1 to 4"),
        ("atrium:detail=1.5", "whole number"),
        ("atrium:detail=", "whole number"),
        ("atrium:detail=1,detail=2", "twice"),
        ("corridor:door=-0.1", "from 0 to 1.2"),
        ("furnace:albedo=NaN", "from 0 to 1"),
        ("furnace:albedo=inf", "from 0 to 1"),
        ("terrain:albedo=0.5,", "key=value"),
    ];
    for (spec, part) in bad {
        let error = load(spec).map(|_| ()).expect_err(spec);
        assert_eq!(error.kind(), ErrorKind::Usage, "{spec}");
        assert!(error.to_string().contains(part), "{spec}: {error}");
    }
}
