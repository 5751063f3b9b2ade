//! A court of 30 m x 12 m x 14 m between two storeys of arcades, in the class of the Sponza palace: many small surfaces,
//! long views between columns, an open roof. 256 coloured point lights are scattered in it; `--lights` scatters others.
//!
//! An arcade is described in its own frame: x along it, +y up, +z towards the court, the line of its columns at
//! z = -distance. Four such frames, a quarter turn apart, make the court.

mod parts;

use glam::{DMat4, DVec3};

use super::build::{Builder, add_material, add_mesh, add_placed, camera, matte, metal, place, quarter_turns};
use crate::math::random::Random;
use crate::scene::Scene;
use crate::scene::scatter;
use parts::Detail;

/// From column to column, metres.
const SPACING: f64 = 3.0;

/// The four sides of the court.
const ARCADES: [Arcade; 4] = [
    Arcade { bays: 8, distance: 4.5, wall: 7.0 },
    Arcade { bays: 3, distance: 12.0, wall: 15.0 },
    Arcade { bays: 8, distance: 4.5, wall: 7.0 },
    Arcade { bays: 3, distance: 12.0, wall: 15.0 },
];

/// One side of the court; its place in [`ARCADES`] is its number of quarter turns.
struct Arcade {
    bays: usize,
    /// Of the columns from the middle, metres.
    distance: f64,
    /// Of the outer wall from the middle, metres.
    wall: f64,
}

/// Heights in metres: the floor, where the arches spring, and the underside of the slab above.
struct Storey {
    floor: f64,
    spring: f64,
    ceiling: f64,
}

const STOREYS: [Storey; 2] =
    [Storey { floor: 0.0, spring: 3.0, ceiling: 4.8 }, Storey { floor: 5.2, spring: 7.6, ceiling: 9.4 }];

/// Height of [`parts::column`].
const COLUMN_HEIGHT: f64 = 3.0;

/// The upper columns are a little slimmer.
const UPPER_WIDTH: f64 = 0.9;

/// Along one bay of the gallery.
const BALUSTERS: usize = 7;

/// Metres between balusters.
const BALUSTER_SPACING: f64 = 0.3;

/// Edge of a floor tile, metres.
const TILE: f64 = 1.0;

/// Coloured point lights of the scene as it is drawn without further options.
const LIGHTS: usize = 256;

/// The court at a detail of 1 to 4; the number of triangles grows with it about in proportion.
pub fn build(detail: usize) -> Scene {
    let detail = Detail(detail);
    let mut scene = Scene::default();
    floor(&mut scene, detail);
    shell(&mut scene, detail);
    arcades(&mut scene, detail);
    gallery(&mut scene, detail);
    curtains(&mut scene, detail);
    let basin = add_material(&mut scene, matte("basin", [0.48, 0.47, 0.45], 0.6));
    add_placed(&mut scene, parts::fountain(basin, detail));
    scene.cameras.push(camera("court", [-10.5, 1.7, 2.2], [6.0, 3.4, -1.5], 60.0));
    scene.cameras.push(camera("top-down", [0.0, 30.0, 0.0], [0.0, 0.0, 0.0], 55.0));
    scene.cameras.push(camera("gallery", [-13.3, 6.9, -5.9], [8.0, 4.5, 2.0], 60.0));
    scene.lights = scatter::point_lights(&scene.bounds(), LIGHTS, 1);
    scene
}

impl Arcade {
    /// Along the arcade, from its middle, where column `index` stands; index = bays is the first of the next arcade.
    fn column(&self, index: usize) -> f64 {
        (index as f64 - self.bays as f64 / 2.0) * SPACING
    }

    /// Along the arcade, the middle of bay `index`.
    fn bay(&self, index: usize) -> f64 {
        self.column(index) + SPACING / 2.0
    }
}

/// World transform of a point of an arcade's frame.
fn at(turns: usize, x: f64, y: f64, z: f64) -> DMat4 {
    quarter_turns(turns) * DMat4::from_translation(DVec3::new(x, y, z))
}

/// Square tiles of four tints at random, one mesh a tint.
fn floor(scene: &mut Scene, detail: Detail) {
    const TINTS: [[f32; 3]; 4] = [[0.55, 0.5, 0.44], [0.5, 0.44, 0.38], [0.6, 0.56, 0.5], [0.45, 0.38, 0.33]];
    let mut random = Random::new(0x7113);
    let mut tints: Vec<Builder> = (0..TINTS.len())
        .map(|tint| {
            let name = format!("floor tiles {tint}");
            let material = add_material(scene, matte(&name, TINTS[tint], 0.5 + 0.1 * tint as f32));
            Builder::new(name, material)
        })
        .collect();
    let (half_x, half_z) = (ARCADES[1].wall, ARCADES[0].wall);
    let (columns, rows) = ((2.0 * half_x / TILE) as usize, (2.0 * half_z / TILE) as usize);
    let cells = [detail.times(2); 2];
    for row in 0..rows {
        for column in 0..columns {
            let tint = (random.next_u64() >> 62) as usize;
            let corner = DVec3::new(column as f64 * TILE - half_x, 0.0, row as f64 * TILE - half_z);
            tints[tint].quad(corner, DVec3::Z * TILE, DVec3::X * TILE, cells);
        }
    }
    for builder in tints {
        add_placed(scene, builder);
    }
}

