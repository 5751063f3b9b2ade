//! A hall with panes of coloured glass behind each other, pillars between them and a sphere of glass: for surfaces that are mixed with what
//! lies behind them.

use glam::{DMat4, DVec2, DVec3};

use super::build::{Builder, Cuboid, Facing, Side, add_material, add_placed, camera, full_turn, matte, point_light};
use crate::scene::{AlphaMode, Material, Scene};

/// Half the width of the hall, its height and its length along -z, metres.
const HALL: [f64; 3] = [5.0, 4.0, 24.0];

/// Width and height of a pane, metres.
const PANE: [f64; 2] = [3.4, 3.0];

/// Lights along the hall.
const LIGHTS: usize = 48;

const TINTS: [[f32; 3]; 6] =
    [[0.9, 0.35, 0.3], [0.3, 0.8, 0.4], [0.35, 0.5, 0.95], [0.9, 0.8, 0.3], [0.7, 0.4, 0.9], [0.4, 0.85, 0.85]];

fn glass(name: &str, tint: [f32; 3], alpha: f32) -> Material {
    let [r, g, b] = tint;
    Material { base_color: [r, g, b, alpha], alpha: AlphaMode::Blend, double_sided: true, ..matte(name, tint, 0.25) }
}

/// `layers` panes.
pub fn build(layers: usize) -> Scene {
    let mut scene = Scene::default();
    let [half, height, length] = HALL;
    let walls = add_material(&mut scene, matte("plaster", [0.7, 0.68, 0.65], 0.9));
    let floor = add_material(&mut scene, matte("floor", [0.45, 0.42, 0.4], 0.5));
    let stone = add_material(&mut scene, matte("pillar", [0.75, 0.7, 0.6], 0.7));
    let room = Cuboid::new([-half, 0.0, -length], [half, height, 2.0]).with_cells([6, 3, 16]);
    let mut builder = Builder::new("walls", walls);
    // Open to the sky.
    builder.sides(&room, &[Side::Left, Side::Right, Side::Back], Facing::Inward);
    add_placed(&mut scene, builder);
    let mut builder = Builder::new("floor", floor);
    builder.side(&room, Side::Bottom, Facing::Inward);
    add_placed(&mut scene, builder);

    for index in 0..layers {
        let along = (index as f64 + 1.0) / (layers as f64 + 1.0);
        let z = -3.0 - along * (length - 6.0);
        // From side to side by the golden section, so that panes overlap in many ways.
        let shift = (index as f64 * 0.618_033_988_75).fract() * 2.0 - 1.0;
        let x = shift * (half - PANE[0] * 0.55);
        let tint = TINTS[index % TINTS.len()];
        let material = add_material(&mut scene, glass(&format!("glass {index}"), tint, 0.35));
        let mut builder = Builder::new(format!("pane {index}"), material);
        let corner = DVec3::new(x - PANE[0] * 0.5, 0.2, z);
        builder.quad(corner, DVec3::X * PANE[0], DVec3::Y * PANE[1], [2, 2]);
        add_placed(&mut scene, builder);
        if index % 2 == 0 {
            let side = if index % 4 == 0 { 1.0 } else { -1.0 };
            let at = [side * (half - 1.2), z - 0.9];
            let mut builder = Builder::new(format!("pillar {index}"), stone);
            let (low, high) = ([at[0] - 0.25, 0.0, at[1] - 0.25], [at[0] + 0.25, height * 0.8, at[1] + 0.25]);
            builder.sides(&Cuboid::new(low, high).with_cells([1, 4, 1]), &Side::UPRIGHT, Facing::Outward);
            builder.side(&Cuboid::new(low, high), Side::Top, Facing::Outward);
            add_placed(&mut scene, builder);
        }
    }

    let bubble = add_material(&mut scene, glass("bubble", [0.95, 0.95, 1.0], 0.25));
    let mut builder = Builder::new("bubble", bubble);
    let profile: Vec<DVec2> = (0..=12)
        .map(|step| {
            let (sin, cos) = (f64::from(step) / 12.0 * std::f64::consts::PI).sin_cos();
            DVec2::new(0.7 * sin, -0.7 * cos)
        })
        .collect();
    builder.revolve(&profile, &full_turn(20), &DMat4::from_translation(DVec3::new(-1.3, 1.1, -3.2)));
    add_placed(&mut scene, builder);

    for index in 0..LIGHTS {
        let along = (index as f64 + 0.5) / LIGHTS as f64;
        let x = ((index as f64 * 0.754_877_666).fract() * 2.0 - 1.0) * (half - 0.6);
        let y = 0.4 + (index as f64 * 0.569_840_291).fract() * (height - 0.8);
        let [r, g, b] = TINTS[(index * 5 + 1) % TINTS.len()];
        let color = [r * 0.5 + 0.5, g * 0.5 + 0.5, b * 0.5 + 0.5];
        let place = DVec3::new(x, y, 1.0 - along * (length - 1.0));
        scene.lights.push(point_light(&format!("lamp {index}"), color, 4.0, place));
    }
    scene.cameras.push(camera("along the hall", [0.3, 1.7, 1.2], [-0.2, 1.5, -12.0], 55.0));
    scene.cameras.push(camera("from above", [4.2, 3.6, 0.5], [-1.5, 0.8, -9.0], 60.0));
    scene
}
