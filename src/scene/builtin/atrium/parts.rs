//! The pieces of the atrium, each in its own space; metres.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3, DVec4, dvec2};

use crate::scene::builtin::build::{Builder, Cuboid, Facing, Side, full_turn, quarter_turns, refine};

/// How finely pieces are divided: 1 to 4.
#[derive(Clone, Copy)]
pub struct Detail(pub usize);

impl Detail {
    /// `base` segments at detail 1. A surface has two directions, so each grows with the square root.
    pub fn times(self, base: usize) -> usize {
        (base as f64 * (self.0 as f64).sqrt()).round() as usize
    }

    /// Parts of a profile's segment: 1, 1, 2, 2.
    fn parts(self) -> usize {
        self.times(1)
    }

    /// Cells of about 1 m at detail 1.
    fn cells(self, metres: f64) -> usize {
        self.times(metres.ceil() as usize).max(1)
    }
}

/// Axis of a revolution turned from +Y to +Z, and +X kept: angles then run from +X towards +Y.
const UPRIGHT: DMat4 = DMat4::from_cols(DVec4::X, DVec4::Z, DVec4::NEG_Y, DVec4::W);

/// Axis of a revolution turned from +Y to +X.
const LEVEL: DMat4 = DMat4::from_cols(DVec4::Y, DVec4::X, DVec4::NEG_Z, DVec4::W);

/// How deep a foot stands in its floor, so that no two faces share a plane.
const SUNK: f64 = 0.01;

/// A square-cornered ring round the court.
pub struct Ring {
    /// Half extents along x and z.
    pub outer: [f64; 2],
    /// Half extents along x and z.
    pub inner: [f64; 2],
    /// Lower and upper edge.
    pub height: [f64; 2],
    /// Across and up, at detail 1.
    pub cells: [usize; 2],
}

impl Ring {
    /// Four mitred sides, each with top, underside, inner and outer face.
    pub fn add(&self, builder: &mut Builder, detail: Detail) {
        let [low, high] = self.height;
        let [across, up] = self.cells.map(|cells| detail.times(cells));
        for turns in 0..4 {
            let frame = quarter_turns(turns);
            // Even turns run along x.
            let (along, away) = (turns % 2, 1 - turns % 2);
            let edge = |half: [f64; 2], y: f64| [-half[along], half[along]].map(|x| DVec3::new(x, y, -half[away]));
            let columns = detail.cells(2.0 * self.inner[along]);
            let mut face = |from: [DVec3; 2], to: [DVec3; 2], rows: usize, normal: DVec3| {
                builder.grid(columns, rows, |column, row| {
                    let s = column as f64 / columns as f64;
                    let point = from[0].lerp(from[1], s).lerp(to[0].lerp(to[1], s), row as f64 / rows as f64);
                    (frame.transform_point3(point), frame.transform_vector3(normal))
                });
            };
            face(edge(self.inner, high), edge(self.outer, high), across, DVec3::Y);
            face(edge(self.outer, low), edge(self.inner, low), across, DVec3::NEG_Y);
            face(edge(self.inner, low), edge(self.inner, high), up, DVec3::Z);
            face(edge(self.outer, high), edge(self.outer, low), up, DVec3::NEG_Z);
        }
    }
}

/// Plinth, moulded base, shaft with a slight swell, capital and abacus; 3 m high on the origin.
pub fn column(material: usize, detail: Detail) -> Builder {
    const PROFILE: [DVec2; 14] = [
        dvec2(0.40, 0.15),
        dvec2(0.40, 0.22),
        dvec2(0.36, 0.27),
        dvec2(0.31, 0.30),
        dvec2(0.33, 0.35),
        dvec2(0.28, 0.42),
        dvec2(0.282, 1.20),
        dvec2(0.265, 2.00),
        dvec2(0.24, 2.62),
        dvec2(0.275, 2.64),
        dvec2(0.275, 2.69),
        dvec2(0.25, 2.71),
        dvec2(0.30, 2.82),
        dvec2(0.38, 2.90),
    ];
    let mut builder = Builder::new("column", material);
    let plinth = Cuboid::new([-0.42, -SUNK, -0.42], [0.42, 0.15, 0.42]);
    builder.sides(&plinth, &Side::UPRIGHT, Facing::Outward);
    builder.side(&plinth, Side::Top, Facing::Outward);
    builder.revolve(&refine(&PROFILE, detail.parts()), &full_turn(detail.times(14)), &DMat4::IDENTITY);
    builder.cuboid(&Cuboid::new([-0.4, 2.9, -0.4], [0.4, 3.0, 0.4]));
    builder
}

