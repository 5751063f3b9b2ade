//! Very many lights on `builtin:terrain`, whose range shrinks so that as many reach each pixel: no pair is missed, pictures are those of
//! forward, and what that takes is said. `bench million` has the times.

use super::Row;
use super::lists::{bits_of_frame, differing};
use crate::error::Result;
use crate::lists;
use crate::plan::{Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Projection, Scene, builtin, scatter};

/// Pixels of the picture whose lists are judged.
const SIZE: (u32, u32) = (160, 90);

/// Pixels of its middle, which forward draws too: 1,000.
const MIDDLE: (u32, u32) = (40, 25);

/// Metres, and the lights that have it.
const RANGE: (f64, f64) = (10.0, 4096.0);

fn terrain(lights: u32) -> Result<Scene> {
    let mut scene = builtin::load("terrain")?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights as usize, 1);
    Ok(scene)
}

/// The scene with a camera that sees the middle of the picture alone, pixel for pixel at the same angles.
fn middle(mut scene: Scene) -> Scene {
    if let Some(Projection::Perspective { yfov, .. }) = scene.cameras.first_mut().map(|camera| &mut camera.projection) {
        *yfov = 2.0 * ((0.5 * *yfov).tan() * f64::from(MIDDLE.1) / f64::from(SIZE.1)).atan();
    }
    scene
}

fn request(technique: Technique, lights: u32, (width, height): (u32, u32)) -> Request {
    // Lights of a volume and the volume of a light: their product stays.
    let range = RANGE.0 * (RANGE.1 / f64::from(lights)).cbrt();
    let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
    Request { width, height, technique, rules, ..crate::checks::forward() }
}

/// Bytes of the device's memory that are in use.
fn device_bytes(renderer: &Renderer) -> u64 {
    renderer.device().accounts.lock().map(|accounts| accounts.total).unwrap_or_default()
}

/// Bits of a picture, and a sentence about what drawing it took.
fn drawn(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<(Vec<u32>, String)> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let before = device_bytes(renderer);
    let prepared = renderer.prepare(scene, &plan)?;
    let mebibytes = device_bytes(renderer).saturating_sub(before) as f64 / f64::from(1 << 20);
    let (name, passes) = (request.technique.name(), plan.light_parts.count);
    let said = format!("{name}: {passes} shading passes, {mebibytes:.1} MiB of device memory");
    Ok((bits_of_frame(prepared)?, said))
}

/// The device's lists of one technique against the f64 oracle.
fn judged(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Row> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let made = lists::make(renderer, scene, &plan)?;
    let counts = made.judge(&plan);
    let wrong = counts.missed_pairs + counts.unordered + counts.foreign + made.cells.overflowed();
    let name = format!("{} lights miss nothing, {}", plan.lights.count, request.technique.name());
    let mut row = Row::none(name, wrong as usize + made.violations.len(), "pairs");
    row.passed &= counts.exact_pairs > 0;
    row.detail += &format!(
        " of {}, {} listed, the longest list {}, waste_samples {:.3}",
        counts.exact_pairs,
        made.cells.light_pairs(),
        made.cells.longest_list(),
        counts.waste_samples()
    );
    Ok(row)
}

fn rows(renderer: &Renderer, lights: u32) -> Result<Vec<Row>> {
    let scene = terrain(lights)?;
    let of = |technique, size| request(technique, lights, size);
    let (tiled, clustered) = (Technique::TiledForward, Technique::ClusteredForward);
    let mut rows = vec![judged(renderer, &scene, &of(tiled, SIZE))?, judged(renderer, &scene, &of(clustered, SIZE))?];
    let (whole, of_whole) = drawn(renderer, &scene, &of(clustered, SIZE))?;
    let (other, of_other) = drawn(renderer, &scene, &of(tiled, SIZE))?;
    let name = format!("{lights} lights, clustered-forward = tiled-forward");
    rows.push(with(Row::none(name, differing(&whole, &other), "differing pixels"), &[of_whole, of_other]));
    let scene = middle(scene);
    let (forward, of_forward) = drawn(renderer, &scene, &of(Technique::Forward, MIDDLE))?;
    for technique in [clustered, tiled] {
        let (picture, said) = drawn(renderer, &scene, &of(technique, MIDDLE))?;
        let name = format!("{lights} lights, {} = forward, {} pixels", technique.name(), MIDDLE.0 * MIDDLE.1);
        let row = Row::none(name, differing(&forward, &picture), "differing pixels");
        rows.push(with(row, &[said, of_forward.clone()]));
    }
    Ok(rows)
}

fn with(mut row: Row, said: &[String]) -> Row {
    row.detail += &format!("; {}", said.join("; "));
    row
}

/// 65,536 lights.
pub fn many(renderer: &Renderer) -> Result<Vec<Row>> {
    rows(renderer, 65_536)
}

/// A million.
pub fn million(renderer: &Renderer) -> Result<Vec<Row>> {
    rows(renderer, 1_000_000)
}
