//! Two rooms and a door between them, for light that must not leak: the walls of the lit room are slabs of 5 cm, those of
//! the dark room sheets without thickness. Walls end inside their neighbours, so that no seam is left to chance.

use glam::DVec3;

use super::build::{Builder, Cuboid, Facing, Side, add_material, add_placed, camera, emitter, matte, point_light};
use crate::scene::{Material, Scene};

/// Of each room, metres. The lit room lies at x < 0, the dark room at x > 0.
const LENGTH: f64 = 4.0;

/// Of both rooms, along z.
const HALF_WIDTH: f64 = 2.0;

/// Of both rooms.
const HEIGHT: f64 = 2.6;

/// Of a slab.
const THICK: f64 = 0.05;

/// How deep a slab's end lies inside its neighbour.
const EMBED: f64 = THICK / 2.0;

/// Metres.
const DOOR_HEIGHT: f64 = 2.0;

/// A narrower door is none: its sides would be slivers.
const NARROWEST_DOOR: f64 = 0.001;

/// `door` is the width of the opening in metres.
pub fn build(door: f64) -> Scene {
    let mut scene = Scene::default();
    let slab = add_material(&mut scene, matte("slab", [0.7, 0.68, 0.64], 0.9));
    let sheet = Material { double_sided: true, ..matte("sheet", [0.6, 0.65, 0.7], 0.9) };
    let sheet = add_material(&mut scene, sheet);
    let screen = Material { double_sided: true, ..matte("screen", [0.7, 0.3, 0.2], 0.9) };
    let screen = add_material(&mut scene, screen);
    let panel = add_material(&mut scene, emitter("panel", [20.0, 19.0, 17.0]));

    add_placed(&mut scene, lit_room(slab));
    add_placed(&mut scene, dark_room(sheet));
    add_placed(&mut scene, dividing_wall(slab, door));

    let mut builder = Builder::new("screen", screen);
    // One sheet across half of the dark room.
    let corner = DVec3::new(2.2, 0.0, 0.4);
    builder.quad(corner, DVec3::new(0.0, 0.0, -HALF_WIDTH - 0.4), DVec3::Y * HEIGHT, [4, 4]);
    add_placed(&mut scene, builder);

    let mut builder = Builder::new("panel", panel);
    let lamp = Cuboid::new([-2.5, HEIGHT - 0.01, -0.5], [-1.5, HEIGHT, 0.5]).with_cells([2; 3]);
    builder.side(&lamp, Side::Bottom, Facing::Outward);
    add_placed(&mut scene, builder);
    scene.lights.push(point_light("below the panel", [1.0, 0.95, 0.85], 20.0, DVec3::new(-2.0, 2.4, 0.0)));

    scene.cameras.push(camera("dark room", [3.8, 1.6, 1.4], [0.0, 1.2, -0.1], 60.0));
    scene.cameras.push(camera("lit room", [-3.8, 1.6, 1.4], [0.0, 1.2, -0.1], 60.0));
    scene
}

/// Floor, ceiling and three walls of 5 cm; the fourth is the dividing wall. What reaches past a corner does so by
/// different lengths, so that no two faces share a plane.
fn lit_room(material: usize) -> Builder {
    let mut builder = Builder::new("lit room", material);
    let (end, side) = (-LENGTH - THICK, HALF_WIDTH + THICK);
    let (low, high) = (-EMBED, HEIGHT + EMBED);
    let slabs = [
        ([end - THICK, -THICK, -side - EMBED], [0.0, 0.0, side + EMBED], [8, 1, 8]),
        ([end - THICK, HEIGHT, -side - EMBED], [0.0, HEIGHT + THICK, side + EMBED], [8, 1, 8]),
        ([end, low, -HALF_WIDTH - EMBED], [-LENGTH, high, HALF_WIDTH + EMBED], [1, 6, 8]),
        ([end - EMBED, low, HALF_WIDTH], [-EMBED / 2.0, high, side], [8, 6, 1]),
        ([end - EMBED, low, -side], [-EMBED / 2.0, high, -HALF_WIDTH], [8, 6, 1]),
    ];
    for (min, max, cells) in slabs {
        builder.cuboid(&Cuboid::new(min, max).with_cells(cells));
    }
    builder
}

/// Five sheets that begin inside the dividing wall.
fn dark_room(material: usize) -> Builder {
    let mut builder = Builder::new("dark room", material);
    let room = Cuboid::new([0.0, 0.0, -HALF_WIDTH], [LENGTH, HEIGHT, HALF_WIDTH]).with_cells([8, 6, 8]);
    let sides = [Side::Right, Side::Bottom, Side::Top, Side::Back, Side::Front];
    builder.sides(&room, &sides, Facing::Inward);
    builder
}

/// The wall at x = 0, cut into cells along the door's edges so that no edge meets another one's middle.
fn dividing_wall(material: usize, door: f64) -> Builder {
    let mut builder = Builder::new("dividing wall", material);
    let half = HALF_WIDTH + EMBED;
    let (low, high) = (-EMBED, HEIGHT + EMBED);
    if door < NARROWEST_DOOR {
        let wall = Cuboid::new([-EMBED, low, -half], [EMBED, high, half]).with_cells([1, 6, 8]);
        builder.cuboid(&wall);
        return builder;
    }
    let jamb = door / 2.0;
    let part = |y: [f64; 2], z: [f64; 2], cells: [usize; 3]| {
        Cuboid::new([-EMBED, y[0], z[0]], [EMBED, y[1], z[1]]).with_cells(cells)
    };
    let faces = [Side::Left, Side::Right];
    let (beside, above) = ([low, DOOR_HEIGHT], [DOOR_HEIGHT, high]);
    for (y, rows) in [(beside, 5), (above, 2)] {
        let left = part(y, [-half, -jamb], [1, rows, 4]);
        let right = part(y, [jamb, half], [1, rows, 4]);
        builder.sides(&left, &faces, Facing::Outward);
        builder.side(&left, Side::Back, Facing::Outward);
        builder.sides(&right, &faces, Facing::Outward);
        builder.side(&right, Side::Front, Facing::Outward);
        if y == above {
            let lintel = part(y, [-jamb, jamb], [1, rows, 2]);
            builder.sides(&lintel, &[Side::Left, Side::Right, Side::Bottom], Facing::Outward);
            for piece in [&left, &lintel, &right] {
                builder.side(piece, Side::Top, Facing::Outward);
            }
        } else {
            builder.side(&left, Side::Front, Facing::Outward);
            builder.side(&right, Side::Back, Facing::Outward);
            builder.side(&left, Side::Bottom, Facing::Outward);
            builder.side(&right, Side::Bottom, Facing::Outward);
        }
    }
    // The sill covers the seam between the two floors.
    let sill = Cuboid::new([-0.02, low, -jamb - EMBED], [0.02, 0.01, jamb + EMBED]);
    builder.cuboid(&sill);
    builder
}
