//! Bounced light on the device: against its twin bit for bit, against paths, in rooms whose answer is known, and behind walls.

mod hard;
mod moving;
mod sight;

use std::sync::Arc;

use super::Row;
use super::lists::{differing, radiance_of};
use super::oracle::shader;
use crate::error::{Error, Result};
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::bounced;
use crate::plan::{CameraChoice, Gathering, Gi, MatrixPath, Plan, Request, Technique};
use crate::radiosity::bake::{Bake, CodecName, Operator, PatchRule, Settings};
use crate::radiosity::gather::gathered;
use crate::radiosity::judge::after_bounces;
use crate::radiosity::{Exchange, codec, solve};
use crate::reference::render::{Paths, Reference};
use crate::renderer::Renderer;
use crate::scene::lighting::LightRules;
use crate::scene::shading::Shading;
use crate::scene::view::View;
use crate::scene::{Light, LightKind, Scene, builtin};
use crate::shared::PATCH_POINTS;
use glam::DVec3;

pub use hard::radiosity_hard;
pub use moving::radiosity_moving;
pub use sight::radiosity_sight;

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (60, 45);

fn baked(scene: &Scene, count: usize, codec: CodecName) -> Result<Arc<Bake>> {
    Bake::of_scene(scene, Settings { patches: PatchRule::Count(count), codec, ..Settings::default() }).map(Arc::new)
}

fn request(bake: &Arc<Bake>, technique: Technique) -> Request {
    Request {
        width: SIZE.0,
        height: SIZE.1,
        technique,
        shading: Shading::Lambert,
        rules: LightRules { emission_lights: true, ..LightRules::default() },
        gi: Gi::Radiosity(Gathering { tolerance: 1e-3, ..Gathering::default() }),
        bake: Some(Arc::clone(bake)),
        ..Request::default()
    }
}

/// Four numbers of a patch.
type Texel = [f32; 4];

/// Light of each patch when all is gathered: irradiance, the same one step before, what is sent, and what was sent at first.
fn patch_light(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<[Texel; 4]>> {
    let mut prepared = renderer.prepare_frame(scene, plan, passes::patch_frame(plan))?;
    prepared.draw(1)?;
    let picture: Picture = prepared.read_back()?;
    let values = picture.layer("patch_light").ok_or_else(|| Error::new("no light of patches was read back"))?;
    let texel = |at: &[f32]| -> Texel { std::array::from_fn(|c| at[c]) };
    Ok(values.chunks_exact(16).map(|p| std::array::from_fn(|k| texel(&p[4 * k..4 * k + 4]))).collect())
}

fn rgb(texel: Texel) -> [f32; 3] {
    [texel[0], texel[1], texel[2]]
}

/// How far from the twin a sampler's own interpolation between ends of blocks may take irradiance, relative L2: a code of the thesis' logarithms is a
/// tenth of a value, and formats leave the last codes to the device.
const SAMPLED_BOUND: f64 = 0.1;

/// Gathers equal their twin bit for bit, in every codec and by every path to its words; sizes that are no multiple of a block included.
pub fn radiosity_twin(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("cornell")?;
    let exchange = Exchange::of_scene(&scene, &Settings::of_count(150))?;
    let one = Exchange::of_scene(&scene, &Settings::of_count(1))?;
    let mut rows = Vec::new();
    for codec in CodecName::ALL {
        let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(codec))?);
        rows.extend(twin_rows(renderer, &scene, &bake)?);
    }
    // One channel stands for three where all is grey.
    let grey = grey(&scene);
    let exchange = Exchange::of_scene(&grey, &Settings::of_count(150))?;
    for codec in [CodecName::ZeroBlock, CodecName::Classical] {
        let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(codec))?);
        let of_grey = twin_rows(renderer, &grey, &bake)?;
        rows.extend(of_grey.into_iter().map(|row| Row { name: format!("{}, all grey", row.name), ..row }));
        for (name, scene, wanted) in [("all grey", &grey, true), ("a coloured lamp", &coloured_lamp(&grey), false)] {
            let plan = Plan::new(scene, &request(&bake, Technique::Forward), &renderer.limits())?;
            let found = plan.bounced.as_ref().is_some_and(|bounced| bounced.grey);
            rows.push(Row::none(
                format!("one channel, {}, {name}", codec.name()),
                usize::from(found != wanted),
                "faults",
            ));
        }
    }
    for codec in [CodecName::ZeroBlock, CodecName::Bc1] {
        let bake = Arc::new(Bake::new(one.clone(), Settings::of_codec(codec))?);
        rows.extend(twin_rows(renderer, &scene, &bake)?);
    }
    Ok(rows)
}

/// The same without colours.
fn grey(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        let [red, _, _, alpha] = material.base_color;
        material.base_color = [red, red, red, alpha];
        material.emissive = [material.emissive[0]; 3];
    }
    scene.lights.iter_mut().for_each(|light| light.color = [1.0; 3]);
    scene
}