/// Outer walls, the slabs of gallery and roof, the attic above the arcades and its cornice. Each piece ends inside the next.
fn shell(scene: &mut Scene, detail: Detail) {
    let plaster = add_material(scene, matte("plaster", [0.7, 0.62, 0.5], 0.95));
    let stone = add_material(scene, matte("slab stone", [0.58, 0.55, 0.5], 0.85));
    let walls = [ARCADES[1].wall, ARCADES[0].wall];
    let columns = [ARCADES[1].distance, ARCADES[0].distance];
    let from = |base: [f64; 2], distance: f64| base.map(|b| b + distance);
    // Name, material, lower and upper edge, outer and inner edge, cells across and up.
    let rings = [
        ("outer walls", plaster, [-0.2, 9.6], from(walls, 0.3), walls, [1, 8]),
        ("gallery slab", stone, [4.8, 5.2], from(walls, 0.1), from(columns, -0.4), [3, 1]),
        ("roof slab", stone, [9.4, 9.8], from(walls, 0.4), from(columns, -0.4), [3, 1]),
        ("attic", plaster, [9.7, 11.7], from(columns, 0.25), from(columns, -0.25), [1, 2]),
        ("cornice", stone, [11.6, 12.0], from(columns, 0.4), from(columns, -0.4), [1, 1]),
    ];
    for (name, material, height, outer, inner, cells) in rings {
        let mut builder = Builder::new(name, material);
        parts::Ring { outer, inner, height, cells }.add(&mut builder, detail);
        add_placed(scene, builder);
    }
    let mesh = add_mesh(scene, parts::pilaster(plaster, detail));
    for (turns, arcade) in ARCADES.iter().enumerate() {
        for index in 0..=arcade.bays {
            for storey in &STOREYS {
                let scale = DMat4::from_scale(DVec3::new(1.0, storey.ceiling - storey.floor, 1.0));
                place(scene, mesh, at(turns, arcade.column(index), storey.floor, -arcade.wall) * scale);
            }
        }
    }
}

/// Columns, arches and the piers in the corners where two arcades meet, on both storeys.
fn arcades(scene: &mut Scene, detail: Detail) {
    let marble = add_material(scene, matte("marble", [0.72, 0.7, 0.66], 0.4));
    let stone = add_material(scene, matte("arch stone", [0.66, 0.6, 0.52], 0.8));
    let column = add_mesh(scene, parts::column(marble, detail));
    let arch = add_mesh(scene, parts::arch(stone, SPACING, STOREYS[0].ceiling - STOREYS[0].spring, detail));
    let pier = add_mesh(scene, parts::pier(stone, STOREYS[0].ceiling - STOREYS[0].spring, detail));
    for (turns, arcade) in ARCADES.iter().enumerate() {
        for storey in &STOREYS {
            let width = if storey.floor > 0.0 { UPPER_WIDTH } else { 1.0 };
            let scale = DVec3::new(width, (storey.spring - storey.floor) / COLUMN_HEIGHT, width);
            for bay in 0..arcade.bays {
                let foot = at(turns, arcade.column(bay), storey.floor, -arcade.distance);
                place(scene, column, foot * DMat4::from_scale(scale));
                place(scene, arch, at(turns, arcade.bay(bay), storey.spring, -arcade.distance));
            }
            place(scene, pier, at(turns, arcade.column(0), storey.spring, -arcade.distance));
        }
    }
}

/// The balustrade between the columns of the upper storey.
fn gallery(scene: &mut Scene, detail: Detail) {
    let stone = add_material(scene, matte("balustrade", [0.68, 0.66, 0.62], 0.6));
    let rail = add_mesh(scene, parts::rail(stone, detail));
    let baluster = add_mesh(scene, parts::baluster(stone, detail));
    let floor = STOREYS[1].floor;
    for (turns, arcade) in ARCADES.iter().enumerate() {
        for bay in 0..arcade.bays {
            place(scene, rail, at(turns, arcade.bay(bay), floor, -arcade.distance));
            for index in 0..BALUSTERS {
                let x = arcade.bay(bay) + (index as f64 - (BALUSTERS - 1) as f64 / 2.0) * BALUSTER_SPACING;
                place(scene, baluster, at(turns, x, floor + parts::PLINTH, -arcade.distance));
            }
        }
    }
}

/// Cloth in front of every other bay of the long sides, each on a rod held by the gallery slab.
fn curtains(scene: &mut Scene, detail: Detail) {
    const COLORS: [(&str, [f32; 3]); 4] = [
        ("red cloth", [0.55, 0.06, 0.05]),
        ("blue cloth", [0.06, 0.14, 0.5]),
        ("green cloth", [0.07, 0.36, 0.12]),
        ("yellow cloth", [0.7, 0.5, 0.1]),
    ];
    let brass = add_material(scene, metal("brass", [0.75, 0.6, 0.3], 0.4));
    let rod = add_mesh(scene, parts::curtain_rod(brass, detail));
    let mut cloths = Vec::new();
    for (index, (name, color)) in COLORS.into_iter().enumerate() {
        let mut material = matte(name, color, 1.0);
        material.double_sided = true;
        let material = add_material(scene, material);
        cloths.push(add_mesh(scene, parts::curtain(name, material, index as f64 * 1.7, detail)));
    }
    let mut hung = 0;
    for turns in [0, 2] {
        let arcade = &ARCADES[turns];
        for bay in (1..arcade.bays).step_by(2) {
            let frame = at(turns, arcade.bay(bay), 0.0, -arcade.distance);
            place(scene, rod, frame);
            // The other side begins with another colour, so that opposite curtains differ.
            place(scene, cloths[(hung + turns / 2) % cloths.len()], frame);
            hung += 1;
        }
    }
}
