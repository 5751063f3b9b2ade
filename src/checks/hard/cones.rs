//! L1: spot cones from none to all round, on a wall.
//!
//! The factor is `t^2`, `t = (cos(angle) - cos(outer)) * slope` clamped to 0..1, and `slope` is 1000 where inner = outer. What f32
//! may do to `t`, with u = 2^-24 and the precisions that Vulkan demands (appendix "Precision and Operation of SPIR-V Instructions":
//! 2.5 ulp a division, 2 ulp an inverse square root, of which a square root is made):
//! - the way to the light is off by at most 19 u in length and 3 u in each component, the axis by 1 u in each; so the cross product
//!   of the two is off by less than 9 u, and `1 - cos = |cross|^2 / (1 + cos)` by 18 u tan(angle / 2);
//! - the length's error, the division and the sums come to under 60 u of `1 - cos`, which is at most tan(angle / 2);
//! - from 90 degrees on `1 - cos` is taken directly and is off by under 30 u.
//!
//! Together under 96 u tan(min(angle, 90 degrees) / 2), times the slope. Narrow cones keep their digits, hard edges lose three.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat4, DVec3};

use super::fixtures::{UNIT, flat, plan, point, request, scene, spot, wall};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, larger};
use crate::error::Result;
use crate::plan::Request;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::{Light, Scene};

/// Outer angles from the axis.
const DEGREES: [f64; 8] = [0.0, 1e-4, 0.5, 45.0, 89.9, 90.0, 120.0, 180.0];

/// Least span of an edge in the cosine (KHR_lights_punctual).
const LEAST_SPAN: f64 = 0.001;

/// Angles in radians, as a light stores them.
struct Cone {
    inner: f32,
    outer: f32,
}

