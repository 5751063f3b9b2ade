//! From strips, fans and indices to triangle lists over the vertices that are used.

use glam::DVec3;

use crate::scene::Mesh;

/// glTF's three ways to make triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// 4
    List,
    /// 5
    Strip,
    /// 6
    Fan,
}

impl Mode {
    /// Corners of the list that `count` vertices make.
    pub(super) fn corner_count(self, count: usize) -> usize {
        match self {
            Self::List => count / 3 * 3,
            Self::Strip | Self::Fan => count.saturating_sub(2).saturating_mul(3),
        }
    }

    /// The triangle list of `count` vertices, `vertex` giving the number of each (glTF 2.0, section 3.7.2.1).
    pub(super) fn triangle_list(self, count: usize, vertex: impl Fn(usize) -> u32) -> Vec<u32> {
        let mut corners = Vec::with_capacity(self.corner_count(count));
        for triangle in 0..self.corner_count(count) / 3 {
            let odd = triangle % 2;
            let places = match self {
                Self::List => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
                Self::Strip => [triangle, triangle + 1 + odd, triangle + 2 - odd],
                Self::Fan => [triangle + 1, triangle + 2, 0],
            };
            corners.extend(places.map(&vertex));
        }
        corners
    }
}

/// Renumbers `corners` so that only used vertices remain, and returns these, in ascending order.
///
/// Many primitives of a file may share one large accessor: the work and memory follow the corners, not `vertex_count`.
pub(super) fn compact(corners: &mut [u32], vertex_count: usize) -> Vec<u32> {
    const UNUSED: u32 = u32::MAX;
    const USED: u32 = 0;
    if !is_table_small(corners.len(), vertex_count) {
        let mut used = corners.to_vec();
        used.sort_unstable();
        used.dedup();
        for corner in corners.iter_mut() {
            *corner = used.partition_point(|vertex| vertex < corner) as u32;
        }
        return used;
    }
    let mut table = vec![UNUSED; vertex_count];
    for corner in corners.iter() {
        table[*corner as usize] = USED;
    }
    let mut used = Vec::with_capacity(table.iter().filter(|place| **place == USED).count());
    for (vertex, place) in table.iter_mut().enumerate() {
        if *place == USED {
            *place = used.len() as u32;
            used.push(vertex as u32);
        }
    }
    for corner in corners.iter_mut() {
        *corner = table[*corner as usize];
    }
    used
}

fn is_table_small(corner_count: usize, vertex_count: usize) -> bool {
    vertex_count <= corner_count * 8 + 256
}

/// Bytes that [`compact`] holds while it works.
pub(super) fn compact_bytes(corner_count: usize, vertex_count: usize) -> u64 {
    let table = if is_table_small(corner_count, vertex_count) { vertex_count } else { 0 };
    4 * (table + corner_count) as u64
}

/// Replaces each vertex by those that `origin` lists.
pub(super) fn select(mesh: &mut Mesh, origin: &[u32]) {
    fn pick<T: Copy>(values: &mut Vec<T>, origin: &[u32]) {
        if !values.is_empty() {
            *values = origin.iter().map(|vertex| values[*vertex as usize]).collect();
        }
    }
    pick(&mut mesh.positions, origin);
    pick(&mut mesh.normals, origin);
    pick(&mut mesh.tangents, origin);
    pick(&mut mesh.uvs[0], origin);
    pick(&mut mesh.uvs[1], origin);
    pick(&mut mesh.colors, origin);
}

/// Bytes of one vertex of `mesh`.
pub(super) fn vertex_bytes(mesh: &Mesh) -> usize {
    let there = |is_empty: bool, bytes: usize| if is_empty { 0 } else { bytes };
    12 + there(mesh.normals.is_empty(), 12)
        + there(mesh.tangents.is_empty(), 16)
        + there(mesh.uvs[0].is_empty(), 8)
        + there(mesh.uvs[1].is_empty(), 8)
        + there(mesh.colors.is_empty(), 16)
}

/// f64 of f32.
pub(super) fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Twice the area along the front face's normal, in f64, where products of f32 lengths neither vanish nor overflow.
pub(super) fn doubled_area(positions: &[[f32; 3]], triangle: &[u32]) -> DVec3 {
    let corner = |i: usize| vector(positions[triangle[i] as usize]);
    (corner(1) - corner(0)).cross(corner(2) - corner(0))
}

/// Removes triangles of zero area and returns how many.
pub(super) fn drop_zero_area(mesh: &mut Mesh) -> u64 {
    let mut kept = 0;
    for start in (0..mesh.indices.len()).step_by(3) {
        let triangle = [mesh.indices[start], mesh.indices[start + 1], mesh.indices[start + 2]];
        if doubled_area(&mesh.positions, &triangle) != DVec3::ZERO {
            mesh.indices[kept..kept + 3].copy_from_slice(&triangle);
            kept += 3;
        }
    }
    let dropped = mesh.indices.len() - kept;
    mesh.indices.truncate(kept);
    (dropped / 3) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        let list = |mode: Mode, count| mode.triangle_list(count, |i| 10 + i as u32);
        assert_eq!(list(Mode::List, 7), [10, 11, 12, 13, 14, 15]);
        assert_eq!(list(Mode::Strip, 5), [10, 11, 12, 11, 13, 12, 12, 13, 14]);
        assert_eq!(list(Mode::Fan, 5), [11, 12, 10, 12, 13, 10, 13, 14, 10]);
        for mode in [Mode::List, Mode::Strip, Mode::Fan] {
            assert!(list(mode, 2).is_empty());
        }
    }

    #[test]
    fn both_ways_to_compact_agree() {
        let corners = [5, 900, 5, 7, 1_000_000, 900];
        let (mut small, mut large) = (corners.map(|c| c.min(250)), corners);
        assert_eq!(compact(&mut small, 251), [5, 7, 250]);
        assert_eq!(small, [0, 2, 0, 1, 2, 2]);
        assert_eq!(compact(&mut large, 1_000_001), [5, 7, 900, 1_000_000]);
        assert_eq!(large, [0, 2, 0, 1, 3, 2]);
    }

    #[test]
    fn triangles_without_area_go() {
        let mut mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1e-30, 0.0]],
            indices: vec![0, 1, 2, 0, 1, 3, 0, 0, 3],
            ..Mesh::default()
        };
        assert_eq!(drop_zero_area(&mut mesh), 2);
        assert_eq!(mesh.indices, [0, 1, 3]);
    }
}
