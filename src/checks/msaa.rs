//! Several samples a pixel: techniques against each other, samples of a far wall beside a near bar (HARD-CASES.md, row T7), and the pixels
//! that deferred techniques light sample by sample. The counts that a device lacks are passed over in so many words.

use glam::{DMat4, DVec3};

use super::Row;
use super::hard::fixtures::{flat, point, scene, wall};
use super::lists::{differing, radiance_of};
use super::oracle::shader;
use super::textured;
use crate::error::{Error, Result};
use crate::passes;
use crate::plan::{AssignChoice, DepthBounds, Plan, Request, Technique, TransparentBounds};
use crate::reference::render::Reference;
use crate::renderer::Renderer;
use crate::scene::{Instance, Light, Material, Mesh, Scene, builtin, scatter};

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (150, 85);

const FORWARD_ONES: [Technique; 2] = [Technique::TiledForward, Technique::ClusteredForward];
const DEFERRED_ONES: [Technique; 3] = [Technique::Deferred, Technique::TiledDeferred, Technique::ClusteredDeferred];

fn request(technique: Technique, msaa: u32) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, msaa, strict: true, ..crate::checks::forward() }
}

fn lit(mut scene: Scene, lights: usize) -> Scene {
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
    scene
}

fn scenes() -> Result<Vec<(&'static str, Scene)>> {
    let mut scenes = vec![
        ("cornell", lit(builtin::load("cornell")?, 48)),
        ("atrium", lit(builtin::load("atrium")?, 64)),
        ("glass", lit(builtin::load("glass:layers=3")?, 48)),
    ];
    scenes.extend(textured::mixed().into_iter().map(|(name, scene)| (name, lit(scene, 24))));
    Ok(scenes)
}

/// Counts above one that radiance and depth have, and those that G-buffers have.
fn counts(renderer: &Renderer) -> [Vec<u32>; 2] {
    renderer.limits().samples.map(|bits| [2, 4, 8].into_iter().filter(|count| bits & count != 0).collect())
}

