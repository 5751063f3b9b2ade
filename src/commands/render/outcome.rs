//! What drawing or tracing gives: the picture, its times, the memory it took.

use std::time::Instant;

use serde_json::{Value, json};

use super::{gbuffer, lists};
use crate::cli::Render;
use crate::commands::{measured, report};
use crate::error::Result;
use crate::lists::Counters;
use crate::measure::memory::ProcessMemory;
use crate::measure::picture::Picture;
use crate::measure::times::FrameTimes;
use crate::passes;
use crate::plan::{Gi, Plan};
use crate::reference::render::{Paths, Reference};
use crate::reference::shade::Shader;
use crate::renderer::Renderer;
use crate::scene::Scene;

/// Frames drawn before any is timed: the first makes drivers compile, the second fills both frames in flight.
const WARM_UP: usize = 2;

/// What drawing or tracing gave.
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) picture: Picture,
    pub(super) times: FrameTimes,
    pub(super) device: Value,
    pub(super) driver_line: String,
    pub(super) first_frame_ms: f64,
    pub(super) pipelines_ms: f64,
    pub(super) upload_ms: f64,
    /// Of what is drawn once, before the first frame; 0 where nothing is.
    pub(super) once_ms: f64,
    /// Most bytes of device memory at once.
    pub(super) memory_bytes: u64,
    /// Device bytes by resource, while everything was there.
    pub(super) memory: Vec<(String, u64)>,
    /// `None` without `--counters`.
    pub(super) counters: Option<Counters>,
    /// `None` without `--validate`.
    pub(super) validation: Option<Vec<String>>,
    pub(super) process: ProcessMemory,
    /// `None` where no paths were traced.
    pub(super) bounced: Option<TracedPaths>,
}

/// What tracing bounced light gave beside the picture.
pub(super) struct TracedPaths {
    /// Of the picture of bounced light; `None` of a single path.
    pub(super) standard_error: Option<f64>,
    pub(super) ms: f64,
}

/// When the process began, and its memory so far.
pub(super) type Watch = (Instant, ProcessMemory);

/// Draws on the device.
pub(super) fn draw(
    renderer: &Renderer,
    scene: &Scene,
    plan: &Plan,
    args: &Render,
    (started, mut process): Watch,
) -> Result<Outcome> {
    let facts = &renderer.device().facts;
    let mut outcome = Outcome { device: report::device_json(facts), driver_line: facts.line(), ..Outcome::default() };
    let mut prepared = renderer.prepare(scene, plan)?;
    process.stage("pipelines and uploads");
    prepared.draw(1)?;
    outcome.first_frame_ms = started.elapsed().as_secs_f64() * 1e3;
    (outcome.pipelines_ms, outcome.upload_ms) = (prepared.pipelines_ms, prepared.upload_ms);
    outcome.once_ms = prepared.once_ms;
    prepared.draw(WARM_UP - 1)?;
    outcome.times = prepared.draw(args.frames as usize)?;
    process.stage("frames");
    let accounts = renderer.device().accounts.lock().map(|a| a.clone()).unwrap_or_default();
    outcome.memory_bytes = accounts.peak;
    outcome.memory = accounts.at_peak.into_iter().collect();
    let (picture, found) = prepared.finish()?;
    outcome.picture = picture;
    process.stage("read-back");
    drop(prepared);
    let mut violations: Vec<String> = Vec::new();
    if args.validate {
        violations.extend(found.iter().map(|v| format!("checker: {v}")));
    }
    let found = lists::look(renderer, scene, plan, args.counters, &mut outcome.picture)?;
    outcome.counters = found.counters;
    let of_gbuffer = gbuffer::look(renderer, scene, plan, &mut outcome.picture)?;
    if args.validate {
        violations.extend(found.violations.iter().chain(&of_gbuffer).map(|v| format!("checker: {v}")));
    }
    if args.layers && !plan.shows_surfaces() {
        let mut probe = renderer.prepare_frame(scene, plan, passes::surface_frame(plan))?;
        probe.draw(1)?;
        let (layers, found) = probe.finish()?;
        if args.validate {
            violations.extend(found.iter().map(|v| format!("checker: {v}")));
        }
        for (name, values) in layers.layers {
            outcome.picture.add_layer(&name, values);
        }
    }
    violations.extend(renderer.take_messages());
    outcome.validation = args.validate.then_some(violations);
    outcome.process = process;
    Ok(outcome)
}

/// Traces on the CPU.
pub(super) fn trace(scene: &Scene, plan: &Plan, (started, mut process): Watch) -> Result<Outcome> {
    let reference = Reference::new(scene, &plan.view)?.of_samples(plan.samples);
    let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
    let bar = measured::progress(u64::from(plan.view.height), "tracing rows");
    let start = Instant::now();
    let traced = reference.render(&shader, &|rows| bar.set_position(rows));
    let wall = start.elapsed().as_secs_f64() * 1e3;
    bar.finish_and_clear();
    let mut picture = Picture::new(traced.width, traced.height);
    let mut bounced = None;
    let mut rgba = traced.rgba;
    if let Gi::Path { paths, seed } = plan.gi {
        let bar = measured::progress(u64::from(plan.view.height), "tracing paths");
        let start = Instant::now();
        let found = reference.bounced(&shader, Paths { count: paths, seed }, &|rows| bar.set_position(rows));
        bar.finish_and_clear();
        picture.add_layer("direct", rgba.iter().flatten().map(|&x| x as f32).collect());
        let opaque = found.rgb.iter().zip(&rgba).flat_map(|(rgb, direct)| [rgb[0], rgb[1], rgb[2], direct[3]]);
        picture.add_layer("indirect", opaque.map(|x| x as f32).collect());
        for (pixel, added) in rgba.iter_mut().zip(&found.rgb) {
            (0..3).for_each(|channel| pixel[channel] += added[channel]);
        }
        bounced = Some(TracedPaths { standard_error: found.standard_error, ms: start.elapsed().as_secs_f64() * 1e3 });
    }
    picture.add_layer("radiance", rgba.iter().flatten().map(|&x| x as f32).collect());
    let depth = traced.depth.iter().map(|&z| if z.is_finite() { z as f32 } else { f32::INFINITY });
    picture.add_layer("distance", depth.collect());
    process.stage("tracing");
    Ok(Outcome {
        picture,
        times: FrameTimes::new(Vec::new(), vec![wall], vec![Vec::new()]),
        device: json!({ "name": "CPU", "driver": "reference, f64", "api": null, "kind": "cpu" }),
        driver_line: "CPU reference, f64".into(),
        first_frame_ms: started.elapsed().as_secs_f64() * 1e3,
        bounced,
        process,
        ..Outcome::default()
    })
}
