//! Building blocks of the procedural scenes. Everything is computed in f64 and rounded to f32 once.

use std::f64::consts::TAU;

use glam::{DMat4, DVec2, DVec3};

use crate::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene};

/// Cosine of 37 degrees: segments of a profile that meet at less are shaded as one smooth curve.
const CREASE: f64 = 0.8;

/// Parameter step of the difference quotients in [`Builder::surface`]: errors of both kinds stay near 1e-10 for shapes of metres.
const STEP: f64 = 1e-5;

/// A mesh in the making.
pub struct Builder {
    mesh: Mesh,
}

/// An axis-aligned box and how many cells its sides have along x, y and z.
pub struct Cuboid {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
    /// At least 1 each.
    pub cells: [usize; 3],
}

/// A side of a box; twice the axis, plus one on the positive side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// -X
    Left,
    /// +X
    Right,
    /// -Y
    Bottom,
    /// +Y
    Top,
    /// -Z
    Back,
    /// +Z
    Front,
}

impl Side {
    /// Every side.
    pub const ALL: [Self; 6] = [Self::Left, Self::Right, Self::Bottom, Self::Top, Self::Back, Self::Front];
    /// The sides that stand.
    pub const UPRIGHT: [Self; 4] = [Self::Left, Self::Right, Self::Back, Self::Front];
}

/// Which way the sides of a box look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// A solid.
    Outward,
    /// A room.
    Inward,
}

impl Cuboid {
    /// One cell a side.
    pub fn new(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: DVec3::from_array(min), max: DVec3::from_array(max), cells: [1; 3] }
    }

    /// The same box, divided.
    pub fn with_cells(self, cells: [usize; 3]) -> Self {
        Self { cells, ..self }
    }
}

impl Builder {
    /// An empty mesh.
    pub fn new(name: impl Into<String>, material: usize) -> Self {
        Self { mesh: Mesh { name: name.into(), material, ..Mesh::default() } }
    }

    /// The mesh.
    pub fn finish(self) -> Mesh {
        self.mesh
    }

