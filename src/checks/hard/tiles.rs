//! Tiles and their depth bounds (T1 to T11): pictures of the size of a pixel, flat tiles, gaps, sky, positions off their stored depth.

use glam::{DMat4, DVec3};

use super::fixtures::{looking, point, scene, wall};
use crate::checks::Row;
use crate::checks::lists::{radiance, verdict};
use crate::error::{Error, Result};
use crate::math::cull;
use crate::passes;
use crate::plan::{CullTest, DepthBounds, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::{Camera, Instance, Light, Projection, Scene, builtin, scatter};

fn tiled() -> Request {
    Request { width: 96, height: 64, technique: Technique::TiledForward, ..crate::checks::forward() }
}

fn lamp(position: [f64; 3], range: f32) -> Light {
    Light { range: Some(range), ..point(DVec3::from_array(position), 5.0) }
}

/// Pixels in which tiled forward differs from forward, and pairs that its lists miss or that differ from the twin's.
fn wrong(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<usize> {
    let forward = radiance(renderer, scene, &Request { technique: Technique::Forward, ..request.clone() })?;
    let tiled = radiance(renderer, scene, request)?;
    let pixels = forward.chunks(4).zip(tiled.chunks(4)).filter(|(a, b)| a != b).count();
    let found = verdict(renderer, scene, request)?;
    Ok(pixels + found.wrong + found.missed)
}

/// T2, T4, T6, T9: whatever is in a tile, nothing is missed and nothing changes.
pub fn tiles(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut row = |name: &str, scene: &Scene, request: &Request| -> Result<()> {
        rows.push(Row::none(name, wrong(renderer, scene, request)?, "pixels, buffers or pairs wrong"));
        Ok(())
    };
    let mut atrium = builtin::load("atrium")?;
    atrium.lights = scatter::point_lights(&atrium.bounds(), 300, 5);
    for (width, height) in [(1, 1), (15, 17), (97, 1), (1, 97), (129, 65)] {
        row(&format!("T6 {width}x{height}"), &atrium, &Request { width, height, ..tiled() })?;
    }
    let lights = || vec![lamp([0.0, 0.0, 0.0], 1.0), lamp([0.5, 0.2, 0.5], 0.6), lamp([-1.0, 0.0, -0.9], 1.0)];
    let flat = scene(wall(9.0), lights(), looking([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], 60.0));
    row("T2 flat tiles", &flat, &tiled())?;
    let sky = scene(wall(9.0), lights(), looking([0.0, 0.0, 3.0], [0.0, 0.0, 9.0], 60.0));
    row("T4 nothing but sky", &sky, &tiled())?;
    let mut far = scene(wall(0.02), lights(), looking([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], 60.0));
    row("T4 a pixel or two of geometry", &far, &tiled())?;
    far.instances = vec![
        Instance { mesh: 0, object_to_world: DMat4::from_scale(DVec3::new(-70.0, 40.0, 1.0)) },
        Instance {
            mesh: 0,
            object_to_world: DMat4::from_translation(DVec3::Z) * DMat4::from_scale(DVec3::new(9.0, -3.0, 2.0)),
        },
    ];
    row("T9 mirrored and scaled nodes", &far, &tiled())?;
    for (name, xmag, ymag) in [("T9 mirrored camera", -4.0, 3.0), ("T9 camera upside down", 4.0, -3.0)] {
        let projection = Projection::Orthographic { xmag, ymag, znear: -1.0, zfar: 9.0 };
        let scene = Scene { cameras: vec![Camera { projection, ..flat.cameras[0].clone() }], ..flat.clone() };
        row(name, &scene, &tiled())?;
    }
    Ok(rows)
}

/// T5: a bar over a far wall, a light in the gap. The mask leaves the light out, the bounds alone do not, the picture is the same.
pub fn gap(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut scene =
        scene(wall(1.0), vec![lamp([0.0, 0.0, -5.0], 1.5)], looking([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], 40.0));
    let bar = |y: f64| DMat4::from_translation(DVec3::new(0.0, y, 0.0)) * DMat4::from_scale(DVec3::new(4.0, 0.02, 1.0));
    let far = DMat4::from_translation(DVec3::new(0.0, 0.0, -12.0)) * DMat4::from_scale(DVec3::splat(20.0));
    let bars = (-12..=12).map(|i| bar(f64::from(i) * 0.15));
    scene.instances = bars.chain([far]).map(|object_to_world| Instance { mesh: 0, object_to_world }).collect();
    let request = |bounds| Request { depth_bounds: Some(bounds), cull: CullTest::Frustum, ..tiled() };
    let listed = |bounds| -> Result<usize> { Ok(verdict(renderer, &scene, &request(bounds))?.pairs) };
    let (mask, bounds) = (listed(DepthBounds::Mask)?, listed(DepthBounds::MinMax)?);
    Ok(vec![
        Row::none("T5 light in the gap, in lists with the mask", mask, "pairs"),
        Row { name: "T5 the same without".into(), passed: bounds > 0, detail: format!("{bounds} pairs, more than 0") },
        Row::none(
            "T5 picture",
            wrong(renderer, &scene, &request(DepthBounds::Mask))?,
            "pixels, buffers or pairs wrong",
        ),
    ])
}

/// T11: the depth of a shaded position lies within what its stored depth says, on triangles from the eye to the horizon.
pub fn depths(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let sub_pixel_bits = renderer.device().facts.limits.sub_pixel_precision_bits;
    for (name, mut scene) in depth_scenes(sub_pixel_bits)? {
        // Tiles are there for lights.
        scene.lights.push(point(DVec3::ZERO, 1.0));
        let request = Request { width: 160, height: 90, ..tiled() };
        let plan = Plan::new(&scene, &request, &renderer.limits())?;
        let mut prepared = renderer.prepare_frame(&scene, &plan, passes::surface_frame(&plan))?;
        prepared.draw(1)?;
        let (picture, _) = prepared.finish()?;
        let (depth, surfaces) = (picture.layer("depth").unwrap_or(&[]), picture.rgba("position_roughness"));
        let (Some(surfaces), Some(tiles)) = (surfaces, &plan.tiles) else {
            return Err(Error::new("the frame has no surfaces"));
        };
        let grid = &tiles.grid;
        let mut outside = 0f64;
        for (index, (&stored, surface)) in depth.iter().zip(surfaces).enumerate().filter(|(_, (d, _))| **d > 0.0) {
            let [x, y, z, _] = *surface;
            let [near, far] = cull::distance_range(grid, stored);
            let tile = [index as u32 % grid.width / tiles.tile, index as u32 / grid.width / tiles.tile];
            let edge = |i: u32| tiles.edges[i as usize][0];
            let [left, right] = cull::edge_interval(grid, edge(tile[0]), edge(tile[0] + 1), near, far);
            let row = grid.columns + 1 + tile[1];
            let [bottom, top] = cull::edge_interval(grid, edge(row), edge(row + 1), near, far);
            let off = [
                cull::interval_distance(left, right, x),
                cull::interval_distance(bottom, top, y),
                cull::interval_distance(near, far, -z),
            ];
            let far_away = if plan.view.lens.is_perspective() { -f64::from(z) } else { 1.0 };
            let bound = tiles.position_slack + tiles.snap_slack * far_away;
            outside = outside.max(DVec3::from_array(off.map(f64::from)).length() / bound);
        }
        rows.push(Row::at_most(format!("T11 way out of the tile over its bound, {name}"), outside, 1.0));
    }
    Ok(rows)
}

/// Rasterisers that snap vertices to 1/16 pixel lose floors that are 500 times as wide as the eye is high (docs/ACCURACY.md).
fn depth_scenes(sub_pixel_bits: u32) -> Result<Vec<(String, Scene)>> {
    let mut scenes = Vec::new();
    for name in ["atrium", "terrain", "corridor"] {
        scenes.push((name.to_string(), builtin::load(name)?));
    }
    let floors: &[(f64, f64)] =
        &[(10.0, 0.2), (10.0, 1.7), (100.0, 1.7), (1e3, 0.2), (1e3, 1.7), (1e5, 0.2), (1e5, 1.7)];
    let drawn = if sub_pixel_bits < 8 { &floors[..3] } else { floors };
    for &(half, height) in drawn {
        let mut floor = scene(wall(half), vec![lamp([0.0, 0.0, 1.0], 2.0)], looking([0.0; 3], [1.0, 0.0, 0.0], 60.0));
        let eye = DVec3::new(0.1, -0.2, height);
        // On the floor's own axes: the eye looks along it, a little down.
        floor.cameras = vec![Camera::looking(eye, eye + DVec3::new(1.0, 0.3, -0.05), 1.0)];
        scenes.push((format!("floor of {half:e} m from {height} m"), floor.clone()));
        let Projection::Perspective { yfov, aspect, znear, .. } = floor.cameras[0].projection else { continue };
        floor.cameras[0].projection = Projection::Perspective { yfov, aspect, znear, zfar: Some(50.0) };
        scenes.push((format!("floor of {half:e} m from {height} m, far plane at 50 m"), floor));
    }
    Ok(scenes)
}
