//! Draws of blended surfaces, from back to front as the eye sees them: by the distance of an object's or a triangle's middle, ties in the
//! scene's order. Surfaces that meet or surround one another have no such order; `accuracy` shows what that costs.

use std::collections::HashMap;

use glam::DVec3;

use super::{Faces, Geometry, PlannedDraw, instance, variant_of};
use crate::error::{Error, Result};
use crate::plan::materials::Materials;
use crate::plan::{Limits, TransparentSort};
use crate::scene::view::View;
use crate::scene::{Mesh, Scene};

/// One triangle of a blended object.
struct Triangle {
    distance: f64,
    object: usize,
    index: usize,
}

/// Appends instances and draws of the scene's instances `members`.
///
/// # Errors
/// More sorted triangles than an index buffer of this device takes.
pub(super) fn add(
    geometry: &mut Geometry,
    scene: &Scene,
    view: &View,
    materials: &Materials,
    (members, sort): (&[usize], TransparentSort),
    limits: &Limits,
) -> Result<()> {
    if sort == TransparentSort::Triangle {
        check_sorted(geometry, scene, members, limits)?;
    }
    let mut objects = Vec::new();
    for &index in members {
        let placed = &scene.instances[index];
        let mesh = &scene.meshes[placed.mesh];
        let place = geometry.place_once(placed.mesh, mesh);
        let mirrored = (placed.object_to_world.determinant() < 0.0) != view.lens.mirrors();
        let object_to_view = view.world_to_view * placed.object_to_world;
        let range = (geometry.places[place].index_offset, geometry.places[place].index_count);
        let draw = PlannedDraw {
            place,
            material: mesh.material,
            variant: variant_of(mesh, materials),
            instance_offset: geometry.instances.len() as u32,
            instance_count: 1,
            mirrored,
            faces: if materials.double_sided[mesh.material] { Faces::Both } else { Faces::Front },
            index_offset: range.0,
            index_count: range.1,
        };
        geometry.instances.push(instance(object_to_view, mirrored != view.lens.mirrors(), mesh.material));
        objects.push((draw, index));
    }
    let distance = |object: usize, local: DVec3| {
        let placed = &scene.instances[objects[object].1];
        let p = (view.world_to_view * placed.object_to_world).transform_point3(local);
        if view.lens.is_perspective() { p.length() } else { -p.z }
    };
    match sort {
        TransparentSort::Object => {
            let mut middles = HashMap::new();
            let mut middle = |object: usize| {
                let mesh = scene.instances[objects[object].1].mesh;
                distance(object, *middles.entry(mesh).or_insert_with(|| middle_of_box(&scene.meshes[mesh])))
            };
            let mut order: Vec<_> = (0..objects.len()).map(|object| (middle(object), object)).collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0));
            geometry.blended.extend(order.iter().flat_map(|&(_, object)| faces(objects[object].0)));
        }
        TransparentSort::Triangle => {
            let mut triangles = Vec::new();
            for (object, &(_, index)) in objects.iter().enumerate() {
                let mesh = &scene.meshes[scene.instances[index].mesh];
                let middles = mesh.indices.chunks_exact(3).map(|corners| middle_of_triangle(mesh, corners));
                triangles.extend(middles.enumerate().map(|(index, middle)| Triangle {
                    distance: distance(object, middle),
                    object,
                    index,
                }));
            }
            triangles.sort_by(|a, b| b.distance.total_cmp(&a.distance));
            for run in triangles.chunk_by(|a, b| a.object == b.object) {
                let (draw, index) = objects[run[0].object];
                let mesh = &scene.meshes[scene.instances[index].mesh];
                let index_offset = geometry.index_count as u32;
                for triangle in run {
                    geometry.sorted_indices.extend(&mesh.indices[triangle.index * 3..triangle.index * 3 + 3]);
                }
                geometry.index_count += run.len() as u64 * 3;
                geometry.blended.push(PlannedDraw { index_offset, index_count: run.len() as u32 * 3, ..draw });
            }
        }
    }
    Ok(())
}

/// Refuses sorted triangles before room is made for them: every instance has indices of its own.
fn check_sorted(geometry: &Geometry, scene: &Scene, members: &[usize], limits: &Limits) -> Result<()> {
    let sorted: u64 = members.iter().map(|&i| scene.meshes[scene.instances[i].mesh].indices.len() as u64).sum();
    let bytes = (geometry.index_count + sorted).saturating_mul(4);
    if bytes <= limits.max_buffer_bytes && bytes / 4 <= u64::from(u32::MAX) {
        return Ok(());
    }
    Err(Error::new(format!(
        "{}: sorted triangles of {} blended instances make an index buffer of {bytes} bytes, this device's largest buffer has {}; --transparent-sort object needs no copies",
        scene.name,
        members.len(),
        limits.max_buffer_bytes
    )))
}

