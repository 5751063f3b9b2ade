//! A sun that turns and a lamp that is switched, in a picture that was prepared once.

use std::sync::Arc;

use glam::DVec3;

use super::{Row, baked, lamp, request};
use crate::checks::lists::radiance_of;
use crate::error::{Error, Result};
use crate::graph::log::Event;
use crate::passes;
use crate::plan::{Gathering, Gi, Plan, Request, Technique};
use crate::radiosity::bake::{Bake, CodecName, Settings};
use crate::radiosity::{Exchange, Patch};
use crate::renderer::{Prepared, Renderer};
use crate::scene::{Light, LightKind, Scene, builtin};

/// Radiance of the lamp while it shines, candela: R17's.
const BRIGHT: f32 = 1e4;

/// The box under a sun that shines in through its open side, and a lamp.
fn fixture() -> Result<Scene> {
    let mut scene = builtin::load("cornell")?;
    let sun = Light { kind: LightKind::Directional, intensity: 2.0, range: None, ..lamp(DVec3::ZERO) };
    scene.lights = vec![Light { direction: toward(0.0), ..sun }, lamp(DVec3::new(0.1, 0.2, 0.05))];
    Ok(scene)
}

fn toward(turn: f64) -> DVec3 {
    DVec3::new((0.6 * turn).sin(), -0.5, -(0.6 * turn).cos()).normalize()
}

/// Bits of the picture after a frame.
fn drawn(prepared: &mut Prepared) -> Result<Vec<u32>> {
    prepared.draw(1)?;
    let picture = prepared.read_back()?;
    Ok(picture.layer("radiance").into_iter().flatten().map(|x| x.to_bits()).collect())
}

/// Accesses of passes that bounced light and shadows are made by, since the last call.
fn gathered(prepared: &Prepared) -> usize {
    let made =
        |event: &&Event| matches!(event, Event::Access(a) if a.node.starts_with("patch_") || a.node == "shadow_map");
    prepared.log().iter().filter(made).count()
}

/// After each move the picture is the one that is prepared anew for these lights, bit for bit; nothing is made for it, a lamp of 10,000 candela that goes
/// out leaves nothing behind, and a frame in which nothing moved gathers nothing.
pub fn radiosity_moving(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut scene = fixture()?;
    let bake = baked(&scene, 150, CodecName::ZeroBlock)?;
    for technique in [
        Technique::Forward,
        Technique::TiledForward,
        Technique::Deferred,
        Technique::TiledDeferred,
        Technique::ClusteredDeferred,
    ] {
        let moving = Request { lights_move: true, shadow_size: 256, ..request(&bake, technique) };
        let still = Request { lights_move: false, ..moving.clone() };
        let limits = renderer.limits();
        // Prepared with the lamp on: lists have room for it.
        scene.lights[1].intensity = BRIGHT;
        let mut plan = Plan::new(&scene, &moving, &limits)?;
        let mut prepared = renderer.prepare(&scene, &plan)?;
        drawn(&mut prepared)?;
        let made = renderer.device().objects_made();
        let (mut wrong, mut idle, mut off) = (0, 0, 0f64);
        let mut dark = Vec::new();
        for (step, (turn, intensity)) in
            [(0.0, 0.0), (0.0, BRIGHT), (1.0, BRIGHT), (1.5, 0.0), (0.0, 0.0)].into_iter().enumerate()
        {
            scene.lights[0].direction = toward(turn);
            scene.lights[1].intensity = intensity;
            plan = plan.relit(&scene, &moving, &limits)?;
            prepared.relight(&plan)?;
            let found = drawn(&mut prepared)?;
            idle += usize::from(gathered(&prepared) == 0);
            prepared.draw(1)?;
            idle += gathered(&prepared);
            if step == 0 {
                dark.clone_from(&found);
            }
            if step == 4 {
                wrong += usize::from(found != dark);
            } else {
                let anew = drawn_anew(renderer, &scene, &moving)?;
                let value = |bits: &u32| f64::from(f32::from_bits(*bits));
                let held = drawn_anew(renderer, &scene, &still)?;
                let apart = found.iter().zip(&held).map(|(a, b)| (value(a) - value(b)).abs() / value(b).max(1e-3));
                off = apart.fold(off, f64::max);
                wrong += usize::from(found != anew || found == dark && step > 0);
            }
        }
        let name = technique.name();
        // What was made for the pictures to compare with has been made by other preparations.
        let own = prepared_alone(renderer, &mut scene, &moving)?;
        rows.push(Row::none(format!("moved lights = prepared anew, {name}"), wrong, "pictures differ"));
        // Maps lie elsewhere in their image, so that weights of filters are rounded otherwise.
        rows.push(Row::at_most(format!("moved lights against lights that stand still, {name}"), off, 1e-4));
        rows.push(Row::none(format!("moved lights, {name}: gathers"), idle, "too many or none"));
        rows.push(Row::none(format!("moved lights, {name}"), own as usize, "objects made"));
        let violations = prepared.check();
        rows.push(Row::none(format!("moved lights, {name}: every access ordered"), violations.len(), "not ordered"));
        rows.push(Row::none(
            format!("moved lights, {name}: objects are counted"),
            usize::from(renderer.device().objects_made() <= made),
            "faults",
        ));
    }
    rows.extend(refusals(renderer, &mut scene, &bake)?);
    feedback(renderer, &mut scene, &mut rows)?;
    columns(renderer, &mut rows)?;
    Ok(rows)
}

