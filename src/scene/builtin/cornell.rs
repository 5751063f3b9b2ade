//! A box of 5.5 m with a red and a green wall, after the scene of Goral et al., "Modeling the interaction of light between
//! diffuse surfaces" (SIGGRAPH 1984) in the proportions that Cornell published later.

use glam::{DMat4, DQuat, DVec3};

use super::build::{
    Builder, Cuboid, Facing, Side, add_material, add_mesh, add_placed, camera, emitter, matte, place, point_light,
};
use crate::scene::Scene;

/// Half the width and the depth, and half the height, in metres.
const HALF: f64 = 2.75;

/// Cells along each edge of a wall.
const CELLS: usize = 4;

/// Width, height, depth (m); rotation about +Y (degrees); centre on the floor (x, z).
const BLOCKS: [([f64; 3], f64, [f64; 2]); 2] =
    [([1.65, 1.65, 1.65], -17.0, [0.93, 1.0]), ([1.65, 3.3, 1.65], 20.0, [-0.9, -0.75])];

/// The box is open to the front; the light is a panel just below the ceiling and a point light below the panel.
pub fn build() -> Scene {
    let mut scene = Scene::default();
    let white = add_material(&mut scene, matte("white", [0.73, 0.73, 0.73], 1.0));
    let red = add_material(&mut scene, matte("red", [0.63, 0.06, 0.05], 1.0));
    let green = add_material(&mut scene, matte("green", [0.14, 0.45, 0.09], 1.0));
    let panel = add_material(&mut scene, emitter("panel", [17.0, 12.0, 4.0]));

    let room = Cuboid::new([-HALF, 0.0, -HALF], [HALF, 2.0 * HALF, HALF]).with_cells([CELLS; 3]);
    let walls: [(&str, usize, &[Side]); 3] = [
        ("floor, ceiling and back", white, &[Side::Bottom, Side::Top, Side::Back]),
        ("left wall", red, &[Side::Left]),
        ("right wall", green, &[Side::Right]),
    ];
    for (name, material, sides) in walls {
        let mut builder = Builder::new(name, material);
        builder.sides(&room, sides, Facing::Inward);
        add_placed(&mut scene, builder);
    }

    let mut builder = Builder::new("ceiling panel", panel);
    // The lower side of a box: 1.3 m x 1.05 m, 1 cm below the ceiling, facing down.
    let lamp = Cuboid::new([-0.65, 2.0 * HALF - 0.01, -0.525], [0.65, 2.0 * HALF, 0.525]).with_cells([2; 3]);
    builder.side(&lamp, Side::Bottom, Facing::Outward);
    add_placed(&mut scene, builder);

    let mut builder = Builder::new("block", white);
    // Without the lower side, which would lie on the floor and see nothing.
    let unit = Cuboid::new([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]).with_cells([2; 3]);
    let seen = [Side::Left, Side::Right, Side::Top, Side::Back, Side::Front];
    builder.sides(&unit, &seen, Facing::Outward);
    let block = add_mesh(&mut scene, builder);
    for (size, degrees, [x, z]) in BLOCKS {
        let rotation = DQuat::from_rotation_y(f64::to_radians(degrees));
        let to_world = DMat4::from_scale_rotation_translation(DVec3::from_array(size), rotation, DVec3::new(x, 0.0, z));
        place(&mut scene, block, to_world);
    }

    // About what the panel sends straight down: radiance times area, 17 * 1.365.
    scene.lights.push(point_light("below the panel", [1.0, 0.7, 0.24], 23.0, DVec3::new(0.0, 5.2, 0.0)));
    scene.cameras.push(camera("front", [0.0, HALF, 10.6], [0.0, HALF, 0.0], 39.5));
    scene
}
