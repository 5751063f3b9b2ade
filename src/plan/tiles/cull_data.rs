//! Lights in the form that culling reads: where they are in view space, how far they reach, the tiles of their rectangle, and their cones.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::{SPACE_SLACK, Tiles, padded_radius, up};
use crate::plan::projection::{self, PixelRect};
use crate::plan::request::CullTest;
use crate::scene::LightKind;
use crate::scene::lighting::ResolvedLight;
use crate::scene::view::View;
use crate::shared::{self, CONE_TEXELS, CULL_TEXELS};

impl Tiles {
    /// What the device culls by: lights, and behind them their cones.
    pub fn cull_data(&self) -> Vec<[f32; 4]> {
        self.lights.iter().chain(&self.cones).copied().collect()
    }

    pub(super) fn cull_texels(
        &self,
        light: &ResolvedLight,
        view: &View,
        extent: f64,
    ) -> [[f32; 4]; CULL_TEXELS as usize] {
        let center = view.world_to_view.transform_point3(light.position);
        let stored = center.as_vec3();
        let far_away = if view.lens.is_perspective() { center.length() + light.range } else { 1.0 };
        let radius = padded_radius(center, light.range, extent) + self.snap_slack * far_away;
        let range = projection::distance_range(center, radius, view);
        let rect = match self.cull {
            CullTest::BoundsTextbook => projection::textbook_rectangle(stored, light.range as f32, view),
            _ => projection::tangent_rectangle(center, radius, view),
        };
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        let tiles = |r: &PixelRect| projection::rectangle_tiles(r, self.tile, columns, rows).map(|t| t as f32);
        let [near, far] = range.unwrap_or([1.0, 0.0]);
        let rect = rect.as_ref().filter(|_| range.is_some()).map_or([1.0, 0.0, 1.0, 0.0], tiles);
        let radius = up(radius);
        [
            [stored.x, stored.y, stored.z, up(f64::from(radius) * f64::from(radius))],
            [near, far.min(shared::FAR_LIMIT), radius, up(facing_slack(center, extent))],
            rect,
        ]
    }
}

/// Radians, and the share of the angle, by which a cone is wider than the light's: what f32 may take from the shader's cosine.
const ANGLE_SLACK: f64 = 1e-5;

/// Axis and half angle of a light's cone. `radius` is that of its sphere, wider than its range by all that positions may be off.
pub(super) fn cone_texels(light: &ResolvedLight, view: &View, radius: f64) -> [[f32; 4]; CONE_TEXELS as usize] {
    let none = [[0.0, 0.0, -1.0, 0.0], [-1.0, 0.0, 0.0, 0.0]];
    let LightKind::Spot { outer, .. } = light.kind else { return none };
    let angle = f64::from(outer) * (1.0 + ANGLE_SLACK) + ANGLE_SLACK;
    let slack = up((radius - light.range).max(0.0));
    if angle >= FRAC_PI_2 || !slack.is_finite() {
        return none;
    }
    let axis = view.world_to_view.transform_vector3(light.direction).normalize().as_vec3();
    [[axis.x, axis.y, axis.z, slack], [angle.cos() as f32, up(angle.sin()), 0.0, 0.0]]
}

/// What rounding may take from the scalar product of a normal and the way from a sample to the light, metres. Both lie within `far_away` of
/// the eye; their difference is off by less than 2^-22 of that (places in f32, and one subtraction), a product of three terms by 2^-21 of
/// the way's length, and an interval's ends by as much: less than 8 * 2^-20 together.
fn facing_slack(center: DVec3, extent: f64) -> f64 {
    ((center.length() + extent) * 8.0 * SPACE_SLACK).min(f64::from(shared::FAR_LIMIT))
}
