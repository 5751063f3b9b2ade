//! Unit normals for every vertex, whatever the file has.

use glam::DVec3;

use super::topology::{doubled_area, select, vector};
use crate::scene::Mesh;

fn unit(v: DVec3) -> Option<[f32; 3]> {
    v.try_normalize().map(|unit| unit.as_vec3().to_array())
}

/// Normals of the triangles themselves, each with vertices of its own (glTF 2.0, section 3.7.2.1).
pub(super) fn make_flat(mesh: &mut Mesh) {
    let origin = std::mem::take(&mut mesh.indices);
    select(mesh, &origin);
    mesh.indices = (0..origin.len() as u32).collect();
    mesh.normals = Vec::with_capacity(origin.len());
    for triangle in mesh.indices.chunks_exact(3) {
        let normal = unit(doubled_area(&mesh.positions, triangle)).unwrap_or([0.0, 0.0, 1.0]);
        mesh.normals.extend([normal; 3]);
    }
}

/// Brings normals to unit length. Those that have no direction become the area-weighted mean of the triangles around;
/// the number of these is returned.
pub(super) fn repair(mesh: &mut Mesh) -> u64 {
    const LOST: [f32; 3] = [0.0; 3];
    let mut lost = 0;
    for normal in &mut mesh.normals {
        *normal = unit(vector(*normal)).unwrap_or(LOST);
        lost += u64::from(*normal == LOST);
    }
    if lost == 0 {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; mesh.normals.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let area = doubled_area(&mesh.positions, triangle);
        for vertex in triangle {
            sums[*vertex as usize] += area;
        }
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        if *normal == LOST {
            *normal = unit(sum).unwrap_or([0.0, 0.0, 1.0]);
        }
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share an edge: one of area 0.5 facing +Z, one of area 1 facing +X.
    fn folded() -> Mesh {
        Mesh {
            positions: vec![[0.0; 3], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -2.0]],
            indices: vec![0, 1, 2, 0, 3, 1],
            ..Mesh::default()
        }
    }

    #[test]
    fn lost_normals_are_area_weighted() {
        let mut mesh = folded();
        mesh.normals = vec![[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 5.0], [f32::INFINITY, 0.0, 0.0]];
        assert_eq!(repair(&mut mesh), 3);
        let mean = DVec3::new(2.0, 0.0, 1.0).normalize().as_vec3().to_array();
        assert_eq!(mesh.normals, [mean, mean, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn flat_normals_split_vertices() {
        let mut mesh = folded();
        mesh.colors = vec![[0.0; 4], [1.0; 4], [2.0; 4], [3.0; 4]];
        make_flat(&mut mesh);
        assert_eq!(mesh.indices, [0, 1, 2, 3, 4, 5]);
        assert_eq!(mesh.normals[2], [0.0, 0.0, 1.0]);
        assert_eq!(mesh.normals[3], [1.0, 0.0, 0.0]);
        assert_eq!(mesh.colors[4], [3.0; 4]);
        assert_eq!(mesh.positions.len(), 6);
    }
}
