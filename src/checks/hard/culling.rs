//! Lights whose projection is hard (P1 to P7): beside the eye, round it, behind it, across the near plane, tiny, immense, just outside.

use glam::DVec3;

use super::fixtures::point;
use crate::checks::lists::{differing, radiance, verdict};
use crate::checks::{Row, clusters};
use crate::error::Result;
use crate::math::random::Random;
use crate::plan::{AssignChoice, ClusterBounds, CullTest, DepthBounds, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::view::View;
use crate::scene::{Camera, Light, Projection, Scene, builtin};

/// One light of a kind, in view space: centre and range.
pub(super) type Maker = fn(&mut Random, &View) -> (DVec3, f64);

pub(super) fn log_range(random: &mut Random, low: f64, high: f64) -> f64 {
    random.range(low.ln(), high.ln()).exp()
}

fn sign(random: &mut Random) -> f64 {
    if random.unit_f64() < 0.5 { -1.0 } else { 1.0 }
}

fn direction(random: &mut Random) -> DVec3 {
    let axis = |random: &mut Random| random.range(-1.0, 1.0);
    DVec3::new(axis(random), axis(random), axis(random)).try_normalize().unwrap_or(DVec3::X)
}

/// P1: depth of the centre from 1e-8 to 1e5 of the range, either sign, the centre off to a side.
fn beside(random: &mut Random, _: &View) -> (DVec3, f64) {
    let range = log_range(random, 0.01, 10.0);
    let depth = log_range(random, 1e-8, 1e5) * range * sign(random);
    let aside = direction(random) * range * log_range(random, 0.5, 3.0);
    (DVec3::new(aside.x, aside.y, depth), range)
}

/// P2: crosses or touches the near plane.
fn across_near(random: &mut Random, view: &View) -> (DVec3, f64) {
    let range = log_range(random, 0.001, 5.0);
    let aside = direction(random) * range;
    let touch = [-1.0, 0.0, 1.0, random.range(-1.0, 1.0)][(random.unit_f64() * 4.0) as usize % 4];
    (DVec3::new(aside.x, aside.y, -view.znear + touch * range), range)
}

/// P3: the eye inside the sphere or within an ulp of its surface.
fn round_eye(random: &mut Random, _: &View) -> (DVec3, f64) {
    let range = f64::from(log_range(random, 0.01, 100.0) as f32);
    let off = [0.0, 0.5, 1.0 - 1.2e-7, 1.0, 1.0 + 1.2e-7][(random.unit_f64() * 5.0) as usize % 5];
    (direction(random) * range * off, range)
}

/// P4: behind the eye, reaching in front of it.
fn behind(random: &mut Random, _: &View) -> (DVec3, f64) {
    let range = log_range(random, 0.1, 30.0);
    let aside = direction(random) * range;
    (DVec3::new(aside.x, aside.y, random.range(0.0, 1.0) * range), range)
}

/// P5: a millionth of a metre to a million kilometres.
fn any_size(random: &mut Random, _: &View) -> (DVec3, f64) {
    (direction(random) * log_range(random, 0.1, 1e3), log_range(random, 1e-6, 1e9))
}

/// P6: near the edges of the view, outside and in.
fn at_edges(random: &mut Random, view: &View) -> (DVec3, f64) {
    let e = view.lens.extents();
    let depth = log_range(random, 0.1, 50.0);
    let (x, y) = (random.range(e.left, e.right), random.range(e.bottom, e.top));
    let (x, y) = if random.unit_f64() < 0.5 { (e.right * sign(random), y) } else { (x, e.top * sign(random)) };
    let center =
        if view.lens.is_perspective() { DVec3::new(x * depth, y * depth, -depth) } else { DVec3::new(x, y, -depth) };
    (center * random.range(0.9, 1.1), log_range(random, 0.01, 3.0))
}

pub(super) const MAKERS: [Maker; 6] = [beside, across_near, round_eye, behind, any_size, at_edges];

/// Anywhere that the view may see, of a size that part of it sees.
fn anywhere(random: &mut Random, _: &View) -> (DVec3, f64) {
    let center = DVec3::new(random.range(-12.0, 12.0), random.range(-8.0, 8.0), random.range(-25.0, 3.0));
    (center, log_range(random, 0.05, 4.0))
}

/// Every other light anywhere, the others of every hard kind in turn, placed in the view of `camera`.
fn lights(camera: &Camera, size: (u32, u32), count: usize, seed: u64) -> Result<Vec<Light>> {
    let view = View::new(camera, size.0, size.1)?;
    let mut random = Random::new(seed);
    let light = |index: usize| {
        let maker: Maker = if index.is_multiple_of(2) { anywhere } else { MAKERS[index / 2 % MAKERS.len()] };
        let (center, range) = maker(&mut random, &view);
        let position = camera.camera_to_world.transform_point3(center);
        Light { range: Some(range as f32), ..point(position, 1e-3) }
    };
    Ok((0..count).map(light).collect())
}

/// P7: one camera of each lens in the same place.
pub(super) fn cameras(scene: &Scene) -> Vec<(&'static str, Camera)> {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(scene, 1.5));
    let with = |projection| Camera { projection, ..camera.clone() };
    vec![
        ("perspective", with(Projection::Perspective { yfov: 1.1, aspect: None, znear: 0.05, zfar: None })),
        ("far plane", with(Projection::Perspective { yfov: 0.6, aspect: None, znear: 0.2, zfar: Some(40.0) })),
        ("orthographic", with(Projection::Orthographic { xmag: 6.0, ymag: 4.0, znear: -2.0, zfar: 30.0 })),
    ]
}

/// P1 to P7: `count` lights, each test and each knowledge of depth: nothing missed, lists equal the twin's, pictures equal forward's.
fn projection_of(renderer: &Renderer, count: usize, seed: u64) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut scene = builtin::load("atrium")?;
    let base = Request { width: 72, height: 48, technique: Technique::TiledForward, ..crate::checks::forward() };
    for (lens, camera) in cameras(&scene) {
        scene.lights = lights(&camera, (base.width, base.height), count, seed)?;
        scene.cameras = vec![camera];
        for cull in [CullTest::Bounds, CullTest::Frustum, CullTest::FrustumAabb] {
            for bounds in [DepthBounds::Off, DepthBounds::Mask] {
                let request = Request { cull, depth_bounds: Some(bounds), ..base.clone() };
                let found = verdict(renderer, &scene, &request)?;
                let name = format!("{}, {}, {lens}", cull.name(), bounds.name());
                rows.push(Row::none(format!("P1-P7 {count} lights, {name}"), found.missed, "pairs missed"));
                rows.push(Row::none(format!("P1-P7 lists = twin, {name}"), found.wrong, "buffers that differ"));
            }
        }
        for (kind, bounds, assign) in CLUSTERS {
            let technique = Technique::ClusteredForward;
            let request = Request { technique, cluster_bounds: Some(bounds), assign, ..base.clone() };
            rows.extend(clusters::rows_of(
                renderer,
                &format!("P1-P7 {count} lights, {kind}, {lens}"),
                &scene,
                &request,
            )?);
        }
        let forward = radiance(renderer, &scene, &Request { technique: Technique::Forward, ..base.clone() })?;
        let tiled = radiance(renderer, &scene, &base)?;
        rows.push(Row::none(
            format!("P1-P7 tiled-forward = forward, {lens}"),
            differing(&forward, &tiled),
            "differing pixels",
        ));
        let clustered = Request { technique: Technique::ClusteredForward, ..base.clone() };
        let count = differing(&forward, &radiance(renderer, &scene, &clustered)?);
        rows.push(Row::none(format!("P1-P7 clustered-forward = forward, {lens}"), count, "differing pixels"));
    }
    Ok(rows)
}

/// Clusters that lights are assigned to.
const CLUSTERS: [(&str, ClusterBounds, AssignChoice); 3] = [
    ("explicit clusters", ClusterBounds::Explicit, AssignChoice::Tiles),
    ("implicit clusters", ClusterBounds::Implicit, AssignChoice::Tiles),
    ("explicit clusters by tree", ClusterBounds::Explicit, AssignChoice::Tree),
];

/// 10,000 lights.
pub fn projection(renderer: &Renderer) -> Result<Vec<Row>> {
    projection_of(renderer, 10_000, 11)
}

/// 100,000 lights, 50,000 at a time: more in one tile would pass what drivers loop over.
pub fn projection_deep(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = projection_of(renderer, 50_000, 12)?;
    rows.extend(projection_of(renderer, 50_000, 13)?);
    Ok(rows)
}
