//! L2 and L10: where a light ends, on the device.

use glam::DVec3;

use super::fixtures::{UNIT, flat, looking, plan, point, request, scene, wall};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, larger, shading_error};
use crate::error::Result;
use crate::plan::{Plan, Request};
use crate::renderer::Renderer;
use crate::scene::lighting::{Attenuation, LightRules};
use crate::scene::shading::Shading;
use crate::scene::{Light, Scene, builtin, scatter};

/// Ranges in ulp from the receiver's distance.
const STEPS: [i32; 9] = [-64, -8, -2, -1, 0, 1, 2, 8, 64];

/// Lights keep their own range, or the one solved from the cut-off.
fn ranged(shading: Shading) -> Request {
    Request { rules: LightRules::default(), ..request(shading) }
}

/// Pixels of which a bit differs between stepping over lights that are out of range and shading them all.
fn culling_differs(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<usize> {
    let draw = |seek: bool| {
        let mut plan = plan.clone();
        plan.lights.seek = seek;
        oracle::draw(renderer, scene, &plan)
    };
    let (culled, whole) = (draw(true)?, draw(false)?);
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    Ok(culled.iter().zip(&whole).filter(|(a, b)| bits(a) != bits(b)).count())
}

/// The wall lies in the camera's own plane, so its depth is exactly 0 however a driver interpolates, and the light hangs 2 m over
/// it: squared distances are exactly 4 in f32, and one ulp of the range decides.
///
/// `1 / range^2` is rounded up by under 2 u, the square of the ratio by u more: the window, at most 64 ulp wide here, is off by
/// under 6 u, u = 2^-24.
fn exact_edge(renderer: &Renderer) -> Result<Vec<Row>> {
    let request = Request { width: 16, height: 12, ..ranged(Shading::Lambert) };
    let at_range = |steps: i32| {
        let range = f32::from_bits(2f32.to_bits().wrapping_add_signed(steps));
        let light = Light { range: Some(range), ..point(DVec3::Z * 2.0, 1.0) };
        scene(wall(4e-6), vec![light], flat([0.0; 3], [1e-6, 0.75e-6], [-10.0, 10.0]))
    };
    let (mut lit, mut dark, mut differing, mut error) = (0, 0, 0, 0.0);
    for steps in STEPS {
        let scene = at_range(steps);
        let plan = plan(renderer, &scene, &request)?;
        let shaded = Shaded::draw(renderer, &scene, &plan)?;
        differing += culling_differs(renderer, &scene, &plan)?;
        let mut open_plan = plan.clone();
        open_plan.lighting.lights[0].range = f64::INFINITY;
        let (shader, open_shader) = (oracle::shader(&plan), oracle::shader(&open_plan));
        for (pixel, surface) in shaded.radiance.iter().zip(&shaded.surfaces) {
            let Some(surface) = surface else {
                dark += 1;
                continue;
            };
            let (exact, open) = (shader.radiance(surface).x, open_shader.radiance(surface).x);
            lit += usize::from(exact == 0.0 && pixel[..3].iter().any(|c| c.to_bits() != 0));
            dark += usize::from(exact > 0.0 && pixel[..3].iter().any(|c| *c <= 0.0));
            error = larger(error, (f64::from(pixel[0]) - exact).abs() / open);
        }
    }
    Ok(vec![
        Row::none("L2 lit at or beyond the range", lit, "pixels"),
        Row::none("L2 dark within the range", dark, "pixels"),
        Row::at_most("L2 window within 64 ulp of the range", error, 8.0 * UNIT),
        Row::none("L2 culled = unculled at the range", differing, "differing pixels"),
    ])
}

/// A lamp of 0.1 m range seen from 10 km: in view space an ulp is 0.98 mm, and the lamp's place rounds 0.4 of one away from the
/// wall. The picture shows where its light ends.
fn telescope() -> Scene {
    let height = 61.6 / 1024.0;
    let light = Light { range: Some(0.1), ..point(DVec3::Z * height, 1.0) };
    let edge = (0.01 - height * height).sqrt();
    scene(wall(0.2), vec![light], flat([edge, 0.0, 1e4], [0.0016, 0.0012], [9e3, 1.1e4]))
}

/// Light ends where its range does, bit for bit, whether it is culled or not.
pub fn range_edge(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = exact_edge(renderer)?;
    let mut cornell = builtin::load("cornell")?;
    cornell.lights = scatter::point_lights(&cornell.bounds(), 64, 7);
    for (name, scene) in [("64 lights", cornell), ("a lamp 10 km away", telescope())] {
        let plan = plan(renderer, &scene, &ranged(Shading::Gltf))?;
        let differing = culling_differs(renderer, &scene, &plan)?;
        rows.push(Row::none(format!("L2 culled = unculled, {name}"), differing, "differing pixels"));
    }
    Ok(rows)
}

/// L2: a light in the wall and just over it. At height 0 it grazes everything and adds exactly nothing.
pub fn light_on_surface(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut not_finite = 0;
    for height in [0.0, 1e-9, 1e-5] {
        let camera = flat([0.0; 3], [1e-5, 0.75e-5], [-10.0, 10.0]);
        let scene = scene(wall(4e-5), vec![point(DVec3::Z * height, 1.0)], camera);
        for shading in [Shading::Lambert, Shading::Phong, Shading::Gltf] {
            // Odd sizes: the middle pixel's centre is under the light.
            let request = Request { width: 65, height: 49, ..ranged(shading) };
            let plan = plan(renderer, &scene, &request)?;
            let shaded = Shaded::draw(renderer, &scene, &plan)?;
            not_finite += shaded.not_finite();
            if height == 0.0 {
                let lit = shaded.radiance.iter().filter(|p| p[..3].iter().any(|c| c.to_bits() != 0)).count();
                rows.push(Row::none(format!("L2 light in the wall, {}", shading.name()), lit, "lit pixels"));
            } else {
                let name = format!("L2 light {height:e} m over the wall, {}", shading.name());
                rows.push(Row::at_most(name, shaded.error(&oracle::shader(&plan)), SHADING_BOUND));
            }
        }
    }
    rows.push(Row::none("L2 light on the wall is finite", not_finite, "pixels that are not"));
    Ok(rows)
}

/// L10: each form of the distance law, its range solved from the cut-off.
pub fn attenuations(renderer: &Renderer) -> Result<Vec<Row>> {
    let camera = looking([0.5, 0.25, 4.0], [0.0; 3], 45.0);
    let scene = scene(wall(8.0), vec![point(DVec3::new(0.5, 0.5, 1.0), 100.0)], camera);
    let laws = [
        ("quadratic", [0.0, 0.0, 1.0]),
        ("K_q = 0", [1.0, 0.7, 0.0]),
        ("K_q = K_l = 0", [1.0, 0.0, 0.0]),
        ("K_q = 1e-12", [1.0, 1.0, 1e-12]),
        ("all three", [1.0, 0.7, 1.8]),
    ];
    let mut rows = Vec::new();
    for (name, [constant, linear, quadratic]) in laws {
        let attenuation = Attenuation { constant, linear, quadratic };
        let rules = LightRules { attenuation, ..LightRules::default() };
        let request = Request { rules, ..request(Shading::Gltf) };
        let error = shading_error(renderer, &scene, &request)?;
        rows.push(Row::at_most(format!("L10 {name}, shading against f64"), error, SHADING_BOUND));
    }
    Ok(rows)
}
