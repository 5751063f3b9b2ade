//! Blended surfaces: every technique against forward, whatever its lists know of depths (HARD-CASES.md, row T8), the bounds of their
//! tiles against the twin, and the mixed picture against rays.

use glam::{DMat4, DVec3};

use super::Row;
use super::lists::{differing, radiance_of};
use crate::error::{Error, Result};
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::{AssignChoice, DepthBounds, Limits, Plan, Request, Technique, TransparentBounds, TransparentSort};
use crate::reference::depth_reduce;
use crate::renderer::Renderer;
use crate::scene::{AlphaMode, Instance, Material, Mesh, Scene, builtin, scatter};

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (150, 85);

fn request(technique: Technique) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, ..crate::checks::forward() }
}

/// A pane of 2 m, blended, seen from both sides.
fn pane(alpha: f32) -> (Mesh, Material) {
    let mesh = Mesh {
        name: "pane".into(),
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    };
    let material = Material {
        name: "pane".into(),
        base_color: [0.5, 0.8, 0.9, alpha],
        metallic: 0.0,
        roughness: 0.3,
        alpha: AlphaMode::Blend,
        double_sided: true,
        ..Material::default()
    };
    (mesh, material)
}

/// The cornell box, lights scattered in it, with panes at these places.
fn with_panes(places: &[DMat4], lights: usize) -> Result<Scene> {
    let mut scene = builtin::load("cornell")?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
    let (mut mesh, material) = pane(0.4);
    mesh.material = scene.materials.len();
    scene.materials.push(material);
    scene.meshes.push(mesh);
    let mesh = scene.meshes.len() - 1;
    scene.instances.extend(places.iter().map(|&object_to_world| Instance { mesh, object_to_world }));
    Ok(scene)
}