/// Of an arch's opening.
const ARCH_RADIUS: f64 = 1.2;

/// Half the thickness of an arch's wall.
const ARCH_HALF_DEPTH: f64 = 0.25;

/// How far the moulding round the opening reaches along the wall and out of it.
const MOULDING: DVec2 = dvec2(0.15, 0.05);

/// A wall of `width` x `height` with a semicircular opening about the origin. Its lower ends stand on the columns, its top
/// touches a slab, its sides meet the next arches: those faces are never seen and left out.
pub fn arch(material: usize, width: f64, height: f64, detail: Detail) -> Builder {
    let mut builder = Builder::new("arch", material);
    let half = width / 2.0;
    // The angles of the wall's corners are among those of the arch, so that its outline is kept.
    let corner = height.atan2(half);
    let divide = |from: f64, to: f64, count: usize| {
        (0..count).map(move |index| from + (to - from) * index as f64 / count as f64)
    };
    let (side, middle) = (detail.times(4), detail.times(8));
    let angles: Vec<f64> = divide(0.0, corner, side)
        .chain(divide(corner, PI - corner, middle))
        .chain(divide(PI - corner, PI, side))
        .chain([PI])
        .collect();

    let (near, far) = (ARCH_RADIUS, ARCH_RADIUS + MOULDING.x);
    let (wall, front) = (ARCH_HALF_DEPTH, ARCH_HALF_DEPTH + MOULDING.y);
    let moulding = [
        dvec2(far, wall),
        dvec2(far, front),
        dvec2(near, front),
        dvec2(near, -front),
        dvec2(far, -front),
        dvec2(far, -wall),
    ];
    builder.revolve(&refine(&moulding, detail.parts()), &angles, &UPRIGHT);

    let rows = detail.parts();
    let point = |angle: f64, outward: f64| {
        let (sin, cos) = angle.sin_cos();
        let reach = (half / cos.abs()).min(height / sin);
        DVec2::new(cos, sin) * (far + (reach - far) * outward)
    };
    for (z, normal) in [(wall, DVec3::Z), (-wall, DVec3::NEG_Z)] {
        builder.grid(angles.len() - 1, rows, |column, row| {
            let step = row as f64 / rows as f64;
            let outward = if z > 0.0 { 1.0 - step } else { step };
            (point(angles[column], outward).extend(z), normal)
        });
    }
    builder
}

/// Fills the corner between two arcades above the corner column.
pub fn pier(material: usize, height: f64, detail: Detail) -> Builder {
    let mut builder = Builder::new("corner pier", material);
    let cells = [1, detail.cells(height), 1];
    let pier = Cuboid::new([-0.3, 0.0, -0.3], [0.3, height, 0.3]).with_cells(cells);
    builder.sides(&pier, &Side::UPRIGHT, Facing::Outward);
    builder
}

/// A flat strip on a wall behind it, 1 m high.
pub fn pilaster(material: usize, detail: Detail) -> Builder {
    let mut builder = Builder::new("pilaster", material);
    let strip = Cuboid::new([-0.25, 0.0, -SUNK], [0.25, 1.0, 0.12]).with_cells([1, detail.times(4), 1]);
    builder.sides(&strip, &[Side::Left, Side::Right, Side::Front], Facing::Outward);
    builder
}

/// Height of the balustrade's plinth, on which balusters stand.
pub const PLINTH: f64 = 0.1;