    /// `columns` x `rows` cells. `vertex(column, row)` gives a position and a unit normal; the front is where
    /// d(column) x d(row) points.
    pub fn grid(&mut self, columns: usize, rows: usize, vertex: impl Fn(usize, usize) -> (DVec3, DVec3)) {
        let first = self.mesh.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                let (position, normal) = vertex(column, row);
                self.mesh.positions.push(position.as_vec3().to_array());
                self.mesh.normals.push(normal.as_vec3().to_array());
            }
        }
        let stride = columns as u32 + 1;
        for row in 0..rows as u32 {
            for column in 0..columns as u32 {
                let a = first + row * stride + column;
                self.triangle([a, a + 1, a + stride + 1]);
                self.triangle([a, a + stride + 1, a + stride]);
            }
        }
    }

    /// Leaves out what collapses to a line, as cells do at the pole of a surface of revolution.
    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.mesh.positions[corner as usize]);
        if a != b && b != c && c != a {
            self.mesh.indices.extend(corners);
        }
    }

    /// A parallelogram that faces `along` x `across`.
    pub fn quad(&mut self, corner: DVec3, along: DVec3, across: DVec3, cells: [usize; 2]) {
        let normal = along.cross(across).normalize();
        self.grid(cells[0], cells[1], |column, row| {
            let (s, t) = (column as f64 / cells[0] as f64, row as f64 / cells[1] as f64);
            (corner + along * s + across * t, normal)
        });
    }

    /// A parametric surface over [0, 1]^2 that faces ds x dt; `position` is evaluated a little outside that square too.
    pub fn surface(&mut self, columns: usize, rows: usize, position: impl Fn(f64, f64) -> DVec3) {
        self.grid(columns, rows, |column, row| {
            let (s, t) = (column as f64 / columns as f64, row as f64 / rows as f64);
            let along = position(s + STEP, t) - position(s - STEP, t);
            let across = position(s, t + STEP) - position(s, t - STEP);
            (position(s, t), along.cross(across).normalize())
        });
    }

    /// One side of a box.
    pub fn side(&mut self, cuboid: &Cuboid, side: Side, facing: Facing) {
        let (axis, positive) = (side as usize / 2, side as usize % 2 == 1);
        let size = cuboid.max - cuboid.min;
        let mut corner = cuboid.min;
        if positive {
            corner[axis] = cuboid.max[axis];
        }
        // The axes in cyclic order span a parallelogram that faces the positive way.
        let (mut along, mut across) = ((axis + 1) % 3, (axis + 2) % 3);
        if positive != (facing == Facing::Outward) {
            std::mem::swap(&mut along, &mut across);
        }
        let edge = |axis: usize| DVec3::AXES[axis] * size[axis];
        self.quad(corner, edge(along), edge(across), [cuboid.cells[along], cuboid.cells[across]]);
    }

    /// Some sides of a box.
    pub fn sides(&mut self, cuboid: &Cuboid, sides: &[Side], facing: Facing) {
        for &side in sides {
            self.side(cuboid, side, facing);
        }
    }

    /// All six sides, outward.
    pub fn cuboid(&mut self, cuboid: &Cuboid) {
        self.sides(cuboid, &Side::ALL, Facing::Outward);
    }

    /// Turns `profile`, points (distance from the axis, height), round the +Y axis of the rigid `frame` through `angles`
    /// (increasing, radians, from +X towards -Z). A profile that goes up faces away from the axis.
    pub fn revolve(&mut self, profile: &[DVec2], angles: &[f64], frame: &DMat4) {
        let normals: Vec<DVec2> =
            profile.windows(2).map(|ends| (ends[1] - ends[0]).perp().normalize() * -1.0).collect();
        for (band, ends) in profile.windows(2).enumerate() {
            let own = normals[band];
            let blend = |neighbour: Option<&DVec2>| match neighbour {
                Some(&other) if other.dot(own) > CREASE => (other + own).normalize(),
                _ => own,
            };
            let below = band.checked_sub(1).and_then(|previous| normals.get(previous));
            let shading = [blend(below), blend(normals.get(band + 1))];
            self.grid(angles.len() - 1, 1, |column, row| {
                let (sin, cos) = angles[column].sin_cos();
                let turn = |p: DVec2| DVec3::new(p.x * cos, p.y, -p.x * sin);
                (frame.transform_point3(turn(ends[row])), frame.transform_vector3(turn(shading[row])).normalize())
            });
        }
    }
}

/// A whole turn for [`Builder::revolve`]; it ends exactly where it begins.
pub fn full_turn(segments: usize) -> Vec<f64> {
    (0..=segments).map(|i| TAU * (i % segments) as f64 / segments as f64).collect()
}

/// Each straight part of `profile` divided into `parts`.
pub fn refine(profile: &[DVec2], parts: usize) -> Vec<DVec2> {
    let inner = profile.windows(2).flat_map(|ends| {
        let (from, to) = (ends[0], ends[1]);
        (0..parts).map(move |part| from.lerp(to, part as f64 / parts as f64))
    });
    inner.chain(profile.last().copied()).collect()
}

/// `count` quarter turns round +Y without rounding; one turn takes +Z to +X.
pub fn quarter_turns(count: usize) -> DMat4 {
    let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][count % 4];
    DMat4::from_cols_array(&[cos, 0.0, -sin, 0.0, 0.0, 1.0, 0.0, 0.0, sin, 0.0, cos, 0.0, 0.0, 0.0, 0.0, 1.0])
}

/// A dielectric without textures.
pub fn matte(name: &str, color: [f32; 3], roughness: f32) -> Material {
    let [r, g, b] = color;
    Material { name: name.into(), base_color: [r, g, b, 1.0], metallic: 0.0, roughness, ..Material::default() }
}

/// A bare metal.
pub fn metal(name: &str, color: [f32; 3], roughness: f32) -> Material {
    Material { metallic: 1.0, ..matte(name, color, roughness) }
}

