//! Spot lights are culled by their cones: lists against their twins and the oracle, pictures against forward, and what cones leave out.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::Row;
use super::clusters::rows_of;
use super::lists::{differing, radiance, verdict};
use crate::error::Result;
use crate::math::random::Random;
use crate::plan::{AssignChoice, DepthBounds, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::{LightKind, Scene, builtin, scatter};

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (150, 85);

fn request(technique: Technique) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, ..crate::checks::forward() }
}

/// Scattered lights, most of them spots of every direction, from needles to more than half of space.
fn spots(name: &str, count: usize) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), count, 7);
    let mut random = Random::new(5);
    for (index, light) in scene.lights.iter_mut().enumerate() {
        let up = random.range(-1.0, 1.0);
        let (sine, cosine) = random.range(0.0, TAU).sin_cos();
        let across = (1.0 - up * up).max(0.0).sqrt();
        light.direction = DVec3::new(across * cosine, up, across * sine).normalize();
        let outer = match index % 8 {
            0 => continue,
            1 => random.range(1e-3, 0.05),
            2 => random.range(FRAC_PI_2 - 0.01, FRAC_PI_2),
            3 => random.range(FRAC_PI_2, PI),
            _ => random.range(0.1, 1.0),
        };
        light.kind = LightKind::Spot { inner: (outer * random.unit_f64()) as f32, outer: outer as f32 };
    }
    Ok(scene)
}

/// Lists of tiles and clusters.
pub fn spot_lists(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in ["atrium", "terrain"] {
        let scene = spots(name, 800)?;
        let mut spheres = scene.clone();
        spheres.lights.iter_mut().for_each(|light| light.kind = LightKind::Point);
        let forward = radiance(renderer, &scene, &request(Technique::Forward))?;
        for bounds in DepthBounds::ALL {
            let asked = Request { depth_bounds: Some(bounds), ..request(Technique::TiledForward) };
            let (found, wide) = (verdict(renderer, &scene, &asked)?, verdict(renderer, &spheres, &asked)?);
            // Measured: 0.91 where tiles are as long as the view, 0.63 to 0.75 where depths are known.
            let most = if bounds == DepthBounds::Off { 0.95 } else { 0.8 };
            let bounds = bounds.name();
            rows.push(Row::none(format!("spot lists = twin, {name}, {bounds}"), found.wrong, "buffers that differ"));
            rows.push(Row::none(format!("spot lists miss nothing, {name}, {bounds}"), found.missed, "pairs"));
            let share = found.pairs as f64 / wide.pairs.max(1) as f64;
            rows.push(Row::at_most(format!("pairs by cones over those by spheres, {name}, {bounds}"), share, most));
        }
        let tiled = radiance(renderer, &scene, &request(Technique::TiledForward))?;
        let row = format!("tiled-forward = forward, spots, {name}");
        rows.push(Row::none(row, differing(&forward, &tiled), "differing pixels"));
        for assign in [AssignChoice::Tiles, AssignChoice::Tree] {
            let asked = Request { assign, ..request(Technique::ClusteredForward) };
            let clustered = radiance(renderer, &scene, &asked)?;
            let row = format!("clustered-forward = forward, spots, {name}, by {}", assign.name());
            rows.push(Row::none(row, differing(&forward, &clustered), "differing pixels"));
            rows.extend(rows_of(renderer, &format!("spots, {name}, by {}", assign.name()), &scene, &asked)?);
        }
    }
    Ok(rows)
}
