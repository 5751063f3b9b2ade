//! L6 and P7: cameras far from the origin, and lenses of every kind.

use glam::{DMat4, DVec3};

use super::fixtures::{flat, looking, plan, point, request, scene, sphere, wall};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, against_rays, picture_bound};
use crate::error::Result;
use crate::plan::Plan;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::view::{Extents, Lens};
use crate::scene::{Camera, Light, Scene};

/// A sphere of 1 m, its light and its camera, all moved by `distance` along three axes. Every number is a multiple of 1/4, so the
/// moved scene is the same scene exactly.
fn moved(distance: f64) -> Scene {
    let offset = DVec3::new(distance, -distance, 0.5 * distance);
    let light = point(DVec3::new(1.75, 1.75, 4.5) + offset, 20.0);
    let mut camera = looking([1.5, 1.25, 3.5], [0.0; 3], 32.0);
    camera.camera_to_world.w_axis += offset.extend(0.0);
    let mut scene = scene(sphere(1.0), vec![light], camera);
    scene.instances[0].object_to_world = DMat4::from_translation(offset);
    scene
}

/// L6: a scene far from the origin is judged by the scene at the origin.
///
/// World to view rounds each coordinate at most eight times at 2^-53 of the distance, 2^-50 of it in all. The light's irradiance,
/// at 4 m and more, changes by at most 3 of the largest for each metre that it moves, and the largest is under twice the mean:
/// 6 sqrt(3) 2^-50 < 1e-14 for each metre of distance.
pub fn far_camera(renderer: &Renderer) -> Result<Vec<Row>> {
    let request = request(Shading::Lambert);
    let near_scene = moved(0.0);
    let near = plan(renderer, &near_scene, &request)?;
    let mut rows = Vec::new();
    for distance in [0.0, 1e5, 1e7] {
        let scene = moved(distance);
        let plan = plan(renderer, &scene, &request)?;
        let shaded = Shaded::draw(renderer, &scene, &plan)?;
        let own = shaded.error(&oracle::shader(&plan));
        let unmoved = shaded.error(&oracle::shader(&near));
        let picture = against_rays(&shaded.radiance, &near_scene, &near)?.0;
        let bound = SHADING_BOUND + 1e-14 * distance;
        rows.push(Row::at_most(format!("L6 {distance:e} m away, shading"), own, SHADING_BOUND));
        rows.push(Row::at_most(format!("L6 {distance:e} m away, unmoved lights"), unmoved, bound));
        rows.push(Row::at_most(format!("L6 {distance:e} m away, unmoved rays"), picture, picture_bound(renderer)));
    }
    Ok(rows)
}

/// Close to the line of sight, so that nearly all that is seen is lit.
fn lamp() -> Light {
    point(DVec3::new(0.25, 0.5, 9.0), 50.0)
}

fn ball(camera: Camera) -> Scene {
    scene(sphere(1.0), vec![lamp()], camera)
}

fn judge(renderer: &Renderer, name: &str, scene: &Scene, plan: &Plan) -> Result<[Row; 2]> {
    let shaded = Shaded::draw(renderer, scene, plan)?;
    let picture = against_rays(&shaded.radiance, scene, plan)?.0;
    Ok([
        Row::at_most(format!("P7 {name}, shading"), shaded.error(&oracle::shader(plan)), SHADING_BOUND),
        Row::at_most(format!("P7 {name}, picture"), picture, picture_bound(renderer)),
    ])
}

/// P7: lenses that cameras have.
fn symmetric(renderer: &Renderer) -> Result<Vec<Row>> {
    let front = [0.0, 0.0, 2.5];
    let mut small = ball(looking([0.0, 0.0, 100.0], [0.0; 3], 1.0));
    small.instances[0].object_to_world = DMat4::from_scale(DVec3::splat(0.7));
    // The light is ten times as far from the wall as the camera: a pixel here spans half a metre.
    let wide =
        scene(wall(60.0), vec![point(DVec3::new(3.0, 2.0, 10.0), 100.0)], looking([0.0, 0.0, 1.0], [0.0; 3], 170.0));
    let cases = [
        ("orthographic, znear 0", ball(flat(front, [1.6, 1.2], [0.0, 10.0]))),
        ("orthographic, znear -3", ball(flat([0.0; 3], [1.6, 1.2], [-3.0, 5.0]))),
        ("orthographic, x mirrored", ball(flat(front, [-1.6, 1.2], [0.0, 10.0]))),
        ("orthographic, y mirrored", ball(flat(front, [1.6, -1.2], [0.0, 10.0]))),
        ("orthographic, both mirrored", ball(flat(front, [-1.6, -1.2], [0.0, 10.0]))),
        ("1 degree", small),
        ("170 degrees", wide),
    ];
    let mut rows = Vec::new();
    for (name, scene) in cases {
        let plan = plan(renderer, &scene, &request(Shading::Lambert))?;
        rows.extend(judge(renderer, name, &scene, &plan)?);
    }
    Ok(rows)
}

/// The extents moved by a part of a pixel, as temporal anti-aliasing does.
fn jittered(e: Extents, [width, height]: [u32; 2]) -> Extents {
    let x = 0.37 * (e.right - e.left) / f64::from(width);
    let y = -0.21 * (e.top - e.bottom) / f64::from(height);
    Extents { left: e.left + x, right: e.right + x, bottom: e.bottom + y, top: e.top + y }
}

/// P7: lenses that no camera of a file has, put into the plan.
fn shifted(renderer: &Renderer) -> Result<Vec<Row>> {
    let request = request(Shading::Lambert);
    let perspective = ball(looking([0.0, 0.0, 4.0], [0.0; 3], 32.0));
    let orthographic = ball(flat([0.0, 0.0, 2.5], [1.6, 1.2], [0.0, 10.0]));
    let size = [request.width, request.height];
    let own = plan(renderer, &perspective, &request)?.view.lens.extents();
    let tangents = Extents { left: -0.35, right: 0.05, bottom: -0.05, top: 0.25 };
    let metres = Extents { left: -0.4, right: 1.2, bottom: -1.1, top: 0.1 };
    let cases = [
        ("perspective, off-centre", &perspective, Lens::Perspective(tangents)),
        ("perspective, jittered", &perspective, Lens::Perspective(jittered(own, size))),
        ("orthographic, off-centre", &orthographic, Lens::Orthographic(metres)),
    ];
    let mut rows = Vec::new();
    for (name, scene, lens) in cases {
        let mut plan = plan(renderer, scene, &request)?;
        plan.view.lens = lens;
        rows.extend(judge(renderer, name, scene, &plan)?);
    }
    Ok(rows)
}

/// P7: every lens draws what its rays see.
pub fn lenses(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = symmetric(renderer)?;
    rows.extend(shifted(renderer)?);
    Ok(rows)
}
