//! Shadow maps against rays: how many pixels are lit wrongly, light that must not leak, surfaces that must not shade themselves, and techniques
//! against each other.

mod fixtures;
mod still;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::Row;
use super::lists::{differing, radiance, radiance_of};
use super::oracle::shader;
use super::textured;
use crate::error::{Error, Result};
use crate::graph::log::Event;
use crate::plan::{CameraChoice, Plan, Request, ShadowUpdate, Technique, TransparentBounds};
use crate::reference::render::Reference;
use crate::renderer::Renderer;
use crate::scene::{Light, LightKind, Scene, builtin, scatter};
use fixtures::{boxed_lamp, grazed_wall, lamp, light_on_wall, room_with, shaded_lamp, spot_over_blocks};

pub(super) use fixtures::mask_and_pane;
pub use still::shadows_still;

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (150, 85);

const FORWARD_ONES: [Technique; 2] = [Technique::TiledForward, Technique::ClusteredForward];

fn request(technique: Technique) -> Request {
    Request { width: SIZE.0, height: SIZE.1, technique, shadows: Some(16), ..crate::checks::forward() }
}

fn value(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

/// What a picture of one light says of that light's way to each pixel, beside what rays say.
struct Seen {
    /// Shares of the light, 0 to 1, on the device and by rays, of pixels that the light could reach.
    shares: Vec<[f64; 2]>,
    /// Channels of pixels that are no number.
    broken: usize,
}

impl Seen {
    fn of(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Self> {
        let plan = Plan::new(scene, request, &renderer.limits())?;
        let drawn = radiance_of(renderer, scene, &plan)?;
        let without = radiance(renderer, scene, &Request { shadows: Some(0), ..request.clone() })?;
        let open_plan = Plan::new(scene, &Request { shadows: Some(0), ..request.clone() }, &renderer.limits())?;
        let reference = Reference::new(scene, &plan.view)?;
        let open = reference.render(&shader(&open_plan), &|_| {});
        let traced = reference.render(&shader(&plan), &|_| {});
        let emission = Reference::new(&dark(scene), &plan.view)?
            .render(&shader(&Plan { lighting: unlit(&plan), ..plan.clone() }), &|_| {});
        let mean = open.rgba.iter().map(|p| p[1]).sum::<f64>() / open.rgba.len() as f64;
        let mut shares = Vec::new();
        for (index, open) in open.rgba.iter().enumerate() {
            let (full, own) = (open[1] - emission.rgba[index][1], emission.rgba[index][1]);
            // Where ray and rasteriser meet two surfaces nothing is said of shadows.
            let same = (value(without[index * 4 + 1]) - open[1]).abs() <= 0.02 * open[1];
            if full > 1e-3 * mean && same {
                let share = |radiance: f64| (radiance - own) / full;
                shares.push([share(value(drawn[index * 4 + 1])), share(traced.rgba[index][1])]);
            }
        }
        Ok(Self { shares, broken: drawn.iter().filter(|bits| !value(**bits).is_finite()).count() })
    }

    /// Share of pixels that are lit where rays say shadow, or the other way round.
    fn wrong(&self) -> f64 {
        let wrong = self.shares.iter().filter(|[drawn, traced]| (drawn - traced).abs() > 0.5).count();
        wrong as f64 / self.shares.len().max(1) as f64
    }

    /// Pixels that light reaches on the device and not by rays.
    fn leaks(&self) -> usize {
        self.shares.iter().filter(|[drawn, traced]| *traced < 0.5 && drawn > &(traced + 1e-3)).count()
    }

    /// Pixels that rays find in the shadow.
    fn shaded(&self) -> usize {
        self.shares.iter().filter(|[_, traced]| *traced < 0.5).count()
    }
}

/// The scene without lights.
fn dark(scene: &Scene) -> Scene {
    Scene { lights: Vec::new(), ..scene.clone() }
}

fn unlit(plan: &Plan) -> crate::scene::lighting::Lighting {
    crate::scene::lighting::Lighting { lights: Vec::new(), ..plan.lighting.clone() }
}

/// Shares of pixels that are lit wrongly, by size and filter.
pub fn shadow_error(renderer: &Renderer) -> Result<Vec<Row>> {
    // Bounds are about twice what was measured on the worse of two drivers (docs/ACCURACY.md).
    let scenes = [
        ("cornell", builtin::load("cornell")?, [3e-3, 1.5e-3, 1.5e-3, 2e-3]),
        ("corridor", builtin::load("corridor")?, [3e-3, 1e-3, 1e-3, 1e-3]),
        ("terrain", builtin::load("terrain")?, [1.5e-2, 3e-3, 5e-3, 8e-3]),
        ("spot over blocks", spot_over_blocks(0.6), [5e-3, 1.5e-3, 3e-3, 3e-3]),
        ("mask and pane", mask_and_pane(), [5e-3, 2e-3, 1e-3, 1e-3]),
        ("lamp of huge range in a shade", shaded_lamp(), [1e-2, 3e-3, 3e-3, 5e-3]),
    ];
    let mut rows = Vec::new();
    for (name, scene, bounds) in &scenes {
        for ((size, filter), most) in [(256, 2), (1024, 0), (1024, 2), (1024, 4)].into_iter().zip(bounds) {
            let asked = Request { shadow_size: size, shadow_filter: filter, ..request(Technique::Forward) };
            let seen = Seen::of(renderer, scene, &asked)?;
            let row = format!("wrongly lit pixels, {name}, {size} texels, filter {filter}");
            rows.push(Row::at_most(row, seen.wrong(), *most));
            let none = usize::from(seen.shaded() < 20) + usize::from(seen.shares.len() < 2000) + seen.broken;
            rows.push(Row::none(
                format!("{name} has shadows, light and numbers, {size} texels, filter {filter}"),
                none,
                "faults",
            ));
        }
    }
    Ok(rows)
}

/// What is in nobody's way is lit as if there were no shadows, to the bit: flat walls under grazing light, and closed convex rooms.
pub fn shadow_acne(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut compare = |name: String, scene: &Scene, filter: u32, size: u32| -> Result<()> {
        let asked = Request { shadow_filter: filter, shadow_size: size, ..request(Technique::Forward) };
        let plan = Plan::new(scene, &asked, &renderer.limits())?;
        let with = radiance_of(renderer, scene, &plan)?;
        let without = radiance(renderer, scene, &Request { shadows: Some(0), ..asked })?;
        let mut wrong = differing(&with, &without);
        if plan.shadows.is_none() || without.iter().all(|bits| value(*bits) <= 0.0) {
            wrong = usize::MAX;
        }
        rows.push(Row::none(name, wrong, "pixels darker than without shadows"));
        Ok(())
    };
    for filter in [0, 1, 2, 3, 4, 8] {
        for degrees in [0.0, 45.0, 80.0, 89.0, 89.9] {
            for (kind, scene) in grazed_wall(degrees) {
                compare(format!("wall at {degrees} degrees, {kind}, filter {filter}"), &scene, filter, 512)?;
            }
        }
        for (at, position) in [("middle", [0.0, 0.0, 0.0]), ("corner", [1.9, -1.9, 1.9]), ("wall", [-1.99, 0.3, -0.4])]
        {
            let scene = room_with(lamp(DVec3::from_array(position)));
            compare(format!("furnace lit from its {at}, filter {filter}"), &scene, filter, 512)?;
        }
    }
    Ok(rows)
}

/// Light does not come through thin walls, and lights that stand in, at or behind something light what rays say.
pub fn shadow_leaks(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let closed = builtin::load("corridor:door=0")?;
    for (size, filter) in [(256, 0), (256, 1), (512, 2), (512, 3), (1024, 2), (1024, 4), (1024, 8)] {
        let camera = CameraChoice::Named("dark room".into());
        let asked = Request { camera, shadow_size: size, shadow_filter: filter, ..request(Technique::Forward) };
        let seen = Seen::of(renderer, &closed, &asked)?;
        let row = format!("light through the corridor's walls, {size} texels, filter {filter}");
        rows.push(Row::none(row, seen.leaks() + seen.broken, "pixels"));
    }
    for (name, scene) in
        [("in a closed box", boxed_lamp(0.0)), ("behind a box", boxed_lamp(1.2)), ("on a wall", light_on_wall())]
    {
        // A light on a wall shines past blocks that are in nobody's way.
        let [least, lit] = if name == "on a wall" { [0, 20] } else { [20, 100] };
        let seen = Seen::of(renderer, &scene, &request(Technique::Forward))?;
        rows.push(Row::at_most(format!("wrongly lit pixels, light {name}"), seen.wrong(), 5e-3));
        let faults = seen.broken + usize::from(seen.shaded() < least || seen.shares.len() < lit);
        rows.push(Row::none(format!("finite, and something in the shadow, light {name}"), faults, "faults"));
    }
    let seen = Seen::of(renderer, &boxed_lamp(0.0), &request(Technique::Forward))?;
    rows.push(Row::none("light out of a closed box", seen.leaks(), "pixels"));
    Ok(rows)
}

/// L1: cones of every width.
pub fn shadow_cones(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for outer in [0.0, 1e-4, 0.5f64.to_radians(), 0.3, 59.9f64.to_radians(), 60.1f64.to_radians(), FRAC_PI_2, 2.1, PI] {
        let seen = Seen::of(renderer, &spot_over_blocks(outer), &request(Technique::Forward))?;
        rows.push(Row::at_most(format!("L1 wrongly lit pixels, cone of {outer:.4} rad"), seen.wrong(), 4e-3));
        // Half a degree lights a few pixels.
        let dark = usize::from(outer > 0.1 && (seen.shares.len() < 100 || seen.shaded() < 20));
        let row = format!("L1 finite, and lit where it shines, cone of {outer:.4} rad");
        rows.push(Row::none(row, seen.broken + dark, "faults"));
    }
    Ok(rows)
}

/// Lights of every kind, all of which have shadows.
fn lit(mut scene: Scene, lights: usize) -> Scene {
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
    for (index, light) in scene.lights.iter_mut().enumerate() {
        light.direction = DVec3::new(0.3, -1.0, 0.2).normalize();
        match index % 4 {
            1 => light.kind = LightKind::Spot { inner: 0.4, outer: 0.9 },
            2 => light.kind = LightKind::Spot { inner: 0.4, outer: 1.4 },
            _ => {}
        }
    }
    let sun = Light { kind: LightKind::Directional, intensity: 1.0, range: None, ..scene.lights[0].clone() };
    scene.lights.push(sun);
    scene
}

/// Forward techniques draw the same bits, deferred ones the same as each other, blended receivers included.
pub fn shadow_agreement(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut scenes =
        vec![("atrium", lit(builtin::load("atrium")?, 24)), ("glass", lit(builtin::load("glass:layers=3")?, 16))];
    scenes.extend(textured::mixed().into_iter().take(1).map(|(name, scene)| (name, lit(scene, 8))));
    let four = renderer.limits().samples.iter().all(|bits| bits & 4 != 0);
    let mut rows = Vec::new();
    for (index, (name, scene)) in scenes.iter().enumerate() {
        let whole = index < 2;
        for msaa in if four && whole { vec![1, 4] } else { vec![1] } {
            let of = |technique| Request { shadow_size: 128, msaa, strict: true, ..request(technique) };
            let forward = radiance(renderer, scene, &of(Technique::Forward))?;
            let open = radiance(renderer, scene, &Request { shadows: Some(0), ..of(Technique::Forward) })?;
            let changed = differing(&forward, &open);
            // The last is two surfaces side by side, and lights in their plane.
            if whole {
                rows.push(Row {
                    name: format!("shadows change the picture, {name}, {msaa} samples"),
                    passed: changed > 0 && changed != usize::MAX,
                    detail: format!("{changed} pixels differ from those without"),
                });
            }
            for technique in FORWARD_ONES {
                let found = radiance(renderer, scene, &of(technique))?;
                let row = format!("{} = forward, shadows, {name}, {msaa} samples", technique.name());
                rows.push(Row::none(row, differing(&forward, &found), "differing pixels"));
            }
            let first = radiance(renderer, scene, &of(Technique::TiledDeferred))?;
            if msaa == 1 {
                let row = format!("pixels of tiled-deferred that differ from forward, shadows, {name}");
                rows.push(Row::at_most(row, apart(&forward, &first), 0.02));
            }
            for technique in [Technique::Deferred, Technique::ClusteredDeferred] {
                let found = radiance(renderer, scene, &of(technique))?;
                let row = format!("{} = tiled-deferred, shadows, {name}, {msaa} samples", technique.name());
                rows.push(Row::none(row, differing(&first, &found), "differing pixels"));
            }
        }
    }
    let merged = Request {
        transparent_bounds: Some(TransparentBounds::Merged),
        shadow_size: 128,
        ..request(Technique::TiledForward)
    };
    let each = Request { shadow_update: ShadowUpdate::Frame, ..merged.clone() };
    let glass = &scenes[1].1;
    let [once, each] = [radiance(renderer, glass, &merged)?, radiance(renderer, glass, &each)?];
    let own = radiance(renderer, glass, &Request { transparent_bounds: None, ..merged })?;
    rows.push(Row::none("merged bounds = own bounds, shadows, glass", differing(&own, &once), "differing pixels"));
    rows.push(Row::none("maps drawn once = in each frame, glass", differing(&once, &each), "differing pixels"));
    Ok(rows)
}

/// Which maps there are, when they are drawn and what into, on the device: a light that reaches nothing that is seen has none, a side of a cube that
/// looks away from what is seen is left out, and what is drawn once is in no frame.
pub fn shadow_maps(renderer: &Renderer) -> Result<Vec<Row>> {
    let limits = renderer.limits();
    let mut scene = spot_over_blocks(0.6);
    let away = Light { position: DVec3::new(0.0, 0.0, 400.0), ..lamp(DVec3::ZERO) };
    // Behind the eye, close enough to reach.
    let behind = lamp(DVec3::new(1.5, 2.0, 12.0));
    scene.lights.extend([away, behind]);
    scene.lights.iter_mut().for_each(|light| light.shadow = true);
    let asked = Request { shadows: None, shadow_size: 128, ..request(Technique::Forward) };
    let plan = Plan::new(&scene, &asked, &limits)?;
    let none = || Error::new("the plan has no shadows");
    let shadows = plan.shadows.as_ref().ok_or_else(none)?;
    let mut rows = vec![
        Row {
            name: "a light that reaches nothing that is seen has no map".into(),
            passed: shadows.lights.len() == 2,
            detail: format!("{} of 3 lights have maps", shadows.lights.len()),
        },
        Row {
            name: "sides of a cube that look away have none".into(),
            passed: shadows.drawn() < shadows.maps.len() && shadows.drawn() >= 2,
            detail: format!("{} of {} maps", shadows.drawn(), shadows.maps.len()),
        },
    ];
    for (update, repeated) in [(ShadowUpdate::Once, 0), (ShadowUpdate::Frame, 1)] {
        let plan = Plan::new(&scene, &Request { shadow_update: update, ..asked.clone() }, &limits)?;
        let mut prepared = renderer.prepare(&scene, &plan)?;
        prepared.draw(3)?;
        let (log, times) = (prepared.log().to_vec(), prepared.draw(2)?);
        let drawn = |event: &&Event| matches!(event, Event::Access(a) if a.node == "shadow_map" && a.what == "depth");
        let count = log.iter().filter(drawn).count();
        let timed = times.nodes().iter().filter(|(name, _)| *name == "shadow_map").count();
        let (_, violations) = prepared.finish()?;
        rows.push(Row {
            name: format!("maps are drawn {} in three frames", if repeated == 0 { "once" } else { "three times" }),
            passed: count == 1 + 2 * repeated && timed == repeated && violations.is_empty(),
            detail: format!("{count} times, {timed} a frame afterwards, {} barriers missing", violations.len()),
        });
    }
    Ok(rows)
}

/// Share of pixels that differ by more than a hundredth of the mean.
fn apart(a: &[u32], b: &[u32]) -> f64 {
    let mean = a.iter().map(|bits| value(*bits)).sum::<f64>() / a.len() as f64;
    let differs =
        |(p, q): &(&[u32], &[u32])| p.iter().zip(*q).any(|(p, q)| (value(*p) - value(*q)).abs() > 0.01 * mean);
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(differs).count() as f64 / (a.len() / 4) as f64
}
