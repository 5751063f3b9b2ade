//! Tangents for normal maps: the file's, else MikkTSpace's (glTF 2.0, section 3.7.2.1; M. Mikkelsen, "Simulation of
//! Wrinkled Surfaces Revisited", 2008).
//!
//! MikkTSpace takes time and stack that grow with the square of the triangles at one point, and some 640 bytes a
//! triangle. Where a file asks for more than is reasonable, the texture's direction is averaged over the triangles
//! around a vertex.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec2, DVec3};

use super::topology::{select, vector};
use crate::scene::{Mesh, Texture};

/// What MikkTSpace holds for a triangle: 152 of its own, 24 corner numbers, 72 edges, up to 240 groups, 120 results.
pub(super) const BYTES_PER_TRIANGLE: usize = 640;

/// Most triangles at one point: MikkTSpace recurses from one to the next.
const MAX_TRIANGLES_AT_POINT: usize = 1024;
/// Bound of the sum of squares of triangles at a point: for each corner, and for the mesh.
const SQUARES_PER_CORNER: usize = 64;
const SQUARES_BASE: usize = 1 << 24;

struct Soup<'a> {
    mesh: &'a Mesh,
    texture: &'a Texture,
    /// One a corner; zero where there is none.
    tangents: Vec<[f32; 4]>,
}

impl Soup<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[3 * face + corner] as usize
    }
}

impl Geometry for Soup<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        texture_point(self.mesh, self.texture, self.vertex(face, corner)).as_vec2().to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(space) = space {
            let [x, y, z, sign] = space.tangent_encoded();
            // MikkTSpace's bitangent follows v, which points down in glTF; a normal map's green points up.
            self.tangents[3 * face + corner] = [x, y, z, -sign];
        }
    }
}

/// Where in the picture a vertex lies, after `KHR_texture_transform`.
fn texture_point(mesh: &Mesh, texture: &Texture, vertex: usize) -> DVec2 {
    let [u, v] = mesh.uvs[texture.uv_set][vertex].map(f64::from);
    let row = |row: [f32; 3]| f64::from(row[0]) * u + f64::from(row[1]) * v + f64::from(row[2]);
    DVec2::new(row(texture.uv_transform[0]), row(texture.uv_transform[1]))
}

/// True where no point has so many triangles that MikkTSpace would take long.
pub(super) fn suits_mikktspace(mesh: &Mesh) -> bool {
    // Adding 0 turns -0 into 0, which MikkTSpace takes for the same place.
    let place = |vertex: &u32| mesh.positions[*vertex as usize].map(|x| (x + 0.0).to_bits());
    let mut places: Vec<[u32; 3]> = mesh.indices.iter().map(place).collect();
    places.sort_unstable();
    let mut squares = 0usize;
    for run in places.chunk_by(|a, b| a == b) {
        if run.len() > MAX_TRIANGLES_AT_POINT {
            return false;
        }
        squares += run.len() * run.len();
    }
    squares <= SQUARES_BASE + SQUARES_PER_CORNER * places.len()
}

/// Gives `mesh` MikkTSpace tangents, splitting vertices where triangles disagree. Returns how many have none and were
/// replaced.
pub(super) fn make_mikktspace(mesh: &mut Mesh, texture: &Texture) -> u64 {
    let mut soup = Soup { mesh, texture, tangents: vec![[0.0; 4]; mesh.indices.len()] };
    if generate_tangents(&mut soup).is_err() {
        return make_averaged(mesh, texture);
    }
    let mut tangents = soup.tangents;
    let mut replaced = 0;
    for (tangent, vertex) in tangents.iter_mut().zip(&mesh.indices) {
        replaced += repair_one(tangent, mesh.normals[*vertex as usize]);
    }
    weld(mesh, &tangents);
    replaced
}

/// One vertex for each pair of old vertex and tangent.
fn weld(mesh: &mut Mesh, corner_tangents: &[[f32; 4]]) {
    const NONE: u32 = u32::MAX;
    // New vertices of an old one are chained, newest first; a chain is no longer than the triangles at the vertex.
    let mut newest = vec![NONE; mesh.positions.len()];
    let mut older = Vec::new();
    let mut origin = Vec::new();
    let mut tangents: Vec<[f32; 4]> = Vec::new();
    for (corner, tangent) in mesh.indices.iter_mut().zip(corner_tangents) {
        let vertex = *corner as usize;
        let mut at = newest[vertex];
        while at != NONE && tangents[at as usize] != *tangent {
            at = older[at as usize];
        }
        if at == NONE {
            at = origin.len() as u32;
            origin.push(*corner);
            tangents.push(*tangent);
            older.push(newest[vertex]);
            newest[vertex] = at;
        }
        *corner = at;
    }
    mesh.tangents.clear();
    select(mesh, &origin);
    mesh.tangents = tangents;
}