/// Between plinth and handrail.
const BALUSTER_HEIGHT: f64 = 0.65;

/// Plinth and handrail of one bay; the ends lie inside the columns.
pub fn rail(material: usize, detail: Detail) -> Builder {
    let mut builder = Builder::new("balustrade", material);
    let cells = [detail.times(4), 1, 1];
    let low = PLINTH + BALUSTER_HEIGHT;
    builder.cuboid(&Cuboid::new([-1.3, -SUNK, -0.1], [1.3, PLINTH, 0.1]).with_cells(cells));
    builder.cuboid(&Cuboid::new([-1.3, low, -0.11], [1.3, low + 0.12, 0.11]).with_cells(cells));
    builder
}

/// A turned post.
pub fn baluster(material: usize, detail: Detail) -> Builder {
    const PROFILE: [DVec2; 9] = [
        dvec2(0.075, 0.0),
        dvec2(0.075, 0.06),
        dvec2(0.04, 0.10),
        dvec2(0.08, 0.22),
        dvec2(0.065, 0.32),
        dvec2(0.035, 0.46),
        dvec2(0.035, 0.54),
        dvec2(0.07, 0.59),
        dvec2(0.07, BALUSTER_HEIGHT),
    ];
    let mut builder = Builder::new("baluster", material);
    builder.revolve(&refine(&PROFILE, detail.parts()), &full_turn(detail.times(8)), &DMat4::IDENTITY);
    builder
}

/// Where a curtain hangs in the frame of its bay: height of the rod and distance in front of the columns.
const ROD: [f64; 2] = [4.92, 0.56];

/// A brass rod along x and its two brackets, whose ends lie inside the gallery slab.
pub fn curtain_rod(material: usize, detail: Detail) -> Builder {
    let mut builder = Builder::new("curtain rod", material);
    let [y, z] = ROD;
    let frame = DMat4::from_translation(DVec3::new(0.0, y, z)) * LEVEL;
    let profile = [dvec2(0.0, -1.2), dvec2(0.025, -1.2), dvec2(0.025, 1.2), dvec2(0.0, 1.2)];
    builder.revolve(&profile, &full_turn(detail.times(10)), &frame);
    for x in [-1.12, 1.12] {
        builder.cuboid(&Cuboid::new([x - 0.02, y - 0.012, 0.38], [x + 0.02, y + 0.012, z]));
    }
    builder
}

/// Cloth in four folds that deepen downwards; `phase` in radians tells one curtain from another.
pub fn curtain(name: &str, material: usize, phase: f64, detail: Detail) -> Builder {
    const WIDTH: f64 = 2.0;
    const DROP: f64 = 3.6;
    let [top, front] = ROD;
    let mut builder = Builder::new(name, material);
    builder.surface(detail.times(28), detail.times(11), |s, t| {
        let fallen = 1.0 - t;
        let fold = (TAU * 4.0 * s + phase + 1.5 * fallen).sin();
        let x = (s - 0.5) * WIDTH * (1.0 - 0.08 * fallen);
        DVec3::new(x, top - DROP * fallen, front + (0.02 + 0.06 * fallen) * fold)
    });
    builder
}

/// A basin with a bowl on a stem, on the origin.
pub fn fountain(material: usize, detail: Detail) -> Builder {
    const PROFILE: [DVec2; 13] = [
        dvec2(1.50, -SUNK),
        dvec2(1.50, 0.50),
        dvec2(1.42, 0.55),
        dvec2(1.30, 0.55),
        dvec2(1.25, 0.50),
        dvec2(1.25, 0.12),
        dvec2(0.30, 0.12),
        dvec2(0.16, 0.25),
        dvec2(0.12, 0.90),
        dvec2(0.60, 1.12),
        dvec2(0.60, 1.17),
        dvec2(0.54, 1.17),
        dvec2(0.0, 1.02),
    ];
    let mut builder = Builder::new("fountain", material);
    builder.revolve(&refine(&PROFILE, detail.parts()), &full_turn(detail.times(24)), &DMat4::IDENTITY);
    builder
}