/// Under another lamp.
fn coloured_lamp(scene: &Scene) -> Scene {
    Scene { lights: vec![lamp(DVec3::ZERO)], ..scene.clone() }
}

fn twin_rows(renderer: &Renderer, scene: &Scene, bake: &Arc<Bake>) -> Result<Vec<Row>> {
    let (codec, count) = (bake.settings.codec, bake.patches.list.len());
    let limits = renderer.limits();
    let mut rows = Vec::new();
    let shapes = [
        (MatrixPath::Buffer, false),
        (MatrixPath::Texel, false),
        (MatrixPath::Sampled, false),
        (MatrixPath::Buffer, true),
    ];
    for (path, thread_rows) in shapes {
        if thread_rows && codec != CodecName::Classical {
            continue;
        }
        let gathering = Gathering { tolerance: 1e-3, path, thread_rows, ..Gathering::default() };
        let asked = Request { gi: Gi::Radiosity(gathering), ..request(bake, Technique::Forward) };
        // Not every codec is a texture, and not every device samples blocks.
        let sampled = !matches!(codec, CodecName::ZeroBlock | CodecName::DenseF16);
        let blocks = sampled && codec != CodecName::Classical;
        if path == MatrixPath::Sampled && (!sampled || (blocks && !limits.block_compression)) {
            continue;
        }
        let plan = Plan::new(scene, &asked, &limits)?;
        let bounced = plan.bounced.as_ref().ok_or_else(|| Error::new("nothing is gathered"))?;
        let found = patch_light(renderer, scene, &plan)?;
        let areas: Vec<f32> = bounced.patches.iter().map(|p| p.area).collect();
        let reflectance: Vec<[f32; 3]> = bounced.patches.iter().map(|p| p.reflectance).collect();
        let first: Vec<[f32; 3]> = found.iter().map(|p| rgb(p[3])).collect();
        let lanes = if thread_rows { 1 } else { bounced.lanes as usize };
        let twin = gathered(&bake.operator, &areas, &reflectance, &first, &bounced.steps, lanes);
        let shape = if thread_rows { ", a thread a row" } else { "" };
        let name = format!("gathers = twin, {}, {}{shape}, {count} patches", codec.name(), path.name());
        if path == MatrixPath::Sampled && blocks {
            let wide =
                |all: &mut dyn Iterator<Item = [f32; 3]>| -> Vec<[f64; 3]> { all.map(|e| e.map(f64::from)).collect() };
            let areas: Vec<f64> = areas.iter().copied().map(f64::from).collect();
            let found = wide(&mut found.iter().map(|p| rgb(p[0])));
            let off = codec::relative_l2(&found, &wide(&mut twin.iter().copied()), &areas);
            rows.push(Row::at_most(format!("R9 {name}"), off, SAMPLED_BOUND));
            continue;
        }
        let wrong = found.iter().zip(&twin).filter(|(a, b)| rgb(a[0]).map(f32::to_bits) != b.map(f32::to_bits)).count();
        rows.push(Row::none(format!("R9 {name}"), wrong + usize::from(found.is_empty()), "patches differ"));
        let dark = count > 1 && twin.iter().all(|e| *e == [0.0; 3]);
        if path == MatrixPath::Buffer {
            let name = format!("{}{shape}, {count} patches: some light", codec.name());
            rows.push(Row::none(name, usize::from(dark), "faults"));
        }
    }
    Ok(rows)
}

/// What patches send at first against rays to the same points.
pub fn radiosity_direct(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    // In a convex room nothing stands in the way.
    let mut convex = builtin::load("furnace")?;
    convex.materials.iter_mut().for_each(|m| m.emissive = [0.0; 3]);
    convex.lights = vec![lamp(DVec3::new(0.3, 0.2, 0.1))];
    for (name, scene, bound) in [("convex room", convex, 1e-5), ("cornell", builtin::load("cornell")?, 2e-2)] {
        let bake = baked(&scene, 200, CodecName::ZeroBlock)?;
        let plan = Plan::new(&scene, &request(&bake, Technique::Forward), &renderer.limits())?;
        let found = patch_light(renderer, &scene, &plan)?;
        let view = View::of_world();
        let reference = Reference::new(&scene, &view)?;
        let in_world = Plan { view, ..plan.clone() };
        let direct = solve::direct_at(&bake.patches, &bake.points, &reference, &shader(&in_world));
        let (mut off, mut all) = (0.0, 0.0);
        for ((patch, light), direct) in bake.patches.list.iter().zip(&found).zip(&direct) {
            let right = patch.emission * std::f64::consts::PI + patch.reflectance * *direct;
            off += (f64::from(light[3][1]) - right.y).abs() * patch.area;
            all += right.y * patch.area;
        }
        rows.push(Row::at_most(format!("light of patches at first, {name}"), off / all, bound));
    }
    rows.extend(few_points(renderer)?);
    Ok(rows)
}

