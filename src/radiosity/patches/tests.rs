use super::*;
use crate::scene::view::View;
use crate::scene::{AlphaMode, Instance, Material, Mesh, builtin};
use glam::DMat4;

fn of_size(scene: &Scene, size: f64) -> Result<Patches> {
    Patches::of_size(scene, &Reference::new(scene, &View::of_world())?, size)
}

fn of_count(scene: &Scene, count: usize) -> Result<Patches> {
    Patches::of_count(scene, &Reference::new(scene, &View::of_world())?, count, PatchSource::Triangles)
}

#[test]
fn areas_are_true_and_two_sided_sheets_have_two_sides() {
    let mut scene = builtin::load("cornell").expect("a built-in scene");
    let surface = |scene: &Scene| -> f64 {
        let of = |instance: &Instance| -> f64 {
            let mesh = &scene.meshes[instance.mesh];
            let corner = |v: u32| {
                let local = DVec3::from_array(mesh.positions[v as usize].map(f64::from));
                instance.object_to_world.transform_point3(local)
            };
            let sides = if scene.materials[mesh.material].double_sided { 2.0 } else { 1.0 };
            let area = |t: &[u32]| {
                let [a, b, c] = [0, 1, 2].map(|k| corner(t[k]));
                0.5 * (b - a).cross(c - a).length()
            };
            mesh.indices.chunks_exact(3).map(area).sum::<f64>() * sides
        };
        scene.instances.iter().map(of).sum()
    };
    // Two blocks of 1.65 m stand on the floor, and a panel of 1.3 m by 1.05 m hangs right under the ceiling.
    let hidden = 2.0 * 1.65 * 1.65 + 1.3 * 1.05;
    for size in [0.3, 1.0] {
        let patches = of_size(&scene, size).expect("patches");
        assert!(((patches.area() + patches.buried) / surface(&scene) - 1.0).abs() < 1e-9);
        assert!((patches.buried - hidden).abs() < 0.1 * hidden, "{} of {hidden}", patches.buried);
        assert!(patches.list.iter().all(|p| p.radius <= 2.0 * size && (p.normal.length() - 1.0).abs() < 1e-12));
    }
    scene.materials.iter_mut().for_each(|material| material.double_sided = true);
    let doubled = of_size(&scene, 1.0).expect("patches");
    assert!(((doubled.area() + doubled.buried) / surface(&scene) - 1.0).abs() < 1e-9);
    // Strips under the walls of the blocks are all that is left out.
    assert!(doubled.buried < 0.12 * hidden, "{}", doubled.buried);
}

#[test]
fn counts_are_met_nearly_and_sizes_that_are_none_refused() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    for count in [300, 1000] {
        let found = of_count(&scene, count).expect("patches").list.len();
        assert!(found.abs_diff(count) < count / 8, "{found} for {count}");
    }
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(of_size(&scene, size).is_err());
    }
}

/// R3.
#[test]
fn slivers_without_area_are_dropped_and_counted() {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    let clean = of_size(&scene, 1.0).expect("patches");
    let mesh = &mut scene.meshes[0];
    mesh.indices.extend([0, 0, 1, 2, 2, 2]);
    let found = of_size(&scene, 1.0).expect("patches");
    assert_eq!((found.dropped, &found.list), (2, &clean.list));
}

#[test]
fn colours_are_means_and_glass_has_none() {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    scene.materials[0] = Material {
        base_color: [0.8, 0.4, 0.2, 1.0],
        metallic: 0.5,
        emissive: [0.0, 1.0, 2.0],
        ..scene.materials[0].clone()
    };
    let patches = of_size(&scene, 2.0).expect("patches");
    let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-6;
    assert!(patches.list.iter().all(|p| near(p.reflectance, DVec3::new(0.4, 0.2, 0.1))));
    assert!(patches.list.iter().all(|p| near(p.emission, DVec3::new(0.0, 1.0, 2.0))));
    scene.materials[0].alpha = AlphaMode::Blend;
    assert!(of_size(&scene, 2.0).expect("none").list.is_empty());
}

/// Of a floor that is turned by 45 degrees: pieces of triangles keep its area, staircases of cubes have the square root of 2 times that.
#[test]
fn cubes_stand_for_slopes_by_staircases() {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    let size = 4.0f32;
    let material = scene.meshes[0].material;
    scene.meshes[0] = Mesh { material, ..Mesh::default() };
    let mesh = &mut scene.meshes[0];
    mesh.positions = vec![[0.0, 0.0, 0.0], [size, size, 0.0], [size, size, -size], [0.0, 0.0, -size]];
    mesh.normals = vec![[-0.5f32.sqrt(), 0.5f32.sqrt(), 0.0]; 4];
    mesh.indices = vec![0, 1, 2, 0, 2, 3];
    scene.instances.truncate(1);
    scene.instances[0].mesh = 0;
    scene.instances[0].object_to_world = DMat4::IDENTITY;
    let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
    let [off, albedo] = Patches::of_size(&scene, &occluders, 0.25).expect("patches").simplified();
    assert!(off.abs() < 1e-9 && albedo < 1e-12, "{off} {albedo}");
    let cubes = Patches::of_voxels(&scene, &occluders, 0.25).expect("patches");
    let [off, albedo] = cubes.simplified();
    // Cubes at its ends stick out.
    let steps = (off + 1.0) / 2f64.sqrt();
    assert!((1.0..1.15).contains(&steps) && albedo < 1e-6, "{off} {albedo}");
    // Each side looks along an axis, and none of them backwards.
    assert!(cubes.list.iter().all(|p| p.normal.abs().max_element() == 1.0 && p.triangles.len() == 2));
    for patch in &cubes.list {
        assert!(patch.triangles.iter().all(|t| (area_and_normal(t).1 - patch.normal).length() < 1e-12));
        // Up and against the rise, or the other way, as the triangles are wound; the ends of the staircase look along z in neither.
        assert!((patch.normal.y - patch.normal.x) * (cubes.list[0].normal.y - cubes.list[0].normal.x) > 0.0);
    }
}