fn drawn_anew(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Vec<u32>> {
    radiance_of(renderer, scene, &Plan::new(scene, request, &renderer.limits())?)
}

/// Allocations and pipelines that moving and switching make.
fn prepared_alone(renderer: &Renderer, scene: &mut Scene, request: &Request) -> Result<u64> {
    scene.lights[1].intensity = BRIGHT;
    let limits = renderer.limits();
    let mut plan = Plan::new(scene, request, &limits)?;
    let mut prepared = renderer.prepare(scene, &plan)?;
    prepared.draw(1)?;
    let made = renderer.device().objects_made();
    for step in 0..4 {
        scene.lights[0].direction = toward(f64::from(step) * 0.3);
        scene.lights[1].intensity = if step % 2 == 0 { 0.0 } else { BRIGHT };
        plan = plan.relit(scene, request, &limits)?;
        prepared.relight(&plan)?;
        prepared.draw(2)?;
    }
    Ok(renderer.device().objects_made() - made)
}

/// Frames in which light settles, and in which it goes out.
const FRAMES: i32 = 40;

/// R17: with a gather a frame light settles to that of all gathers, and what a lamp leaves that went out decays by the largest eigenvalue a frame.
fn feedback(renderer: &Renderer, scene: &mut Scene, rows: &mut Vec<Row>) -> Result<()> {
    scene.materials.iter_mut().for_each(|material| material.emissive = [0.0; 3]);
    let bake: &Arc<Bake> = &baked(scene, 150, CodecName::ZeroBlock)?;
    let limits = renderer.limits();
    let gathering = Gathering { feedback: true, ..Gathering::default() };
    let base = request(bake, Technique::Forward);
    let moving = Request { lights_move: true, shadow_size: 256, gi: Gi::Radiosity(gathering), ..base.clone() };
    let exact = Gathering { tolerance: 1e-6, ..Gathering::default() };
    let settled = Request { gi: Gi::Radiosity(exact), lights_move: true, shadow_size: 256, ..base };
    scene.lights[0].direction = toward(0.0);
    scene.lights[1].intensity = BRIGHT;
    let mut plan = Plan::new(scene, &moving, &limits)?;
    let mut prepared = renderer.prepare_frame(scene, &plan, passes::patch_frame(&plan))?;
    prepared.draw(FRAMES as usize)?;
    let bright = irradiance(&mut prepared)?;
    let right = {
        let plan = Plan::new(scene, &settled, &limits)?;
        let mut prepared = renderer.prepare_frame(scene, &plan, passes::patch_frame(&plan))?;
        prepared.draw(1)?;
        irradiance(&mut prepared)?
    };
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| -> Vec<[f64; 3]> {
        a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect()
    };
    let norm = |light: &[[f64; 3]]| -> f64 {
        let of = |(e, patch): (&[f64; 3], &Patch)| -> f64 {
            (0..3).map(|c| e[c] * e[c] * patch.reflectance[c] * patch.area).sum()
        };
        light.iter().zip(&bake.patches.list).map(of).sum::<f64>().sqrt()
    };
    let off = norm(&apart(&bright, &right)) / norm(&right);
    rows.push(Row::at_most("light that settles over 40 frames against all gathers", off, 1e-4));
    // Under no light at all.
    for light in &mut scene.lights {
        light.intensity = 0.0;
    }
    plan = plan.relit(scene, &moving, &limits)?;
    prepared.relight_frame(&plan, passes::patch_frame(&plan))?;
    let (mut before, mut worst, mut last) = (norm(&bright), 0f64, f64::NAN);
    for _ in 0..FRAMES / 2 {
        prepared.draw(1)?;
        last = norm(&irradiance(&mut prepared)?);
        worst = worst.max(last / before);
        before = last;
    }
    rows.push(Row::at_most("R17 light that went out, a frame", worst, bake.spectrum.largest * 1.001));
    rows.push(Row::at_most(
        "R17 light of 10,000 candela after 20 dark frames",
        last / norm(&bright),
        bake.spectrum.largest.powi(FRAMES / 2) * 1.01,
    ));
    // Light that passes all numbers is gone when its lamp is.
    for intensity in [3e38, 0.0] {
        scene.lights[1].intensity = intensity;
        plan = plan.relit(scene, &moving, &limits)?;
        prepared.relight_frame(&plan, passes::patch_frame(&plan))?;
        prepared.draw(2)?;
    }
    let left = irradiance(&mut prepared)?;
    let broken = left.iter().flatten().filter(|x| !x.is_finite()).count();
    rows.push(Row::none("R17 a lamp of 3e38 candela that went out", broken, "numbers are none"));
    rows.push(Row::none("light that settles: every access ordered", prepared.check().len(), "not ordered"));
    Ok(())
}

/// Lux by patch.
fn irradiance(prepared: &mut Prepared) -> Result<Vec<[f64; 3]>> {
    let picture = prepared.read_back()?;
    let values = picture.layer("patch_light").ok_or_else(|| Error::new("no light of patches was read back"))?;
    Ok(values.chunks_exact(16).map(|p| std::array::from_fn(|c| f64::from(p[c]))).collect())
}

/// Columns whose light changed, added to what is known, come to what is gathered afresh.
fn columns(renderer: &Renderer, rows: &mut Vec<Row>) -> Result<()> {
    let limits = renderer.limits();
    let mut scene = fixture()?;
    let exchange = Exchange::of_scene(&scene, &Settings::of_count(150))?;
    for codec in [CodecName::Bc1, CodecName::DenseF16, CodecName::Thesis, CodecName::Bc4Chroma] {
        let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(codec))?);
        let moving = Request { lights_move: true, shadow_size: 256, ..request(&bake, Technique::Forward) };
        scene.lights[0].direction = toward(0.0);
        scene.lights[1].intensity = 20.0;
        let mut plan = Plan::new(&scene, &moving, &limits)?;
        let mut prepared = renderer.prepare_frame(&scene, &plan, passes::patch_frame(&plan))?;
        prepared.draw(1)?;
        let (mut worst, mut afresh, mut moved) = (0f64, 0, 0f64);
        let first = irradiance(&mut prepared)?;
        for (turn, intensity) in [(0.0, 10.0), (0.3, 10.0), (0.3, 0.0), (0.3, 5.0), (0.9, 5.0), (0.9, 5.0)] {
            scene.lights[0].direction = toward(turn);
            scene.lights[1].intensity = intensity;
            plan = plan.relit(&scene, &moving, &limits)?;
            afresh += usize::from(plan.bounced.as_ref().is_none_or(|bounced| bounced.afresh));
            prepared.relight_frame(&plan, passes::patch_frame(&plan))?;
            prepared.draw(1)?;
            let found = irradiance(&mut prepared)?;
            let right = {
                let plan = Plan::new(&scene, &moving, &limits)?;
                let mut anew = renderer.prepare_frame(&scene, &plan, passes::patch_frame(&plan))?;
                anew.draw(1)?;
                irradiance(&mut anew)?
            };
            let most = right.iter().flatten().fold(0f64, |most, x| most.max(*x));
            let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
                a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs() / most).fold(0f64, f64::max)
            };
            worst = worst.max(apart(&found, &right));
            moved = moved.max(apart(&found, &first));
        }
        let name = codec.name();
        rows.push(Row::at_most(format!("columns that changed against all, {name}"), worst, 2e-6));
        // Once, where the lamp goes out.
        rows.push(Row::none(
            format!("columns that changed, {name}: afresh"),
            afresh.abs_diff(1),
            "times too often or too seldom",
        ));
        rows.push(Row::none(format!("columns that changed, {name}: light moves"), usize::from(moved < 0.01), "faults"));
    }
    Ok(())
}