fn one_minus_cos(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

impl Cone {
    /// `t` before it is clamped, and how far off the device's may be.
    fn edge(&self, angle: f64) -> (f64, f64) {
        let outer = one_minus_cos(f64::from(self.outer));
        let slope = 1.0 / (outer - one_minus_cos(f64::from(self.inner))).max(LEAST_SPAN);
        let error = 96.0 * UNIT * slope * (0.5 * angle.min(FRAC_PI_2)).tan();
        ((outer - one_minus_cos(angle)) * slope, error)
    }

    /// How far the device's factor may be from the exact one: 0 where its `t` is certainly negative.
    fn tolerance(&self, angle: f64) -> f64 {
        let (t, error) = self.edge(angle);
        if t < -error {
            return 0.0;
        }
        if t > 1.0 + error {
            return SHADING_BOUND;
        }
        let t = t.clamp(0.0, 1.0);
        SHADING_BOUND * t * t + 2.0 * t * error + error * error
    }
}

/// Where the light is, and which part of the wall `z = 0` is looked at, from x to x.
struct Place {
    light: DVec3,
    axis: DVec3,
    from: f64,
    to: f64,
}

impl Place {
    /// Narrow cones meet the wall head on. Wide ones run along it, at 1 m, so that it has points behind the light too: the
    /// angle at x is acot(x). The picture shows the edge and half as much again on both sides.
    fn of(cone: &Cone) -> Self {
        let outer = f64::from(cone.outer);
        if outer < 0.1 {
            let reach = if outer > 0.0 { 3.0 * outer.tan() } else { 1e-3 };
            return Self { light: DVec3::Z * 2.0, axis: DVec3::NEG_Z, from: -reach, to: reach };
        }
        let full = (outer.cos() + LEAST_SPAN).min(1.0).acos().min(f64::from(cone.inner)).max(0.25);
        let bright = full.tan().recip();
        let dark = outer.min(3.12).tan().recip().max(2.0 * bright.min(-2.0));
        let margin = 0.5 * (bright - dark);
        Self { light: DVec3::Z, axis: DVec3::X, from: dark - margin, to: bright + margin }
    }

    fn scene(&self, light: Light) -> Scene {
        let (center, half) = (0.5 * (self.from + self.to), 0.5 * (self.to - self.from));
        let camera = flat([center, 0.0, 5.0], [half, 0.25 * half], [1.0, 10.0]);
        let mut scene = scene(wall(4.0 * half), vec![light], camera);
        scene.instances[0].object_to_world = DMat4::from_translation(DVec3::X * center);
        scene
    }
}

/// What a picture of one cone shows.
#[derive(Default)]
struct Found {
    /// Largest error over what is allowed.
    share: f64,
    /// Pixels that are negative, not finite, or not on the wall.
    wrong: usize,
    /// Pixels brighter than one nearer to the axis by more than their errors.
    rises: usize,
    /// The edge is nowhere in the picture, so the rest proves nothing.
    blind: bool,
}

fn measure(renderer: &Renderer, cone: &Cone) -> Result<Found> {
    let place = Place::of(cone);
    let request = Request { height: 16, ..request(Shading::Lambert) };
    let open_scene = place.scene(point(place.light, 1.0));
    let open_plan = plan(renderer, &open_scene, &request)?;
    let open = Shaded::draw(renderer, &open_scene, &open_plan)?;
    let scene = place.scene(spot(place.light, place.axis, cone.inner, cone.outer));
    let plan = plan(renderer, &scene, &request)?;
    let pixels = oracle::draw(renderer, &scene, &plan)?;
    let (open_shader, shader) = (oracle::shader(&open_plan), oracle::shader(&plan));
    // The camera is not turned: the axis is the same in view space.
    let light = plan.view.world_to_view.transform_point3(place.light);
    let mut found = Found { blind: cone.outer > 0.0, ..Found::default() };
    let mut profile = Vec::new();
    for ((surface, pixel), unspotted) in open.surfaces.iter().zip(&pixels).zip(&open.radiance) {
        let Some(surface) = surface else {
            found.wrong += 1;
            continue;
        };
        found.wrong += usize::from(pixel.iter().any(|c| !(c.is_finite() && *c >= 0.0)));
        let way = surface.position - light;
        let angle = way.cross(place.axis).length().atan2(way.dot(place.axis));
        let tolerance = cone.tolerance(angle);
        let t = cone.edge(angle).0;
        found.blind &= !(t > 0.0 && t < 1.0);
        let (full, exact) = (open_shader.radiance(surface), shader.radiance(surface));
        let share = |i: usize| {
            let off = (f64::from(pixel[i]) - exact[i]).abs();
            if off == 0.0 { 0.0 } else { off / (full[i] * tolerance) }
        };
        found.share = (0..3).map(share).fold(found.share, larger);
        profile.push((angle, f64::from(pixel[0]) / f64::from(unspotted[0]), tolerance));
    }
    profile.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lowest = f64::INFINITY;
    for (_, factor, tolerance) in profile {
        found.rises += usize::from(factor - tolerance > lowest);
        lowest = lowest.min(factor + tolerance);
    }
    Ok(found)
}

/// Cones of every angle, with the softest and the hardest edge.
pub fn spot_cones(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let (mut wrong, mut rises, mut blind) = (0, 0, 0);
    for degrees in DEGREES {
        let outer = degrees.to_radians() as f32;
        let mut share = 0.0;
        for inner in [0.0, outer] {
            let found = measure(renderer, &Cone { inner, outer })?;
            share = larger(share, found.share);
            wrong += found.wrong;
            rises += found.rises;
            blind += usize::from(found.blind);
        }
        rows.push(Row::at_most(format!("L1 cone of {degrees} degrees, error over bound"), share, 1.0));
    }
    rows.push(Row::none("L1 cones negative or not finite", wrong, "pixels"));
    rows.push(Row::none("L1 cones brighter away from the axis", rises, "pixels"));
    rows.push(Row::none("L1 cones whose edge is not in the picture", blind, "cones"));
    Ok(rows)
}
