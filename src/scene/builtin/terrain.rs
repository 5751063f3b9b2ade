//! Open country, 200 m x 200 m, under a sun: few occluders near the viewer, long depth ranges, one albedo for everything,
//! which decides how fast bounced light converges.

use std::f64::consts::TAU;

use glam::{DMat4, DQuat, DVec2, DVec3, dvec2};

use super::build::{
    Builder, Cuboid, Facing, Side, add_material, add_mesh, add_placed, camera, full_turn, matte, place,
};
use crate::math::random::Random;
use crate::scene::{Light, LightKind, Scene};

/// Half the edge of the square, metres.
const HALF: f64 = 100.0;

/// Cells along the edge at detail 1.
const CELLS: usize = 128;

/// Lattice of the coarsest octave, metres.
const WAVELENGTH: f64 = 55.0;

/// Height span of the coarsest octave, metres; each further octave has half of it at half the wavelength.
const RELIEF: f64 = 14.0;

/// Of the height.
const OCTAVES: i32 = 3;

/// Where the first camera stands (x, z); nothing is built within the clearing round it.
const VIEWPOINT: DVec2 = dvec2(-62.0, 66.0);

/// Radius, metres.
const CLEARING: f64 = 12.0;

/// Height of a person's eye above the ground, metres.
const EYE: f64 = 1.7;

/// How many of each stand about.
const HOUSES: usize = 45;
const TREES: usize = 260;
const ROCKS: usize = 90;

/// `albedo` is the largest component of every colour; `detail` 1 to 3 multiplies the cells along each edge.
pub fn build(albedo: f64, detail: usize) -> Scene {
    let mut scene = Scene::default();
    let mut tinted = |name: &str, tint: [f64; 3], roughness: f32| {
        add_material(&mut scene, matte(name, tint.map(|t| (t * albedo) as f32), roughness))
    };
    let grass = tinted("ground", [0.85, 1.0, 0.6], 1.0);
    let wall = tinted("wall", [1.0, 0.94, 0.84], 0.9);
    let roof = tinted("roof", [1.0, 0.45, 0.32], 0.8);
    let bark = tinted("bark", [1.0, 0.72, 0.5], 1.0);
    let leaves = tinted("leaves", [0.5, 1.0, 0.35], 1.0);
    let rock = tinted("rock", [1.0, 0.98, 0.95], 0.9);

    let mut builder = Builder::new("ground", grass);
    let cells = CELLS * detail;
    builder.surface(cells, cells, |s, t| {
        let (x, z) = ((2.0 * t - 1.0) * HALF, (2.0 * s - 1.0) * HALF);
        DVec3::new(x, height(x, z), z)
    });
    add_placed(&mut scene, builder);

    let house = [walls(wall), gable_roof(roof)].map(|part| add_mesh(&mut scene, part));
    scatter(&mut scene, &house, HOUSES, [0.8, 1.5], 0x40);
    let tree = [trunk(bark), crown(leaves, detail)].map(|part| add_mesh(&mut scene, part));
    scatter(&mut scene, &tree, TREES, [0.6, 1.6], 0x71);
    let rock = [boulder(rock, detail)].map(|part| add_mesh(&mut scene, part));
    scatter(&mut scene, &rock, ROCKS, [0.3, 1.4], 0x70);

    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional,
        color: [1.0, 0.96, 0.88],
        intensity: 4.0,
        position: DVec3::ZERO,
        direction: DVec3::new(0.55, -0.7, -0.35).normalize(),
        range: None,
        shadow: false,
    });
    let eye = height(VIEWPOINT.x, VIEWPOINT.y) + EYE;
    scene.cameras.push(camera("first-person", [VIEWPOINT.x, eye, VIEWPOINT.y], [20.0, eye - 4.0, -20.0], 60.0));
    scene.cameras.push(camera("top-down", [0.0, 220.0, 0.0], [0.0, 0.0, 0.0], 55.0));
    scene
}

/// Metres above 0 at a point of the plane.
fn height(x: f64, z: f64) -> f64 {
    (0..OCTAVES)
        .map(|octave| {
            let scale = 0.5f64.powi(octave);
            RELIEF * scale * value_noise(x / (WAVELENGTH * scale), z / (WAVELENGTH * scale), octave as u64)
        })
        .sum()
}

