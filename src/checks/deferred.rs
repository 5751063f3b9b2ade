//! Deferred techniques: all forms of adding lights agree bit for bit, a G-buffer in 32-bit floats draws what forward draws, the compact
//! one stays within its bound, and light volumes are right wherever the eye is.

use glam::DVec3;

use super::Row;
use super::lists::radiance;
use crate::error::Result;
use crate::math::random::Random;
use crate::measure::metrics;
use crate::plan::{AssignChoice, ClusterBounds, DeferredLights, GbufferLayout, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::{Camera, Light, LightKind, Projection, Scene, builtin, scatter};

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (150, 85);

/// Every built-in scene.
const SCENES: [&str; 5] = ["cornell", "corridor", "atrium", "terrain", "furnace"];

/// Mean relative error of the compact G-buffer against forward.
const COMPACT_BOUND: f64 = 5e-3;

fn request() -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique: Technique::TiledDeferred, ..crate::checks::forward() }
}

fn forms(base: &Request) -> Vec<(String, Request)> {
    let volumes = DeferredLights::ALL.into_iter().map(|lights| {
        let request = Request { technique: Technique::Deferred, deferred_lights: lights, ..base.clone() };
        (format!("deferred {}", lights.name()), request)
    });
    let clustered = Request { technique: Technique::ClusteredDeferred, ..base.clone() };
    let threads = [1, 4].map(|pixels| {
        let request = Request { pixels_a_thread: Some(pixels), ..base.clone() };
        (format!("tiled-deferred, pixels a thread {pixels},"), request)
    });
    volumes.chain(threads).chain([("clustered-deferred".to_string(), clustered)]).collect()
}

/// Ways to make clusters that `forms` leaves out.
fn clusters(base: &Request) -> Vec<(String, Request)> {
    let clustered = Request { technique: Technique::ClusteredDeferred, ..base.clone() };
    let tiles =
        [8, 32, 64].map(|tile| (format!("clustered-deferred, tile {tile}"), Request { tile, ..clustered.clone() }));
    let implicit = Request { cluster_bounds: Some(ClusterBounds::Implicit), ..clustered.clone() };
    let tree = Request { assign: AssignChoice::Tree, ..clustered.clone() };
    let dense = Request { prepass: false, ..clustered };
    let others = [
        ("clustered-deferred, by tree".to_string(), tree),
        ("clustered-deferred, implicit".to_string(), implicit),
        ("clustered-deferred, no pre-pass".to_string(), dense),
    ];
    tiles.into_iter().chain(others).collect()
}

fn differing(a: &[u32], b: &[u32]) -> usize {
    if a.len() != b.len() || a.is_empty() {
        return usize::MAX;
    }
    a.chunks(4).zip(b.chunks(4)).filter(|(p, q)| p != q).count()
}

fn pixels(bits: &[u32]) -> Vec<[f64; 4]> {
    let rgba = |p: &[u32]| [p[0], p[1], p[2], p[3]].map(|w| f64::from(f32::from_bits(w)));
    bits.chunks_exact(4).map(rgba).collect()
}

/// A scene with lights of every kind.
fn scene(name: &str) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    let bounds = scene.bounds();
    scene.lights = scatter::point_lights(&bounds, 40, 9);
    for (index, light) in scene.lights.iter_mut().enumerate() {
        if index % 5 == 0 {
            light.kind = LightKind::Spot { inner: 0.3, outer: 0.7 };
            light.direction = DVec3::new(0.2, -1.0, 0.1).normalize();
        }
    }
    let sun = Light { kind: LightKind::Directional, intensity: 0.2, range: None, ..scene.lights[1].clone() };
    scene.lights.insert(7, sun);
    Ok(scene)
}

