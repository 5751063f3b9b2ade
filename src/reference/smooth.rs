//! Smooth groups: triangles of a mesh over which the interpolated normal is continuous.
//!
//! Two triangles belong together where they share an edge: both its ends have the same position and the same normal,
//! bit for bit. A crease is thus a border between groups, and so is the edge of a mesh. Pixels well inside one group
//! are where pictures of different rasterisers can be compared without counting whose edge a pixel centre fell
//! beyond.

use std::collections::HashMap;

use crate::scene::Mesh;

/// The group of each triangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Groups {
    /// One a triangle, numbered from 0 in the order of each group's first triangle.
    pub of_triangle: Vec<u32>,
    /// Number of groups.
    pub count: u32,
}

impl Groups {
    /// Groups a mesh of at most `u32::MAX` triangles.
    pub fn new(mesh: &Mesh) -> Self {
        let vertices = shared_vertices(mesh);
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(mesh.indices.len());
        for (triangle, corners) in mesh.indices.chunks_exact(3).enumerate() {
            let [a, b, c] = [0, 1, 2].map(|k| vertices[corners[k] as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if from != to {
                    edges.push((from.min(to), from.max(to), triangle as u32));
                }
            }
        }
        edges.sort_unstable();
        let mut parents: Vec<u32> = (0..(mesh.indices.len() / 3) as u32).collect();
        for pair in edges.windows(2) {
            if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
                let (a, b) = (root(&mut parents, pair[0].2), root(&mut parents, pair[1].2));
                // The root is the group's first triangle.
                parents[a.max(b) as usize] = a.min(b);
            }
        }
        let mut count = 0;
        let mut of_triangle: Vec<u32> = Vec::with_capacity(parents.len());
        for triangle in 0..parents.len() as u32 {
            let first = root(&mut parents, triangle);
            if first == triangle {
                of_triangle.push(count);
                count += 1;
            } else {
                of_triangle.push(of_triangle[first as usize]);
            }
        }
        Self { of_triangle, count }
    }
}

/// For each vertex a number that vertices of the same position and normal share.
fn shared_vertices(mesh: &Mesh) -> Vec<u32> {
    // -0 + 0 = +0: the two zeros are one place.
    let bits = |x: f32| (x + 0.0).to_bits();
    let mut numbers: HashMap<[[u32; 3]; 2], u32> = HashMap::with_capacity(mesh.positions.len());
    mesh.positions
        .iter()
        .zip(&mesh.normals)
        .map(|(position, normal)| {
            let next = numbers.len() as u32;
            *numbers.entry([position.map(bits), normal.map(bits)]).or_insert(next)
        })
        .collect()
}

/// The root of a triangle's tree; halves the path to it.
fn root(parents: &mut [u32], mut triangle: u32) -> u32 {
    while parents[triangle as usize] != triangle {
        let grandparent = parents[parents[triangle as usize] as usize];
        parents[triangle as usize] = grandparent;
        triangle = grandparent;
    }
    triangle
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of quads along x, two triangles each; every quad has vertices of its own, with the normal that `normal`
    /// gives for the quad and the vertex' x.
    fn strip(quads: usize, normal: impl Fn(usize, f32) -> [f32; 3]) -> Mesh {
        let mut mesh = Mesh::default();
        for quad in 0..quads {
            let first = mesh.positions.len() as u32;
            for (dx, y) in [(0, 0.0), (1, 0.0), (1, 1.0), (0, 1.0)] {
                let x = (quad + dx) as f32;
                mesh.positions.push([x, y, 0.0]);
                mesh.normals.push(normal(quad, x));
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
        mesh
    }

    #[test]
    fn equal_normals_join_and_creases_part() {
        let smooth = Groups::new(&strip(4, |_, x| [x * 0.1, 0.0, 1.0]));
        assert_eq!(smooth, Groups { of_triangle: vec![0; 8], count: 1 });
        let creased = Groups::new(&strip(4, |quad, _| [quad as f32 * 0.1, 0.0, 1.0]));
        assert_eq!(creased, Groups { of_triangle: vec![0, 0, 1, 1, 2, 2, 3, 3], count: 4 });
        let half = Groups::new(&strip(4, |quad, _| [(quad / 2) as f32, if quad == 1 { -0.0 } else { 0.0 }, 1.0]));
        assert_eq!(half.of_triangle, [0, 0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn a_shared_corner_alone_does_not_join() {
        let mut mesh = strip(2, |_, _| [0.0, 0.0, 1.0]);
        // The second quad now touches the first at its upper right corner only.
        mesh.positions[4..].iter_mut().for_each(|p| p[1] += 1.0);
        assert_eq!(Groups::new(&mesh).of_triangle, [0, 0, 1, 1]);
        assert_eq!(Groups::new(&Mesh::default()), Groups { of_triangle: Vec::new(), count: 0 });
    }

    #[test]
    fn groups_that_meet_late_become_one() {
        let mut mesh = strip(3, |_, _| [0.0, 0.0, 1.0]);
        let quads: Vec<&[u32]> = mesh.indices.chunks(6).collect();
        mesh.indices = [quads[0], quads[2], quads[1]].concat();
        assert_eq!(Groups::new(&mesh).count, 1);
    }
}