fn radiance(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Vec<u32>> {
    radiance_of(renderer, scene, &Plan::new(scene, request, &renderer.limits())?)
}

/// Forward techniques draw the same bits, deferred ones the same as each other.
pub fn msaa(renderer: &Renderer) -> Result<Vec<Row>> {
    let [lit_counts, stored_counts] = counts(renderer);
    let mut rows = Vec::new();
    for (name, scene) in scenes()? {
        for &count in &lit_counts {
            let whole = radiance(renderer, &scene, &request(Technique::Forward, count))?;
            let single = radiance(renderer, &scene, &request(Technique::Forward, 1))?;
            let changed = differing(&whole, &single);
            rows.push(Row {
                name: format!("{count} samples change edges, {name}"),
                passed: changed > 0,
                detail: format!("{changed} pixels differ from those of one sample"),
            });
            for technique in FORWARD_ONES {
                let found = radiance(renderer, &scene, &request(technique, count))?;
                let row = format!("{} = forward, {count} samples, {name}", technique.name());
                rows.push(Row::none(row, differing(&whole, &found), "differing pixels"));
            }
        }
        for &count in &stored_counts {
            let first = radiance(renderer, &scene, &request(DEFERRED_ONES[0], count))?;
            for technique in &DEFERRED_ONES[1..] {
                let found = radiance(renderer, &scene, &request(*technique, count))?;
                let row = format!("{} = deferred, {count} samples, {name}", technique.name());
                rows.push(Row::none(row, differing(&first, &found), "differing pixels"));
            }
        }
    }
    let glass = &scenes()?[2].1;
    for &count in &lit_counts {
        let forward = |prepass| Request { prepass, ..request(Technique::Forward, count) };
        // What a pixel's middle is taken for may hang on what depth has left of it.
        let [without, with] = [false, true].map(|prepass| radiance(renderer, glass, &forward(prepass)));
        let (without, with) = (without?, with?);
        for (name, request) in variants(count) {
            let whole = if request.prepass { &with } else { &without };
            let found = radiance(renderer, glass, &request)?;
            let row = format!("{name} = forward, {count} samples");
            rows.push(Row::none(row, differing(whole, &found), "differing pixels"));
        }
    }
    Ok(rows)
}

/// Ways to list lights.
fn variants(count: u32) -> Vec<(&'static str, Request)> {
    let tiled = request(Technique::TiledForward, count);
    let clustered = request(Technique::ClusteredForward, count);
    let bounds = |bounds| Request { transparent_bounds: Some(bounds), ..tiled.clone() };
    vec![
        ("tiled-forward no pre-pass", Request { prepass: false, ..tiled.clone() }),
        ("tiled-forward minmax", Request { depth_bounds: Some(DepthBounds::MinMax), tile: 8, ..tiled.clone() }),
        ("tiled-forward by groups", Request { group_a_tile: Some(true), tile: 64, ..tiled.clone() }),
        ("tiled-forward merged", bounds(TransparentBounds::Merged)),
        ("tiled-forward none", bounds(TransparentBounds::None)),
        ("clustered-forward no pre-pass", Request { prepass: false, ..clustered.clone() }),
        ("clustered-forward by the light hierarchy", Request { assign: AssignChoice::Tree, ..clustered.clone() }),
        ("clustered-forward large tiles", Request { tile: 64, ..clustered }),
    ]
}

/// Pixels of the bar's picture: as many metres wide and high.
const BAR_SIZE: (u32, u32) = (24, 16);

/// A near bar before a far wall that a lamp close to it lights; an orthographic lens, a metre a pixel. The bar's edges lie in the middle of pixels,
/// where drivers with any number of sub-pixel bits leave them, and no standard place of 2, 4 or 8 samples is.
fn bar() -> Scene {
    let far = wall(60.0);
    // It reaches the wall and not the bar.
    let lamp = Light { range: Some(66.0), ..point(DVec3::new(0.0, 0.0, -70.0), 9000.0) };
    let half = [f64::from(BAR_SIZE.0) / 2.0, f64::from(BAR_SIZE.1) / 2.0];
    let camera = flat([0.0, 0.0, 10.0], half, [1.0, 200.0]);
    let mut scene = scene(far, vec![lamp], camera);
    let near = Mesh { name: "bar".into(), material: 1, ..wall(1.0) };
    scene.meshes.push(near);
    scene.materials.push(Material {
        base_color: [0.1, 0.7, 0.2, 1.0],
        metallic: 0.0,
        roughness: 0.4,
        ..Material::default()
    });
    let at = |x: f64, y: f64, z: f64, size: [f64; 2]| {
        DMat4::from_translation(DVec3::new(x, y, z)) * DMat4::from_scale(DVec3::new(size[0], size[1], 1.0))
    };
    scene.instances[0].object_to_world = DMat4::from_translation(DVec3::new(0.0, 0.0, -120.0));
    // From -4.5 to 2.5 across and from -2.5 to 4.5 up.
    scene.instances.push(Instance { mesh: 1, object_to_world: at(-1.0, 1.0, 0.0, [3.5, 3.5]) });
    scene
}

fn bar_request(technique: Technique, msaa: u32) -> Request {
    Request { width: BAR_SIZE.0, height: BAR_SIZE.1, ..request(technique, msaa) }
}

/// Light at a sample of the wall and at the place of the pixel that stands for it, which drivers may choose, are less apart than this.
const BAR_ERROR: f64 = 2e-2;

/// T7: each sample shows what a ray through it meets, lit.
pub fn msaa_bar(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = bar();
    let mut rows = Vec::new();
    let [lit_counts, stored_counts] = counts(renderer);
    let techniques = [Technique::Forward].into_iter().chain(FORWARD_ONES).map(|t| (t, &lit_counts));
    for (technique, counts) in techniques.chain(DEFERRED_ONES.map(|t| (t, &stored_counts))) {
        for &count in counts {
            let plan = Plan::new(&scene, &bar_request(technique, count), &renderer.limits())?;
            let traced = Reference::new(&scene, &plan.view)?.of_samples(count).render(&shader(&plan), &|_| {});
            let drawn = radiance_of(renderer, &scene, &plan)?;
            let value = |bits: u32| f64::from(f32::from_bits(bits));
            let error = drawn.chunks_exact(4).zip(&traced.rgba).flat_map(|(pixel, wanted)| {
                (0..3).map(|c| (value(pixel[c]) - wanted[c]).abs() / wanted[c].abs().max(1e-3)).collect::<Vec<_>>()
            });
            let most = error.fold(0.0, super::oracle::larger);
            let row = format!("T7 samples of a far wall, {}, {count} samples", technique.name());
            rows.push(Row::at_most(row, most, BAR_ERROR));
        }
    }
    Ok(rows)
}

/// Pixels that the device says are edges.
fn edges(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<bool>> {
    let frame = passes::edges_frame(plan).ok_or_else(|| Error::new("the plan has one sample a pixel"))?;
    let mut prepared = renderer.prepare_frame(scene, plan, frame)?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    if let Some(violation) = violations.first() {
        return Err(Error::new(format!("the checker found {violation}")));
    }
    Ok(picture.layer("sample_edges").unwrap_or(&[]).iter().map(|word| word.to_bits() != 0).collect())
}

/// Pixels through whose samples rays meet different instances.
fn mixed(scene: &Scene, plan: &Plan) -> Result<Vec<bool>> {
    let views: Result<Vec<Reference>> = crate::math::samples::locations(plan.samples)
        .iter()
        .map(|place| {
            let [x, y] = place.map(|sixteenths| f64::from(sixteenths) / 16.0 - 0.5);
            Reference::new(scene, &plan.view.moved(x, y))
        })
        .collect();
    let views = views?;
    let pixel = |x: u32, y: u32| {
        let mut seen = views.iter().map(|view| view.surface(x, y).map(|hit| hit.instance));
        let first = seen.next().flatten();
        seen.any(|instance| instance != first)
    };
    let (width, height) = (plan.view.width, plan.view.height);
    Ok((0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect())
}

/// Deferred techniques light samples one by one exactly where they differ, and agree with forward elsewhere.
pub fn msaa_edges(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let [_, stored_counts] = counts(renderer);
    let scene = bar();
    for &count in &stored_counts {
        let plan = Plan::new(&scene, &bar_request(Technique::TiledDeferred, count), &renderer.limits())?;
        let (found, wanted) = (edges(renderer, &scene, &plan)?, mixed(&scene, &plan)?);
        let expected = wanted.iter().filter(|mixed| **mixed).count();
        let wrong = found.iter().zip(&wanted).filter(|(a, b)| a != b).count();
        rows.push(Row {
            name: format!("pixels whose {count} samples differ, and no others"),
            passed: wrong == 0 && found.len() == wanted.len() && expected > 0,
            detail: format!("{wrong} wrong, {expected} of {} differ", wanted.len()),
        });
        let forward = radiance(renderer, &scene, &bar_request(Technique::Forward, count))?;
        let deferred = radiance_of(renderer, &scene, &plan)?;
        let value = |bits: u32| f64::from(f32::from_bits(bits));
        let inner = (0..wanted.len()).filter(|&pixel| !wanted[pixel]);
        let error = inner.map(|pixel| {
            let of = |bits: &[u32], c: usize| value(bits[pixel * 4 + c]);
            (0..3)
                .map(|c| (of(&forward, c) - of(&deferred, c)).abs() / of(&forward, c).abs().max(1e-3))
                .fold(0.0, f64::max)
        });
        let most = error.fold(0.0, super::oracle::larger);
        rows.push(Row::at_most(format!("deferred = forward where {count} samples show one triangle"), most, BAR_ERROR));
    }
    Ok(rows)
}
