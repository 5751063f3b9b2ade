//! Pictures that have to be the same bit for bit on one driver.

use super::Row;
use crate::error::Result;
use crate::plan::{FetchChoice, Plan, Request};
use crate::renderer::Renderer;
use crate::scene::{Scene, builtin, scatter};

/// Pixels of the pictures that are compared.
const SIZE: (u32, u32) = (96, 54);

/// Scenes small enough to draw many times.
const SCENES: [&str; 3] = ["cornell", "corridor", "atrium"];

fn scene(name: &str) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), 24, 7);
    Ok(scene)
}

fn request() -> Request {
    Request { width: SIZE.0, height: SIZE.1, ..crate::checks::forward() }
}

/// Radiance of one frame, the log judged by the checker; violations count as differing pixels.
fn radiance(renderer: &Renderer, scene: &Scene, request: &Request, frames: usize) -> Result<(Vec<u32>, usize)> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let mut prepared = renderer.prepare(scene, &plan)?;
    prepared.draw(frames)?;
    let picture = prepared.read_back()?;
    let bits = picture.layer("radiance").unwrap_or(&[]).iter().map(|x| x.to_bits()).collect();
    Ok((bits, prepared.check().len()))
}

fn differing(a: &[u32], b: &[u32]) -> usize {
    if a.len() != b.len() || a.is_empty() {
        return usize::MAX;
    }
    a.chunks(4).zip(b.chunks(4)).filter(|(p, q)| p != q).count()
}

/// A depth pre-pass changes nothing.
pub fn prepass(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in SCENES {
        let scene = scene(name)?;
        let (with, a) = radiance(renderer, &scene, &request(), 1)?;
        let (without, b) = radiance(renderer, &scene, &Request { prepass: false, ..request() }, 1)?;
        rows.push(Row::none(format!("pre-pass on = off, {name}"), differing(&with, &without), "differing pixels"));
        rows.push(Row::none(format!("barriers proved, {name}"), a + b, "violations"));
    }
    Ok(rows)
}

/// How light data is read changes nothing.
pub fn fetch(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = scene("cornell")?;
    let storage = radiance(renderer, &scene, &Request { fetch: FetchChoice::Storage, ..request() }, 1)?.0;
    let mut rows = Vec::new();
    for (name, fetch) in [("uniform", FetchChoice::Uniform), ("texel", FetchChoice::Texel)] {
        let other = radiance(renderer, &scene, &Request { fetch, ..request() }, 1)?.0;
        rows.push(Row::none(format!("light fetch storage = {name}"), differing(&storage, &other), "differing pixels"));
    }
    Ok(rows)
}

/// C11: the first frame of a still scene equals the tenth.
pub fn still(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = scene("corridor")?;
    let first = radiance(renderer, &scene, &request(), 1)?.0;
    let (tenth, violations) = radiance(renderer, &scene, &request(), 10)?;
    Ok(vec![
        Row::none("C11 first frame = tenth", differing(&first, &tenth), "differing pixels"),
        Row::none("C11 barriers over ten frames proved", violations, "violations"),
    ])
}