/// Gives each vertex of `mesh` the mean direction of u over its triangles. Returns how many have none and were
/// replaced.
pub(super) fn make_averaged(mesh: &mut Mesh, texture: &Texture) -> u64 {
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO); mesh.positions.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [triangle[0] as usize, triangle[1] as usize, triangle[2] as usize];
        let point = |vertex: usize| vector(mesh.positions[vertex]);
        let (e1, e2) = (point(b) - point(a), point(c) - point(a));
        let origin = texture_point(mesh, texture, a);
        let (d1, d2) = (texture_point(mesh, texture, b) - origin, texture_point(mesh, texture, c) - origin);
        let determinant = d1.perp_dot(d2);
        if determinant == 0.0 || !determinant.is_finite() {
            continue;
        }
        let sign = determinant.signum();
        let (along_u, along_v) = ((e1 * d2.y - e2 * d1.y) * sign, (e2 * d1.x - e1 * d2.x) * sign);
        for vertex in [a, b, c] {
            sums[vertex].0 += along_u;
            sums[vertex].1 += along_v;
        }
    }
    mesh.tangents = Vec::with_capacity(sums.len());
    let mut replaced = 0;
    for ((along_u, along_v), normal) in sums.into_iter().zip(&mesh.normals) {
        let n = vector(*normal);
        let across = (along_u - n * n.dot(along_u)).try_normalize().unwrap_or(DVec3::ZERO);
        let sign = if n.cross(across).dot(along_v) > 0.0 { -1.0 } else { 1.0 };
        let [x, y, z] = across.as_vec3().to_array();
        let mut tangent = [x, y, z, sign];
        replaced += repair_one(&mut tangent, *normal);
        mesh.tangents.push(tangent);
    }
    replaced
}

/// Brings the file's tangents to unit length and a sign of 1 or -1. Returns how many had no direction across the normal
/// and were replaced.
pub(super) fn repair(mesh: &mut Mesh) -> u64 {
    mesh.tangents.iter_mut().zip(&mesh.normals).map(|(tangent, normal)| repair_one(tangent, *normal)).sum()
}

fn repair_one(tangent: &mut [f32; 4], normal: [f32; 3]) -> u64 {
    let sign = if tangent[3] < 0.0 { -1.0 } else { 1.0 };
    let normal = vector(normal);
    let unit = vector([tangent[0], tangent[1], tangent[2]]).try_normalize();
    // Less than a microradian from the normal nothing is left of the direction in f32.
    let kept = unit.filter(|t| (*t - normal * normal.dot(*t)).length_squared() > 1e-12);
    let [x, y, z] = kept.unwrap_or_else(|| normal.any_orthonormal_vector()).as_vec3().to_array();
    *tangent = [x, y, z, sign];
    u64::from(kept.is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{IDENTITY_UV, Sampler};

    fn texture() -> Texture {
        Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV }
    }

    /// A square facing +Z with the picture upright on it; the right half mirrored where `mirror` is set.
    fn square(mirror: bool) -> Mesh {
        let mut mesh = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..Mesh::default()
        };
        mesh.uvs[0] = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        if mirror {
            mesh.positions.push([2.0, 0.0, 0.0]);
            mesh.normals.push([0.0, 0.0, 1.0]);
            mesh.uvs[0].push([0.0, 1.0]);
            mesh.indices.extend([1, 4, 2]);
        }
        mesh
    }

    #[test]
    fn green_points_up_and_red_right() {
        let mut a = square(false);
        assert_eq!(make_mikktspace(&mut a, &texture()), 0);
        let mut b = square(false);
        assert_eq!(make_averaged(&mut b, &texture()), 0);
        for mesh in [&a, &b] {
            assert_eq!(mesh.positions.len(), 4);
            for tangent in &mesh.tangents {
                assert!(vector([tangent[0], tangent[1], tangent[2]]).abs_diff_eq(DVec3::X, 1e-6));
                assert_eq!(tangent[3], 1.0);
            }
        }
    }

    #[test]
    fn mirrored_pictures_split_vertices() {
        let mut mesh = square(true);
        make_mikktspace(&mut mesh, &texture());
        assert_eq!(mesh.positions.len(), 7, "vertices 1 and 2 have two tangents each");
        let mirrored = mesh.indices[6] as usize;
        assert_eq!(mesh.positions[mirrored], [1.0, 0.0, 0.0]);
        assert_eq!(mesh.tangents[mirrored][3], -1.0);
        assert!(mesh.tangents[mirrored][0] < -0.99);
    }

    #[test]
    fn lost_tangents_are_replaced_and_counted() {
        let mut mesh = square(false);
        mesh.tangents = vec![[0.0; 4], [f32::NAN; 4], [0.0, 0.0, 3.0, -2.0], [4.0, 0.0, 0.0, -0.5]];
        assert_eq!(repair(&mut mesh), 3);
        for tangent in &mesh.tangents {
            let t = vector([tangent[0], tangent[1], tangent[2]]);
            assert!((t.length() - 1.0).abs() < 1e-6 && t.z.abs() < 1e-6, "{tangent:?}");
        }
        assert_eq!(mesh.tangents.iter().map(|t| t[3]).collect::<Vec<_>>(), [1.0, 1.0, -1.0, -1.0]);
        let mut flat = square(false);
        flat.uvs[0] = vec![[0.5; 2]; 4];
        assert!(make_mikktspace(&mut flat, &texture()) > 0);
        assert!(flat.tangents.iter().all(|t| t.iter().all(|x| x.is_finite())));
    }

    #[test]
    fn a_point_with_many_triangles_is_left_to_the_mean() {
        let mut fan = Mesh { positions: vec![[0.0; 3]], ..Mesh::default() };
        for i in 0..1100u32 {
            let angle = i as f32 * 0.005;
            fan.positions.push([angle.cos(), angle.sin(), 0.0]);
            if i > 0 {
                fan.indices.extend([0, i, i + 1]);
            }
        }
        assert!(!suits_mikktspace(&fan));
        fan.indices.truncate(300);
        assert!(suits_mikktspace(&fan));
    }
}