/// A dark room under a sun looks at fewer points of a patch: the light of those is that of rays, and what bounces is off by less than the tolerance
/// from what the CPU makes of all points in f64.
fn few_points(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut scene = builtin::load("cornell")?;
    for material in &mut scene.materials {
        material.emissive = [0.0; 3];
        material.base_color[..3].fill(0.04);
    }
    let direction = DVec3::new(0.3, -0.5, -1.0).normalize();
    scene.lights =
        vec![Light { kind: LightKind::Directional, direction, range: None, shadow: true, ..lamp(DVec3::ZERO) }];
    let bake = baked(&scene, 200, CodecName::ZeroBlock)?;
    let asked = Request { gi: Gi::Radiosity(Gathering::default()), ..request(&bake, Technique::Forward) };
    let plan = Plan::new(&scene, &asked, &renderer.limits())?;
    let each = plan.bounced.as_ref().map_or(0, |bounced| bounced.points_each);
    let light = patch_light(renderer, &scene, &plan)?;
    let (patches, view) = (&bake.patches.list, View::of_world());
    let reference = Reference::new(&scene, &view)?;
    let in_world = Plan { view, ..plan.clone() };
    let direct = |each: u32| -> Vec<DVec3> {
        let points: Vec<[DVec3; 2]> = bounced::points(&bake.points, each).copied().collect();
        solve::direct_at(&bake.patches, &points, &reference, &shader(&in_world))
    };
    let (few, all) = (direct(each), direct(PATCH_POINTS));
    let first: Vec<[f32; 3]> =
        patches.iter().zip(&all).map(|(p, e)| (p.reflectance * *e).as_vec3().to_array()).collect();
    let Operator::ZeroBlock(matrix) = &bake.operator else { return Err(Error::new("another codec")) };
    let right = after_bounces(&|sent| matrix.product(sent, 32), &bake.patches, &first);
    let (mut at_first, mut sent, mut off, mut mean, mut area) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (index, patch) in patches.iter().enumerate() {
        let wanted = patch.reflectance.y * few[index].y;
        at_first += (f64::from(light[index][3][1]) - wanted).abs() * patch.area;
        sent += wanted * patch.area;
        off += (f64::from(light[index][0][1]) - right[index][1]).powi(2) * patch.area;
        mean += (right[index][1] + all[index].y) * patch.area;
        area += patch.area;
    }
    let wrong = usize::from(each != 4);
    Ok(vec![
        Row::none("a dark room looks at four points of a patch", wrong, "faults"),
        Row::at_most("light of patches at first, four points", at_first / sent, 2e-2),
        Row::at_most("light with four points, of all light", (off / area).sqrt() / (mean / area), Gathering::TOLERANCE),
    ])
}

fn lamp(position: DVec3) -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Point,
        color: [1.0, 0.8, 0.6],
        intensity: 10.0,
        position,
        direction: DVec3::NEG_Z,
        range: Some(1e4),
        shadow: false,
    }
}

/// R5: a closed room that emits what its walls take away is 1 everywhere.
pub fn radiosity_furnace(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for albedo in [0.5, 0.9] {
        let scene = builtin::load(&format!("furnace:albedo={albedo}"))?;
        let bake = baked(&scene, 200, CodecName::ZeroBlock)?;
        let plan = Plan::new(&scene, &request(&bake, Technique::Forward), &renderer.limits())?;
        let picture = radiance_of(renderer, &scene, &plan)?;
        let off = picture.chunks(4).flat_map(|p| &p[..3]).map(|bits| (f64::from(f32::from_bits(*bits)) - 1.0).abs());
        rows.push(Row::at_most(format!("R5 furnace of albedo {albedo}"), off.fold(0.0, f64::max), 1e-2));
    }
    Ok(rows)
}

/// R14: behind a wall without a door there is no light at all.
pub fn radiosity_leaks(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("corridor:door=0")?;
    let bake = baked(&scene, 300, CodecName::ZeroBlock)?;
    // From the far room, looking at its walls; light is in the other one.
    let lit_side = scene.lights.iter().map(|light| light.position.x).sum::<f64>().signum();
    let eye = DVec3::new(-lit_side * 2.0, 1.3, 0.0);
    let camera = CameraChoice::LookAt(eye, DVec3::new(-lit_side * 0.1, 1.0, 0.4), 1.2);
    let asked = Request { camera, ..request(&bake, Technique::Forward) };
    let plan = Plan::new(&scene, &asked, &renderer.limits())?;
    let found = patch_light(renderer, &scene, &plan)?;
    let lit = |side: f64| {
        let of = bake.patches.list.iter().zip(&found).filter(move |(p, _)| p.center.x * side > 0.2 && inside(p.center));
        of.filter(|(_, light)| rgb(light[0]) != [0.0; 3]).count()
    };
    let picture = radiance_of(renderer, &scene, &plan)?;
    let pixels = picture.chunks(4).filter(|p| p[..3].iter().any(|bits| f32::from_bits(*bits) != 0.0)).count();
    Ok(vec![
        Row::none("R14 patches behind a closed wall", lit(-lit_side), "with light"),
        Row::none("R14 patches before it", usize::from(lit(lit_side) < 20), "faults"),
        Row::none("R14 pixels behind a closed wall", pixels, "with light"),
    ])
}

