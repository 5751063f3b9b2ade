//! `bench`: experiments. `ceiling` is a full-screen loop over N lights for each light fetch.

use std::process::ExitCode;

use serde_json::json;

use super::{report, setup};
use crate::cli::{Bench, BenchName};
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::measure::times::Spread;
use crate::passes::ceiling;
use crate::plan::{FetchChoice, Plan, Request};
use crate::renderer::{Prepared, Renderer};
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Bounds, Scene, scatter};

/// Frames of a `--quick` run.
const QUICK_FRAMES: u32 = 3;

/// Runs the experiment.
///
/// # Errors
/// No device, or a lost one.
pub fn run(args: &Bench) -> Result<ExitCode> {
    match args.name {
        BenchName::Ceiling => run_ceiling(args),
    }
}

struct Cell {
    lights: u32,
    fetch: &'static str,
    prepared: Prepared,
    ms: Vec<f64>,
}

fn run_ceiling(args: &Bench) -> Result<ExitCode> {
    let renderer = Renderer::new(&Options { validate: false, driver: args.driver.clone() })?;
    let frames = if args.quick { QUICK_FRAMES } else { args.frames.max(1) };
    let mut cells = Vec::new();
    for &lights in &args.lights {
        for (fetch, name) in
            [(FetchChoice::Storage, "storage"), (FetchChoice::Uniform, "uniform"), (FetchChoice::Texel, "texel")]
        {
            if let Some(cell) = cell(&renderer, args, lights, (fetch, name))? {
                cells.push(cell);
            }
        }
    }
    if cells.is_empty() {
        return Err(Error::usage("--lights: nothing to measure"));
    }
    // Interleaved: drift of the machine touches every cell alike.
    for round in 0..=frames {
        for cell in &mut cells {
            let times = cell.prepared.draw(1)?;
            let ms = times.nodes()[0].1.unwrap_or(times.frame().median);
            if round > 0 {
                cell.ms.push(ms);
            }
        }
    }
    let pixels = f64::from(args.size.0) * f64::from(args.size.1);
    let facts = &renderer.device().facts;
    let mut out = format!(
        "{} ({})\nfull-screen loop, {}x{}, {} shading, {frames} interleaved frames\n lights  fetch     ms (min to max)              million light-pixels/s\n",
        facts.name,
        facts.driver,
        args.size.0,
        args.size.1,
        setup::shading(args.shading).name()
    );
    let mut rows = Vec::new();
    for cell in &cells {
        let spread = Spread::of(&cell.ms);
        let rate = pixels * f64::from(cell.lights) / spread.median / 1e3;
        out += &format!(
            "{:>7}  {:<8} {:>8.2} ({:.2} to {:.2})   {rate:>10.0}\n",
            cell.lights, cell.fetch, spread.median, spread.min, spread.max
        );
        rows.push(json!({
            "lights": cell.lights, "fetch": cell.fetch, "ms": spread, "million_light_pixels_per_second": rate,
        }));
    }
    if !report::json_on_stdout(args.json.as_deref()) {
        report::print(&out)?;
    }
    if let Some(path) = &args.json {
        let value = json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "experiment": "ceiling",
            "device": report::device_json(facts),
            "width": args.size.0,
            "height": args.size.1,
            "shading": setup::shading(args.shading).name(),
            "rows": rows,
        });
        report::write_json(path, &value)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// One light count with one fetch; `None` where the lights do not fit that fetch.
fn cell(renderer: &Renderer, args: &Bench, lights: u32, fetch: (FetchChoice, &'static str)) -> Result<Option<Cell>> {
    // Lights between the camera and the wall of ceiling.frag, all of them reaching every pixel.
    let mut bounds = Bounds::EMPTY;
    bounds.include(glam::DVec3::new(-5.0, -5.0, -9.0));
    bounds.include(glam::DVec3::new(5.0, 5.0, -6.0));
    let mut scene = Scene { name: "ceiling".into(), ..Scene::default() };
    scene.lights = scatter::point_lights(&bounds, lights as usize, 1);
    scene.cameras.push(crate::scene::Camera::looking(glam::DVec3::ZERO, glam::DVec3::NEG_Z, 1.0));
    let request = Request {
        width: args.size.0,
        height: args.size.1,
        shading: setup::shading(args.shading),
        rules: LightRules { range: RangeRule::Infinite, ..LightRules::default() },
        fetch: fetch.0,
        ..Request::default()
    };
    let limits = renderer.limits();
    let fits = match fetch.0 {
        FetchChoice::Uniform => u64::from(lights) * 32 <= limits.max_uniform_bytes,
        FetchChoice::Texel => u64::from(lights) * 2 <= limits.max_texel_elements,
        _ => true,
    };
    if !fits {
        return Ok(None);
    }
    let plan = Plan::new(&scene, &request, &limits)?;
    let prepared = renderer.prepare_frame(&scene, &plan, ceiling::frame(&plan))?;
    Ok(Some(Cell { lights, fetch: fetch.1, prepared, ms: Vec::new() }))
}