fn at(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// Glass in every relation to what is opaque.
fn cases() -> Result<Vec<(&'static str, Scene)>> {
    let turned = DMat4::from_rotation_y(0.7);
    let mut sky = builtin::load("glass:layers=3")?;
    sky.lights = scatter::point_lights(&sky.bounds(), 64, 5);
    let mut alone = with_panes(&[at(0.3, 2.0, 3.0), at(-0.4, 2.4, 1.0)], 48)?;
    let glass = alone.meshes.len() - 1;
    alone.instances.retain(|instance| instance.mesh == glass);
    Ok(vec![
        ("glass in front of opaque", with_panes(&[at(0.0, 2.0, 4.0)], 64)?),
        ("glass behind opaque", with_panes(&[at(0.0, 2.0, -4.0), at(0.9, 0.8, 0.2)], 64)?),
        ("glass through opaque", with_panes(&[at(-0.9, 1.5, -0.75) * turned, at(0.9, 0.9, 1.0) * turned], 64)?),
        ("glass before sky", sky),
        ("nothing but glass", alone),
    ])
}

const FORWARD_ONES: [Technique; 2] = [Technique::TiledForward, Technique::ClusteredForward];
const DEFERRED_ONES: [Technique; 3] = [Technique::Deferred, Technique::TiledDeferred, Technique::ClusteredDeferred];

fn radiance(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Vec<u32>> {
    radiance_of(renderer, scene, &Plan::new(scene, request, &renderer.limits())?)
}

/// Requests that differ in what lists of blended surfaces know.
fn variants() -> Vec<(String, Request)> {
    let mut variants = Vec::new();
    for technique in FORWARD_ONES {
        for bounds in TransparentBounds::ALL {
            if technique.clusters() && bounds == TransparentBounds::Merged {
                continue;
            }
            let request = Request { transparent_bounds: Some(bounds), ..request(technique) };
            variants.push((format!("{} {}", technique.name(), bounds.name()), request.clone()));
            if bounds != TransparentBounds::None && !technique.clusters() {
                let minmax = Request { depth_bounds: Some(DepthBounds::MinMax), tile: 32, ..request.clone() };
                variants.push((format!("{} {} minmax", technique.name(), bounds.name()), minmax));
                let group = Request { group_a_tile: Some(true), ..request };
                variants.push((format!("{} {} by groups", technique.name(), bounds.name()), group));
            }
        }
        let without = Request { prepass: false, ..request(technique) };
        variants.push((format!("{} no pre-pass", technique.name()), without));
    }
    let tree = Request { assign: AssignChoice::Tree, ..request(Technique::ClusteredForward) };
    variants.push(("clustered-forward by the light hierarchy".into(), tree));
    variants
}

/// Forward techniques draw the same bits, deferred ones the same as each other.
pub fn transparency(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, scene) in cases()? {
        let whole = radiance(renderer, &scene, &request(Technique::Forward))?;
        for technique in FORWARD_ONES {
            let found = radiance(renderer, &scene, &request(technique))?;
            let row = format!("{} = forward, {name}", technique.name());
            rows.push(Row::none(row, differing(&whole, &found), "differing pixels"));
        }
        let first = radiance(renderer, &scene, &request(DEFERRED_ONES[0]))?;
        for technique in &DEFERRED_ONES[1..] {
            let found = radiance(renderer, &scene, &request(*technique))?;
            let row = format!("{} = deferred, {name}", technique.name());
            rows.push(Row::none(row, differing(&first, &found), "differing pixels"));
        }
    }
    let scene = &cases()?[2].1;
    for sort in TransparentSort::ALL {
        let forward = Request { transparent_sort: sort, ..request(Technique::Forward) };
        let whole = radiance(renderer, scene, &forward)?;
        for (name, request) in variants() {
            let found = radiance(renderer, scene, &Request { transparent_sort: sort, ..request })?;
            let row = format!("{name} = forward, by {}", sort.name());
            rows.push(Row::none(row, differing(&whole, &found), "differing pixels"));
        }
    }
    Ok(rows)
}

/// What a frame of blended bounds leaves.
fn bounds_of(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Option<Picture>> {
    let Some(frame) = passes::transparent_bounds_frame(plan) else { return Ok(None) };
    let mut prepared = renderer.prepare_frame(scene, plan, frame)?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    match violations.first() {
        Some(violation) => Err(Error::new(format!("the checker found {violation}"))),
        None => Ok(Some(picture)),
    }
}

/// Bounds of blended surfaces equal the twin's over the depths read back, and hold nothing in tiles without any.
pub fn transparent_bounds(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, scene) in cases()?.into_iter().take(4) {
        for bounds in [TransparentBounds::Own, TransparentBounds::Merged] {
            for depth_bounds in [DepthBounds::MinMax, DepthBounds::Mask] {
                let asked = Request {
                    transparent_bounds: Some(bounds),
                    depth_bounds: Some(depth_bounds),
                    ..request(Technique::TiledForward)
                };
                let plan = Plan::new(&scene, &asked, &renderer.limits())?;
                let Some(tiles) = &plan.tiles else { continue };
                let Some(picture) = bounds_of(renderer, &scene, &plan)? else { continue };
                let layer = |name: &str| picture.layer(name).unwrap_or(&[]);
                let slots = (depth_bounds == DepthBounds::Mask).then_some(tiles.slots);
                let merged = bounds == TransparentBounds::Merged;
                let depths = [layer("transparent_depth"), layer("depth")];
                let twin = depth_reduce::run_blended(&tiles.grid, tiles.tile, slots, depths, merged);
                let stored: Vec<u32> = layer("tile_bounds").iter().map(|word| word.to_bits()).collect();
                let wanted: Vec<u32> = twin.iter().flat_map(|bounds| bounds.words()).collect();
                let wrong = if stored.len() == wanted.len() {
                    stored.iter().zip(&wanted).filter(|(a, b)| a != b).count()
                } else {
                    usize::MAX
                };
                let row = format!("{} {} bounds = twin, {name}", bounds.name(), depth_bounds.name());
                rows.push(Row::none(row, wrong, "words that differ"));
            }
        }
    }
    Ok(rows)
}

/// Most of a 16-bit float's ulp that a layer of `SHARED` surfaces may be off by, relatively: each mixing rounds once.
const LAYER_ERROR: f64 = 8.0 / 2048.0;

/// Without blending of 32-bit floats the picture comes by way of a 16-bit layer, and is the same but for its rounding.
pub fn transparent_layer(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = &cases()?[0].1;
    let plan = |limits: &Limits| Plan::new(scene, &request(Technique::TiledForward), limits);
    let whole = radiance_of(renderer, scene, &plan(&renderer.limits())?)?;
    let layered = plan(&Limits { float_blend: false, ..renderer.limits() })?;
    let found = radiance_of(renderer, scene, &layered)?;
    let value = |bits: &u32| f64::from(f32::from_bits(*bits));
    let mean = whole.iter().map(value).sum::<f64>() / whole.len() as f64;
    let error = |(a, b): (&u32, &u32)| (value(a) - value(b)).abs() / value(a).max(1e-3 * mean);
    let most = whole.iter().zip(&found).map(error).fold(0.0, f64::max);
    let changed = differing(&whole, &found);
    Ok(vec![
        Row::at_most("16-bit layer against 32-bit blending", most, LAYER_ERROR),
        Row::none("pixels without glass change", usize::from(changed == whole.len() / 4), "whole pictures"),
    ])
}
