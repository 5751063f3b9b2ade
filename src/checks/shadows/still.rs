//! Edges of shadows stand still while the camera moves by less than a texel.

use glam::{DMat4, DVec3};

use crate::checks::Row;
use crate::checks::lists::radiance_of;
use crate::error::{Error, Result};
use crate::plan::{Plan, Request, Shadows, Technique};
use crate::renderer::Renderer;
use crate::scene::view::View;
use crate::scene::{Camera, Projection, Scene, builtin};

use super::{request, value};

/// Metres that the camera goes on: far less than a texel, and less or more than one of the finest map.
const STEPS: [f64; 4] = [1e-4, 0.003, 0.011, 0.31];

fn shadows(plan: &Plan) -> Result<&Shadows> {
    plan.shadows.as_ref().ok_or_else(|| Error::new("the plan has no shadows"))
}

/// How far from whole texels the maps of two plans lie apart, at most, in texels; infinite where their sizes differ.
fn off_grid((before, first): (&Shadows, &View), (after, second): (&Shadows, &View)) -> f64 {
    let mut most: f64 = 0.0;
    for (a, b) in before.maps.iter().zip(&after.maps) {
        if (a.texel_metres - b.texel_metres).abs() > 1e-12 * a.texel_metres {
            return f64::INFINITY;
        }
        let place = |map: &DMat4, view: &View, size: u32, at: DVec3| {
            let clip = *map * view.world_to_view.transform_point3(at).extend(1.0);
            (clip.truncate() / clip.w).truncate() * f64::from(size) * 0.5
        };
        for at in [DVec3::ZERO, DVec3::new(3.0, 1.0, -2.0)] {
            let apart = place(&a.view_to_map, first, before.size, at) - place(&b.view_to_map, second, after.size, at);
            most = most.max((apart - apart.round()).abs().max_element());
        }
    }
    if before.maps.len() == after.maps.len() { most } else { f64::INFINITY }
}

/// The terrain from above through a lens of parallel rays: what is a pixel on in one picture is in the next pixel of another.
fn from_above(scene: &Scene, right: f64) -> Scene {
    let projection = Projection::Orthographic { xmag: 15.0, ymag: 8.5, znear: 0.0, zfar: 200.0 };
    let at = scene.bounds().center();
    let place = DVec3::new(at.x + right, scene.bounds().max.y + 1.0, at.z);
    let turned = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let camera_to_world = DMat4::from_translation(place) * turned;
    Scene { cameras: vec![Camera { name: "above".into(), camera_to_world, projection }], ..scene.clone() }
}

/// Grids of texels stand still in the world, and so do the edges of shadows in pictures.
pub fn shadows_still(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("terrain")?;
    let asked = request(Technique::Forward);
    let mut rows = Vec::new();
    let own = scene.cameras[0].projection;
    let flat = Projection::Orthographic { xmag: 15.0, ymag: 8.5, znear: 0.0, zfar: 2000.0 };
    let deep = Projection::Perspective { yfov: 0.9, aspect: None, znear: 0.1, zfar: Some(90.0) };
    for (name, projection) in [("its own lens", own), ("parallel rays", flat), ("a far plane", deep)] {
        let mut first = scene.clone();
        first.cameras[0].projection = projection;
        let before = Plan::new(&first, &asked, &renderer.limits())?;
        let mut most: f64 = 0.0;
        for (step, turn) in STEPS.into_iter().flat_map(|step| [(step, 0.0), (step, 0.2)]) {
            let mut moved = first.clone();
            let motion = DMat4::from_translation(DVec3::new(step, 0.3 * step, -0.7 * step))
                * DMat4::from_rotation_y(turn * step);
            moved.cameras[0].camera_to_world = motion * moved.cameras[0].camera_to_world;
            let plan = Plan::new(&moved, &asked, &renderer.limits())?;
            most = most.max(off_grid((shadows(&before)?, &before.view), (shadows(&plan)?, &plan.view)));
        }
        rows.push(Row::at_most(format!("texels of cascades off their grid, moving camera, {name}"), most, 1e-6));
    }
    // A fifth of a metre a pixel. A rasteriser that snaps to sixteenths of it moves what is seen by a tenth of a texel.
    // Measured: 0 and 2.7e-3 of the pixels (SwiftShader); 1.1e-2 and more on either driver where maps do not keep to the grid.
    let asked = Request { shadow_size: 256, ..asked };
    let picture = |right: f64, shadows: u32| {
        let scene = from_above(&scene, right);
        let plan = Plan::new(&scene, &Request { shadows: Some(shadows), ..asked.clone() }, &renderer.limits())?;
        radiance_of(renderer, &scene, &plan)
    };
    let (width, step) = (asked.width as usize, 30.0 / f64::from(asked.width));
    let [still, open] = [picture(0.0, 1)?, picture(0.0, 0)?];
    for pixels in [1usize, 3] {
        let right = step * pixels as f64;
        let [moved, moved_open] = [picture(right, 1)?, picture(right, 0)?];
        // Where both pictures show one surface, which share of the light they show of it.
        let shares = (0..still.len() / 4).filter(|pixel| pixel % width >= pixels).filter_map(|pixel| {
            let (a, b) = (pixel * 4 + 1, (pixel - pixels) * 4 + 1);
            let (full, full_moved) = (value(open[a]), value(moved_open[b]));
            let same = full > 0.0 && (full - full_moved).abs() <= 1e-3 * full;
            same.then(|| (value(still[a]) / full - value(moved[b]) / full_moved).abs())
        });
        let shares: Vec<f64> = shares.collect();
        let crawling = shares.iter().filter(|apart| **apart > 0.15).count();
        let share = crawling as f64 / shares.len().max(1) as f64;
        rows.push(Row::at_most(format!("pixels that change as the camera moves by {pixels}"), share, 4e-3));
        let compared = shares.len() * 2 < still.len() / 4;
        rows.push(Row::none(format!("pictures compared, moved by {pixels}"), usize::from(compared), "too small"));
    }
    Ok(rows)
}