/// Of what is seen from both sides the backs come first: of a closed object they lie behind its fronts.
fn faces(draw: PlannedDraw) -> Vec<PlannedDraw> {
    match draw.faces {
        Faces::Both => vec![PlannedDraw { faces: Faces::Back, ..draw }, PlannedDraw { faces: Faces::Front, ..draw }],
        _ => vec![draw],
    }
}

fn position(mesh: &Mesh, vertex: usize) -> DVec3 {
    DVec3::from_array(mesh.positions[vertex].map(f64::from))
}

fn middle_of_box(mesh: &Mesh) -> DVec3 {
    let used = || mesh.indices.iter().map(|&vertex| position(mesh, vertex as usize));
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    (low + used().fold(DVec3::NEG_INFINITY, DVec3::max)) * 0.5
}

fn middle_of_triangle(mesh: &Mesh, corners: &[u32]) -> DVec3 {
    corners.iter().map(|&vertex| position(mesh, vertex as usize)).sum::<DVec3>() / 3.0
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::plan::{Plan, Request, Technique};
    use crate::scene::{AlphaMode, Camera, Instance, Material};

    /// Panes of 2 m at the given distances before the eye, seen from both sides or not.
    fn panes(distances: &[f64], double_sided: bool) -> Scene {
        let mesh = Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..Mesh::default()
        };
        let material = Material { alpha: AlphaMode::Blend, double_sided, ..Material::default() };
        let at = |&z: &f64| Instance { mesh: 0, object_to_world: DMat4::from_translation(DVec3::new(0.0, 0.0, -z)) };
        Scene {
            meshes: vec![mesh],
            materials: vec![material],
            instances: distances.iter().map(at).collect(),
            cameras: vec![Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 1.0)],
            ..Scene::default()
        }
    }

    fn planned(scene: &Scene, transparent_sort: TransparentSort) -> Plan {
        let request = Request { technique: Technique::Forward, transparent_sort, ..Request::default() };
        Plan::new(scene, &request, &Limits { float_blend: true, ..Limits::MINIMUM }).expect("a plan")
    }

    fn distances(plan: &Plan) -> Vec<f32> {
        let of = |draw: &PlannedDraw| -plan.geometry.instances[draw.instance_offset as usize].object_to_view_w[2];
        plan.geometry.blended.iter().map(of).collect()
    }

    #[test]
    fn far_comes_before_near_and_backs_before_fronts() {
        let scene = panes(&[2.0, 5.0, 3.0], false);
        let plan = planned(&scene, TransparentSort::Object);
        assert!(plan.geometry.draws.is_empty() && !plan.prepass);
        assert_eq!(distances(&plan), [5.0, 3.0, 2.0]);
        let both = planned(&panes(&[2.0, 4.0], true), TransparentSort::Object);
        assert_eq!(distances(&both), [4.0, 4.0, 2.0, 2.0]);
        let faces: Vec<_> = both.geometry.blended.iter().map(|draw| draw.faces).collect();
        assert_eq!(faces, [Faces::Back, Faces::Front, Faces::Back, Faces::Front]);
    }

    #[test]
    fn triangles_are_drawn_in_runs_of_one_object() {
        let scene = panes(&[2.0, 5.0], true);
        let plan = planned(&scene, TransparentSort::Triangle);
        let ranges: Vec<_> = plan.geometry.blended.iter().map(|d| (d.index_offset, d.index_count, d.faces)).collect();
        assert_eq!(ranges, [(6, 6, Faces::Both), (12, 6, Faces::Both)]);
        assert_eq!(distances(&plan), [5.0, 2.0]);
        assert_eq!(plan.geometry.index_data(&scene), [0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 2, 3]);
        assert_eq!(plan.geometry.index_count, 18);
    }

    #[test]
    fn sorted_triangles_fit_into_a_buffer() {
        // One mesh of 6 indices, and a copy of them an instance.
        let scene = panes(&[2.0; 100], true);
        let message = |max_buffer_bytes| {
            let transparent_sort = TransparentSort::Triangle;
            let technique = Technique::Forward;
            let request = Request { width: 8, height: 8, technique, transparent_sort, ..Request::default() };
            let limits = Limits { float_blend: true, max_buffer_bytes, ..Limits::MINIMUM };
            Plan::new(&scene, &request, &limits).err().map(|error| error.to_string()).unwrap_or_default()
        };
        let refused = message(600 * 4 - 1);
        assert!(refused.contains("sorted triangles of 100 blended instances") && refused.contains("2400"), "{refused}");
        assert!(!message(606 * 4).contains("sorted"));
    }
}
