//! L3 and L9: many lights on one pixel, weak beside strong, and radiance up to the end of f32.

use glam::DVec3;

use super::fixtures::{UNIT, looking, plan, point, request, scene, wall};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, larger, shading_error};
use crate::error::Result;
use crate::plan::Request;
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::shading::Shading;
use crate::scene::{Light, Scene, builtin, scatter};

fn lamp(intensity: f32) -> Light {
    point(DVec3::new(0.5, 0.25, 2.0), intensity)
}

fn lit_wall(lights: Vec<Light>) -> Scene {
    scene(wall(4.0), lights, looking([0.25, 0.5, 3.0], [0.0; 3], 45.0))
}

/// L3: a plain sum of n terms of one sign is off by at most n u of itself, u = 2^-24 (Higham, "Accuracy and Stability of Numerical
/// Algorithms", 2nd ed., section 4.2), on top of the terms' own errors.
pub fn many_lights(renderer: &Renderer) -> Result<Vec<Row>> {
    let faint = vec![lamp(1e-3); 4095];
    let cases = [
        ("4,096 equal lights", vec![lamp(1.0); 4096]),
        ("1e-3 beside 1e6", vec![lamp(1e-3), lamp(1e6)]),
        ("1e6 before 4,095 of 1e-3", [vec![lamp(1e6)], faint.clone()].concat()),
        ("1e6 after 4,095 of 1e-3", [faint, vec![lamp(1e6)]].concat()),
    ];
    let request = Request { width: 32, height: 24, ..request(Shading::Gltf) };
    let mut rows = Vec::new();
    for (name, lights) in cases {
        let bound = SHADING_BOUND + lights.len() as f64 * UNIT;
        let error = shading_error(renderer, &lit_wall(lights), &request)?;
        rows.push(Row::at_most(format!("L3 {name}"), error, bound));
    }
    Ok(rows)
}

/// L9: error of a picture whose radiance passes f32: the largest finite number stands for all that is larger, and a black channel
/// stays black.
fn overflowing(renderer: &Renderer) -> Result<(f64, usize)> {
    let near = point(DVec3::new(0.0, 0.0, 0.5), 3e38);
    let mut scene = lit_wall(vec![near; 8]);
    scene.materials[0].base_color = [0.0, 0.5, 1.0, 1.0];
    let plan = plan(renderer, &scene, &request(Shading::Lambert))?;
    let shaded = Shaded::draw(renderer, &scene, &plan)?;
    let shader = oracle::shader(&plan);
    let mut error = if shaded.surfaces.iter().any(Option::is_some) { 0.0 } else { f64::INFINITY };
    for (pixel, surface) in shaded.radiance.iter().zip(&shaded.surfaces) {
        let Some(surface) = surface else { continue };
        let exact = shader.radiance(surface).min(DVec3::splat(f64::from(f32::MAX)));
        let off = |i: usize| (f64::from(pixel[i]) - exact[i]).abs() / exact[i].max(1.0);
        error = (0..3).map(off).fold(error, larger);
    }
    Ok((error, shaded.not_finite()))
}

/// L9: intensities over 44 orders of magnitude, and sums that pass f32.
pub fn radiance_range(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for intensity in [1e-6, 1.0, 1e6, 1e30, 1e38] {
        let error = shading_error(renderer, &lit_wall(vec![lamp(intensity)]), &request(Shading::Gltf))?;
        rows.push(Row::at_most(format!("L9 {intensity:e} cd, shading against f64"), error, SHADING_BOUND));
    }
    let (error, not_finite) = overflowing(renderer)?;
    rows.push(Row::at_most("L9 radiance past f32 is clamped once", error, SHADING_BOUND + 8.0 * UNIT));
    rows.push(Row::none("L9 radiance past f32 is finite", not_finite, "pixels that are not"));
    Ok(rows)
}

/// Lights of the longest loops that any known driver carries out (src/plan/lights.rs), of finite range and without.
const LONG_LOOPS: [(u32, RangeRule); 2] = [(31_298, RangeRule::Fixed(100.0)), (65_535, RangeRule::Infinite)];

/// Loops as long as the plan allows: the last light counts as much as the first.
pub fn long_loops(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (count, range) in LONG_LOOPS {
        let mut scene = builtin::load("cornell")?;
        scene.lights = scatter::point_lights(&scene.bounds(), count as usize, 1);
        let rules = LightRules { range, ..LightRules::default() };
        let request = Request { width: 16, height: 9, rules, shading: Shading::Lambert, ..crate::checks::forward() };
        let error = shading_error(renderer, &scene, &request)?;
        rows.push(Row::at_most(format!("loop over {count} lights"), error, SHADING_BOUND + f64::from(count) * UNIT));
    }
    Ok(rows)
}