/// Every form agrees with tiled-deferred, fat with forward to the bit, compact within its bound.
pub fn deferred(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let fat_fits = renderer.limits().max_color_attachments >= 5;
    for name in SCENES {
        let scene = scene(name)?;
        let forward = radiance(renderer, &scene, &Request { technique: Technique::Forward, ..request() })?;
        let tiled = radiance(renderer, &scene, &request())?;
        for (form, request) in forms(&request()) {
            let other = radiance(renderer, &scene, &request)?;
            rows.push(Row::none(
                format!("{form} = tiled-deferred, {name}"),
                differing(&tiled, &other),
                "differing pixels",
            ));
        }
        let error = metrics::compare(&pixels(&forward), &pixels(&tiled)).mean_relative;
        rows.push(Row::at_most(format!("compact G-buffer against forward, {name}"), error, COMPACT_BOUND));
        if fat_fits {
            for technique in [Technique::TiledDeferred, Technique::ClusteredDeferred] {
                let fat = Request { gbuffer: GbufferLayout::Fat, technique, ..request() };
                let fat = radiance(renderer, &scene, &fat)?;
                let row = format!("fat G-buffer, {} = forward, {name}", technique.name());
                rows.push(Row::none(row, differing(&forward, &fat), "differing pixels"));
            }
        }
    }
    let scene = scene("atrium")?;
    let tiled = radiance(renderer, &scene, &request())?;
    for (form, request) in clusters(&request()) {
        let other = radiance(renderer, &scene, &request)?;
        rows.push(Row::none(format!("{form} = tiled-deferred"), differing(&tiled, &other), "differing pixels"));
    }
    let without = Request { prepass: false, ..request() };
    let other = radiance(renderer, &scene, &without)?;
    rows.push(Row::none("tiled-deferred, pre-pass on = off", differing(&tiled, &other), "differing pixels"));
    Ok(rows)
}

/// Light markers are the same picture in every technique.
pub fn markers(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = scene("atrium")?;
    let with = |technique, gbuffer| Request { show_lights: true, technique, gbuffer, ..request() };
    let fat = renderer.limits().max_color_attachments >= 5;
    let gbuffer = if fat { GbufferLayout::Fat } else { GbufferLayout::Compact };
    let forward = radiance(renderer, &scene, &with(Technique::Forward, gbuffer))?;
    let plain = radiance(renderer, &scene, &Request { show_lights: false, ..with(Technique::Forward, gbuffer) })?;
    let shown = differing(&forward, &plain);
    let mut rows = vec![Row { name: "lights are shown".into(), passed: shown > 0, detail: format!("{shown} pixels") }];
    for technique in
        [Technique::TiledForward, Technique::TiledDeferred, Technique::ClusteredDeferred, Technique::Deferred]
    {
        let other = radiance(renderer, &scene, &with(technique, gbuffer))?;
        let name = format!("lights shown by {} as by forward", technique.name());
        if fat || technique == Technique::TiledForward {
            rows.push(Row::none(name, differing(&forward, &other), "differing pixels"));
        }
    }
    Ok(rows)
}

/// L7: the eye inside, at and just outside of volumes, volumes that reach past the far plane or across the near one.
pub fn volumes(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut scene = builtin::load("atrium")?;
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene, 1.5));
    let lenses = [
        ("infinite", Projection::Perspective { yfov: 1.1, aspect: None, znear: 0.05, zfar: None }),
        ("far plane", Projection::Perspective { yfov: 0.9, aspect: None, znear: 0.3, zfar: Some(9.0) }),
        ("orthographic", Projection::Orthographic { xmag: 5.0, ymag: 4.0, znear: -1.0, zfar: 20.0 }),
        ("mirrored", Projection::Orthographic { xmag: -5.0, ymag: 4.0, znear: 0.1, zfar: 20.0 }),
    ];
    for (name, projection) in lenses {
        let camera = Camera { projection, ..camera.clone() };
        scene.lights = round_the_eye(&camera);
        scene.cameras = vec![camera];
        let tiled = radiance(renderer, &scene, &request())?;
        for (form, request) in forms(&request()).into_iter().take(2) {
            let other = radiance(renderer, &scene, &request)?;
            let name = format!("L7 {form}, {name}");
            rows.push(Row::none(name, differing(&tiled, &other), "pixels other than tiled-deferred's"));
        }
    }
    Ok(rows)
}

/// Lights whose surface passes through the eye to an ulp, just before and behind it, and others at any distance.
fn round_the_eye(camera: &Camera) -> Vec<Light> {
    let mut random = Random::new(4);
    let mut unit = || {
        let axis = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        axis.try_normalize().unwrap_or(DVec3::X)
    };
    let mut lights = Vec::new();
    for range in [0.02f32, 0.4, 3.0, 30.0] {
        for off in [0.0, 0.5, 1.0 - 1.2e-7, 1.0, 1.0 + 1.2e-7, 1.01, 1.5, 4.0] {
            let center = unit() * f64::from(range) * off;
            lights.push(Light {
                name: "lamp".into(),
                kind: LightKind::Point,
                color: [1.0, 0.7, 0.4],
                intensity: 0.3,
                position: camera.camera_to_world.transform_point3(center),
                direction: DVec3::NEG_Z,
                range: Some(range),
                shadow: false,
            });
        }
    }
    lights
}