/// Random values in [0, 1) at integer points, blended with the quintic that has no kink in its second derivative (Perlin,
/// "Improving noise", SIGGRAPH 2002).
fn value_noise(x: f64, z: f64, seed: u64) -> f64 {
    let (column, row) = (x.floor(), z.floor());
    let value = |i: f64, j: f64| {
        let key = ((column + i) as i64 as u64).wrapping_mul(0x9E37_79B1) ^ (((row + j) as i64 as u64) << 32);
        Random::new(key ^ seed.wrapping_mul(0xD6E8_FEB8_6659_FD93)).unit_f64()
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (s, t) = (fade(x - column), fade(z - row));
    let near = value(0.0, 0.0) * (1.0 - s) + value(1.0, 0.0) * s;
    let far = value(0.0, 1.0) * (1.0 - s) + value(1.0, 1.0) * s;
    near * (1.0 - t) + far * t
}

/// Places `count` copies of `meshes` on the ground, turned and scaled at random, out of the clearing.
fn scatter(scene: &mut Scene, meshes: &[usize], count: usize, scale: [f64; 2], seed: u64) {
    let mut random = Random::new(seed);
    // Half the diagonal of the largest house is under 10 m.
    let reach = HALF - 10.0;
    let mut placed = 0;
    while placed < count {
        let (x, z) = (random.range(-reach, reach), random.range(-reach, reach));
        let turn = DQuat::from_rotation_y(random.range(0.0, TAU));
        let size = DVec3::splat(random.range(scale[0], scale[1]));
        let size = size * DVec3::new(1.0, random.range(0.8, 1.3), random.range(0.8, 1.2));
        if dvec2(x, z).distance(VIEWPOINT) < CLEARING {
            continue;
        }
        let foot = DVec3::new(x, height(x, z), z);
        for &mesh in meshes {
            place(scene, mesh, DMat4::from_scale_rotation_translation(size, turn, foot));
        }
        placed += 1;
    }
}

/// Eaves of a house, metres.
const EAVES: f64 = 3.0;

/// Half the plan of a house, metres.
const PLAN: DVec2 = dvec2(3.0, 4.5);

/// Deep enough to reach the ground on a slope.
const FOUNDATION: f64 = 5.0;

fn walls(material: usize) -> Builder {
    let mut builder = Builder::new("house walls", material);
    let base = Cuboid::new([-PLAN.x, -FOUNDATION, -PLAN.y], [PLAN.x, EAVES, PLAN.y]);
    builder.sides(&base.with_cells([2, 3, 3]), &Side::UPRIGHT, Facing::Outward);
    builder
}

/// A prism that overhangs the walls: two slopes, two gables, an underside.
fn gable_roof(material: usize) -> Builder {
    const OVERHANG: f64 = 0.4;
    const RIDGE: f64 = 2.2;
    let mut builder = Builder::new("house roof", material);
    let (x, z) = (PLAN.x + OVERHANG, PLAN.y + OVERHANG);
    let low = EAVES - 0.05;
    let rise = DVec3::new(0.0, RIDGE, 0.0);
    let (left, right) = (DVec3::new(-x, low, 0.0), DVec3::new(x, low, 0.0));
    let ridge = DVec3::new(0.0, low, 0.0) + rise;
    let depth = DVec3::new(0.0, 0.0, z);
    builder.quad(right + depth, depth * -2.0, ridge - right, [3, 2]);
    builder.quad(left - depth, depth * 2.0, ridge - left, [3, 2]);
    builder.quad(left - depth, right - left, depth * 2.0, [1, 1]);
    // A gable is a quad whose upper edge shrinks to the ridge.
    for (from, to, depth, normal) in [(left, right, depth, DVec3::Z), (right, left, -depth, DVec3::NEG_Z)] {
        builder.grid(2, 1, |column, row| {
            let foot = from.lerp(to, column as f64 / 2.0);
            (if row == 0 { foot + depth } else { ridge + depth }, normal)
        });
    }
    builder
}

fn trunk(material: usize) -> Builder {
    let mut builder = Builder::new("trunk", material);
    builder.revolve(&[dvec2(0.25, -2.0), dvec2(0.18, 2.0)], &full_turn(8), &DMat4::IDENTITY);
    builder
}

fn crown(material: usize, detail: usize) -> Builder {
    let mut builder = Builder::new("crown", material);
    let cone = [dvec2(0.0, 1.6), dvec2(1.6, 1.6), dvec2(0.0, 6.5)];
    builder.revolve(&cone, &full_turn(8 + 4 * detail), &DMat4::IDENTITY);
    builder
}

/// A ball whose rings differ in size, half in the ground.
fn boulder(material: usize, detail: usize) -> Builder {
    let mut builder = Builder::new("boulder", material);
    let profile =
        [dvec2(0.9, -0.8), dvec2(1.15, -0.1), dvec2(1.05, 0.3), dvec2(0.75, 0.7), dvec2(0.4, 0.85), dvec2(0.0, 0.95)];
    builder.revolve(&profile, &full_turn(6 + 3 * detail), &DMat4::IDENTITY);
    builder
}
