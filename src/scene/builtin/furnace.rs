//! The white furnace: a closed room of one albedo that emits `1 - albedo`, so that light in equilibrium has radiance
//! `(1 - albedo) / (1 - albedo) = 1` everywhere and in every direction.

use super::build::{Builder, Cuboid, Facing, Side, add_material, add_placed, camera, matte};
use crate::scene::{Material, Scene};

/// Half the edge of the room, metres.
const HALF: f64 = 2.0;

/// Cells along each edge of a wall.
const CELLS: usize = 4;

/// At albedo 1 nothing emits and the room is black.
pub fn build(albedo: f64) -> Scene {
    let mut scene = Scene::default();
    let albedo = albedo as f32;
    // Subtracted in f32, so that what the two stored numbers add up to is within one rounding of 1.
    let surface = Material { emissive: [1.0 - albedo; 3], ..matte("furnace", [albedo; 3], 1.0) };
    let material = add_material(&mut scene, surface);
    let mut builder = Builder::new("room", material);
    let room = Cuboid::new([-HALF; 3], [HALF; 3]).with_cells([CELLS; 3]);
    builder.sides(&room, &Side::ALL, Facing::Inward);
    add_placed(&mut scene, builder);
    scene.cameras.push(camera("inside", [0.4, 0.2, 1.5], [-0.6, -0.3, -2.0], 70.0));
    scene
}