/// What was not prepared for is refused, and the picture stays as it was.
fn refusals(renderer: &Renderer, scene: &mut Scene, bake: &Arc<Bake>) -> Result<Vec<Row>> {
    let limits = renderer.limits();
    let moving = Request { lights_move: true, shadow_size: 256, ..request(bake, Technique::TiledForward) };
    scene.lights[1].intensity = 0.0;
    let plan = Plan::new(scene, &moving, &limits)?;
    let mut prepared = renderer.prepare(scene, &plan)?;
    let dark = drawn(&mut prepared)?;
    scene.lights[1].intensity = BRIGHT;
    let lit = plan.relit(scene, &moving, &limits)?;
    let longer = prepared.relight(&lit).err().map(|error| error.to_string()).unwrap_or_default();
    let same = drawn(&mut prepared)? == dark;
    let other = lit.relit(scene, &Request { width: 32, ..moving.clone() }, &limits).is_err();
    let still = Plan::new(scene, &Request { lights_move: false, ..moving }, &limits)?;
    let fixed = renderer.prepare(scene, &still)?.relight(&still).is_err();
    Ok(vec![
        Row::none(
            "a lamp that lists have no room for is refused",
            usize::from(!longer.contains("bytes where")),
            "faults",
        ),
        Row::none("after that the picture is as it was", usize::from(!same), "pictures differ"),
        Row::none("another size, or lights that do not move, are refused", usize::from(!other || !fixed), "faults"),
    ])
}