/// Within the rooms, not on the outside of their walls.
fn inside(center: DVec3) -> bool {
    center.y > -0.01 && center.y < 2.61 && center.z.abs() < 2.0 && center.x.abs() < 3.99
}

/// Every technique shows the same bounced light.
pub fn radiosity_agreement(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("cornell")?;
    let bake = baked(&scene, 150, CodecName::ZeroBlock)?;
    let picture = |technique| -> Result<Vec<u32>> {
        let plan = Plan::new(&scene, &request(&bake, technique), &renderer.limits())?;
        radiance_of(renderer, &scene, &plan)
    };
    let forward = picture(Technique::Forward)?;
    let mut rows = Vec::new();
    for technique in [Technique::TiledForward, Technique::ClusteredForward] {
        let wrong = differing(&forward, &picture(technique)?);
        rows.push(Row::none(format!("bounced light, {} = forward", technique.name()), wrong, "differing pixels"));
    }
    let value = |bits: &u32| f64::from(f32::from_bits(*bits));
    let mean = forward.iter().map(value).sum::<f64>() / forward.len() as f64;
    for technique in [Technique::Deferred, Technique::TiledDeferred, Technique::ClusteredDeferred] {
        let other = picture(technique)?;
        let off = forward.iter().zip(&other).map(|(a, b)| (value(a) - value(b)).abs() / value(a).abs().max(mean));
        let sum: f64 = off.sum();
        let name = format!("bounced light, {} against forward, mean", technique.name());
        rows.push(Row::at_most(name, sum / forward.len() as f64, 3e-3));
    }
    let off = Request { gi: Gi::Off, shadows: Some(1), ..request(&bake, Technique::Forward) };
    let without = radiance_of(renderer, &scene, &Plan::new(&scene, &off, &renderer.limits())?)?;
    let same = differing(&forward, &without) < forward.len() / 16;
    rows.push(Row::none("bounced light is seen", usize::from(same), "faults"));
    Ok(rows)
}

/// A picture of bounced light against paths from the same pixels.
pub fn radiosity_path(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, bias_bound, rms_bound) in [("cornell", 0.03, 0.2)] {
        let scene = builtin::load(name)?;
        let bake = baked(&scene, 500, CodecName::ZeroBlock)?;
        let asked = request(&bake, Technique::Forward);
        let plan = Plan::new(&scene, &asked, &renderer.limits())?;
        let drawn = radiance_of(renderer, &scene, &plan)?;
        let direct = Request { gi: Gi::Off, shadows: Some(16), ..asked.clone() };
        let direct = radiance_of(renderer, &scene, &Plan::new(&scene, &direct, &renderer.limits())?)?;
        let reference = Reference::new(&scene, &plan.view)?;
        let traced = reference.bounced(&shader(&plan), Paths { count: 400, seed: 1 }, &|_| {});
        // Means of squares of pixels: paths are noisy.
        const SQUARE: usize = 5;
        let (width, height) = (SIZE.0 as usize / SQUARE, SIZE.1 as usize / SQUARE);
        let mut squares = vec![[0.0f64; 2]; width * height];
        for (index, wanted) in traced.rgb.iter().enumerate() {
            let (x, y) = (index % SIZE.0 as usize / SQUARE, index / SIZE.0 as usize / SQUARE);
            let of = |bits: &[u32]| f64::from(f32::from_bits(bits[index * 4 + 1]));
            squares[y * width + x][0] += of(&drawn) - of(&direct);
            squares[y * width + x][1] += wanted[1];
        }
        let mean = squares.iter().map(|s| s[1]).sum::<f64>() / squares.len() as f64;
        let bias = squares.iter().map(|s| s[0]).sum::<f64>() / squares.len() as f64 / mean - 1.0;
        let square = squares.iter().map(|s| (s[0] - s[1]).powi(2)).sum::<f64>() / squares.len() as f64;
        rows.push(Row::at_most(format!("bounced light of {name} against paths, mean"), bias.abs(), bias_bound));
        rows.push(Row::at_most(format!("bounced light of {name} against paths, rms"), square.sqrt() / mean, rms_bound));
    }
    Ok(rows)
}