/// A source of the given radiance that reflects nothing.
pub fn emitter(name: &str, radiance: [f32; 3]) -> Material {
    Material { emissive: radiance, ..matte(name, [0.0; 3], 1.0) }
}

/// A point light whose range is left to the cut-off; intensity in candela.
pub fn point_light(name: &str, color: [f32; 3], intensity: f32, position: DVec3) -> Light {
    Light {
        name: name.into(),
        kind: LightKind::Point,
        color,
        intensity,
        position,
        direction: DVec3::NEG_Z,
        range: None,
        shadow: false,
    }
}

/// A perspective camera that sees from 5 cm on; `yfov` in degrees.
pub fn camera(name: &str, from: [f64; 3], at: [f64; 3], yfov: f64) -> Camera {
    let camera = Camera::looking(DVec3::from_array(from), DVec3::from_array(at), yfov.to_radians());
    Camera { name: name.into(), ..camera }
}

/// Adds a material and gives its index.
pub fn add_material(scene: &mut Scene, material: Material) -> usize {
    scene.materials.push(material);
    scene.materials.len() - 1
}

/// Adds a mesh without placing it and gives its index.
pub fn add_mesh(scene: &mut Scene, builder: Builder) -> usize {
    scene.meshes.push(builder.finish());
    scene.meshes.len() - 1
}

/// Places a mesh.
pub fn place(scene: &mut Scene, mesh: usize, object_to_world: DMat4) {
    scene.instances.push(Instance { mesh, object_to_world });
}

/// Adds a mesh whose coordinates are the world's.
pub fn add_placed(scene: &mut Scene, builder: Builder) {
    let mesh = add_mesh(scene, builder);
    place(scene, mesh, DMat4::IDENTITY);
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    /// Volume enclosed by a closed mesh (divergence theorem); negative when it faces inward.
    fn volume(mesh: &Mesh) -> f64 {
        let point = |i: u32| {
            let p = mesh.positions[i as usize];
            DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64)
        };
        mesh.indices.chunks(3).map(|t| point(t[0]).dot(point(t[1]).cross(point(t[2]))) / 6.0).sum()
    }

    #[test]
    fn a_box_encloses_its_volume_either_way() {
        let cuboid = Cuboid::new([1.0, -2.0, 0.5], [3.0, 1.0, 4.5]).with_cells([1, 2, 3]);
        let mut outward = Builder::new("", 0);
        outward.cuboid(&cuboid);
        assert!((volume(&outward.finish()) - 24.0).abs() < 1e-5);
        let mut inward = Builder::new("", 0);
        inward.sides(&cuboid, &Side::ALL, Facing::Inward);
        assert!((volume(&inward.finish()) + 24.0).abs() < 1e-5);
    }

    #[test]
    fn a_revolved_profile_is_closed_and_faces_away_from_the_axis() {
        let profile = refine(&[dvec2(0.0, -1.0), dvec2(1.0, -1.0), dvec2(1.0, 2.0), dvec2(0.0, 3.0)], 2);
        assert_eq!(profile.len(), 7);
        let mut builder = Builder::new("", 0);
        builder.revolve(&profile, &full_turn(64), &quarter_turns(1));
        let mesh = builder.finish();
        // Two poles lose one triangle a segment each.
        assert_eq!(mesh.indices.len() / 3, 64 * (6 * 2 - 2));
        let expected = std::f64::consts::PI * (3.0 + 1.0 / 3.0);
        assert!((volume(&mesh) / expected - 1.0).abs() < 0.01, "{}", volume(&mesh));
    }

    #[test]
    fn quarter_turns_take_z_to_x() {
        assert_eq!(quarter_turns(1).transform_vector3(DVec3::Z), DVec3::X);
        assert_eq!(quarter_turns(2).transform_vector3(DVec3::Z), DVec3::NEG_Z);
        assert_eq!(quarter_turns(3) * quarter_turns(1), DMat4::IDENTITY);
    }
}
