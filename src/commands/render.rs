//! `render`: plan, draw or trace, measure, write.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::{plan, report, setup};
use crate::cli::{Cli, Command, Render, TonemapArg};
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::measure::exposure::{self, Tonemap};
use crate::measure::file;
use crate::measure::picture::Picture;
use crate::measure::times::FrameTimes;
use crate::measure::views;
use crate::passes;
use crate::plan::{DebugView, Plan, Technique};
use crate::reference::render::Reference;
use crate::reference::shade::Shader;
use crate::renderer::Renderer;
use crate::scene::Scene;

/// Frames drawn before any is timed: the first makes drivers compile, the second fills both frames in flight.
const WARM_UP: usize = 2;

/// What drawing or tracing gave.
struct Outcome {
    picture: Picture,
    times: FrameTimes,
    device: Value,
    driver_line: String,
    first_frame_ms: f64,
    pipelines_ms: f64,
    upload_ms: f64,
    memory_bytes: u64,
    memory: Vec<(String, u64)>,
    validation: Option<Vec<String>>,
}

/// Runs the command.
///
/// # Errors
/// One sentence; nothing is left half-written.
pub fn run(args: Render, started: Instant) -> Result<ExitCode> {
    match &args.from {
        Some(file) => {
            let (old, typed) = repeated(&args, file)?;
            // What is wrong then is the file's fault, not the command line's.
            run_typed(old, typed, started).map_err(|e| Error::new(format!("{}: {e}", file.display())))
        }
        None => run_typed(args, typed_arguments(), started),
    }
}

fn run_typed(args: Render, typed: Vec<String>, started: Instant) -> Result<ExitCode> {
    let kind = output_kind(&args.output)?;
    if let Some(path) = args.json.as_deref().filter(|p| *p != Path::new("-")) {
        file::check_place(path)?;
    }
    let ev = exposure_of(&args.exposure)?;
    let request = setup::request(&args.shared)?;
    let scene = setup::scene(&args.scene, &args.shared)?;
    let renderer = if request.technique == Technique::Reference {
        None
    } else {
        let options = Options { validate: args.validate, driver: args.shared.driver.clone() };
        Some(Renderer::new(&options)?)
    };
    let limits = setup::limits(&args.shared, renderer.as_ref());
    let planned = Plan::new(&scene, &request, &limits)?;
    let outcome = match &renderer {
        Some(renderer) => draw(renderer, &scene, &planned, &args, started)?,
        None => trace(&scene, &planned, started)?,
    };
    let main = main_layer(&outcome.picture, &planned)?;
    let automatic = exposure::automatic_ev(&main.pixels);
    let ev_used = ev.unwrap_or(automatic);
    let fingerprint = scene.fingerprint();
    let notes = provenance(&typed, &outcome, &fingerprint, &args);
    write_picture(&args, kind, &planned, &outcome, &main.pixels, (ev_used, &notes))?;
    let failed = outcome.validation.as_ref().is_some_and(|m| !m.is_empty());
    let quiet = report::json_on_stdout(args.json.as_deref());
    if !quiet {
        let mut said = text(&args, &scene, &planned, &outcome, (ev_used, ev.is_none()));
        if let Some([low, high]) = main.range {
            said += &format!("colours   {low:.4} (first) to {high:.4} (last)\n");
        }
        report::print(&said)?;
    }
    if let Some(path) = &args.json {
        report::write_json(path, &machine_form(&args, &scene, &planned, &outcome, (ev_used, &fingerprint)))?;
    }
    if failed {
        let count = outcome.validation.as_ref().map_or(0, Vec::len);
        let first = outcome.validation.as_ref().and_then(|m| m.first()).cloned().unwrap_or_default();
        return Err(Error::new(format!("validation found {count} messages, the first: {first}")));
    }
    Ok(ExitCode::SUCCESS)
}

fn typed_arguments() -> Vec<String> {
    // A file name need not be Unicode; it is stored as it is shown.
    let typed: Vec<String> = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    if typed.is_empty() { vec!["render".into()] } else { typed }
}

/// Arguments stored in an earlier picture, with this run's output, JSON and validation in their place.
fn repeated(args: &Render, file: &Path) -> Result<(Render, Vec<String>)> {
    let refuse = |why: &str| Error::new(format!("{}: {why}", file.display()));
    let bytes = std::fs::read(file).map_err(|e| refuse(&format!("could not be read: {e}")))?;
    let notes = if bytes.starts_with(b"\x89PNG") { file::png_text(&bytes) } else { file::exr_text(&bytes) };
    let stored = notes.iter().find(|n| n.0 == "lampyris arguments");
    let stored = stored.ok_or_else(|| refuse("does not say how it was made"))?;
    let typed: Vec<String> =
        serde_json::from_str(&stored.1).map_err(|_| refuse("says how it was made in a form that is not understood"))?;
    let parsed = Cli::try_parse_from(std::iter::once("lampyris".to_string()).chain(typed.clone()));
    let Ok(Cli { command: Some(Command::Render(mut old)) }) = parsed else {
        return Err(refuse("was made with arguments that this version does not understand"));
    };
    old.output.clone_from(&args.output);
    old.json.clone_from(&args.json);
    old.validate = args.validate;
    old.from = None;
    if args.shared.driver.is_some() {
        old.shared.driver.clone_from(&args.shared.driver);
    }
    Ok((old, typed))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum OutputKind {
    Png,
    Exr,
}

fn output_kind(path: &Path) -> Result<OutputKind> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    let kind = match extension.as_deref() {
        Some("png") => OutputKind::Png,
        Some("exr") => OutputKind::Exr,
        _ => return Err(Error::usage(format!("{}: a picture ends in .png or .exr", path.display()))),
    };
    // Said before the work, not after it.
    file::check_place(path)?;
    Ok(kind)
}

fn exposure_of(text: &str) -> Result<Option<f64>> {
    if text == "auto" {
        return Ok(None);
    }
    match text.parse::<f64>() {
        Ok(ev) if ev.is_finite() && ev.abs() <= 60.0 => Ok(Some(ev)),
        _ => Err(Error::usage(format!("--exposure {text} is neither auto nor a number of stops from -60 to 60"))),
    }
}

fn tonemap(arg: TonemapArg) -> Tonemap {
    match arg {
        TonemapArg::None => Tonemap::None,
        TonemapArg::Aces => Tonemap::Aces,
        TonemapArg::Neutral => Tonemap::Neutral,
    }
}

fn draw(renderer: &Renderer, scene: &Scene, plan: &Plan, args: &Render, started: Instant) -> Result<Outcome> {
    let mut prepared = renderer.prepare(scene, plan)?;
    prepared.draw(1)?;
    let first_frame_ms = started.elapsed().as_secs_f64() * 1e3;
    prepared.draw(WARM_UP - 1)?;
    let times = prepared.draw(args.frames as usize)?;
    let mut picture = prepared.read_back()?;
    let accounts = renderer.device().accounts.lock().map(|a| a.clone()).unwrap_or_default();
    let mut violations: Vec<String> = Vec::new();
    if args.validate {
        violations.extend(prepared.check().iter().map(|v| format!("checker: {v}")));
    }
    if args.layers && plan.debug_view.is_none() {
        drop(prepared);
        let mut probe = renderer.prepare_frame(scene, plan, passes::surface_frame(plan))?;
        probe.draw(1)?;
        for (name, values) in probe.read_back()?.layers {
            if picture.layer(&name).is_none() {
                picture.add_layer(&name, values);
            }
        }
        return Ok(outcome(
            renderer,
            picture,
            times,
            (first_frame_ms, probe.pipelines_ms, probe.upload_ms),
            accounts,
            violations,
            args,
        ));
    }
    let startup = (first_frame_ms, prepared.pipelines_ms, prepared.upload_ms);
    drop(prepared);
    Ok(outcome(renderer, picture, times, startup, accounts, violations, args))
}

fn outcome(
    renderer: &Renderer,
    picture: Picture,
    times: FrameTimes,
    (first_frame_ms, pipelines_ms, upload_ms): (f64, f64, f64),
    accounts: crate::gpu::memory::Accounts,
    mut violations: Vec<String>,
    args: &Render,
) -> Outcome {
    violations.extend(renderer.take_messages());
    let facts = &renderer.device().facts;
    Outcome {
        picture,
        times,
        device: report::device_json(facts),
        driver_line: report::device_line(facts),
        first_frame_ms,
        pipelines_ms,
        upload_ms,
        memory_bytes: accounts.peak,
        memory: accounts.live.into_iter().collect(),
        validation: args.validate.then_some(violations),
    }
}

/// A progress bar on a terminal, nothing in a pipe.
fn progress(total: u64, what: &'static str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar
}

fn trace(scene: &Scene, plan: &Plan, started: Instant) -> Result<Outcome> {
    let reference = Reference::new(scene, &plan.view)?;
    let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
    let bar = progress(u64::from(plan.view.height), "tracing rows");
    let start = Instant::now();
    let traced = reference.render(&shader, &|rows| bar.set_position(rows));
    let wall = start.elapsed().as_secs_f64() * 1e3;
    bar.finish_and_clear();
    let mut picture = Picture::new(traced.width, traced.height);
    picture.add_layer("radiance", traced.rgba.iter().flatten().map(|&x| x as f32).collect());
    let depth = traced.depth.iter().map(|&z| if z.is_finite() { z as f32 } else { f32::INFINITY });
    picture.add_layer("distance", depth.collect());
    Ok(Outcome {
        picture,
        times: FrameTimes::new(Vec::new(), vec![wall], vec![Vec::new()]),
        device: json!({ "name": "CPU", "driver": "reference, f64", "api": null, "kind": "cpu" }),
        driver_line: "CPU reference, f64".into(),
        first_frame_ms: started.elapsed().as_secs_f64() * 1e3,
        pipelines_ms: 0.0,
        upload_ms: 0.0,
        memory_bytes: 0,
        memory: Vec::new(),
        validation: None,
    })
}

fn main_layer(picture: &Picture, plan: &Plan) -> Result<views::Shown> {
    match plan.debug_view {
        Some(view) if plan.technique != Technique::Reference => views::draw(picture, shown(view)),
        Some(_) => Err(Error::usage("--debug-view shows what a device draws; --technique reference has no such views")),
        None => {
            let pixels = picture.rgba("radiance").ok_or_else(|| Error::new("the frame has no radiance to show"))?;
            Ok(views::Shown { pixels, range: None })
        }
    }
}

fn shown(view: DebugView) -> views::View {
    match view {
        DebugView::Albedo => views::View::Color("base_metallic"),
        DebugView::Normals => views::View::Direction("normal_occlusion"),
        DebugView::Depth => views::View::Distance("position_roughness"),
        DebugView::DepthRaw => views::View::Raw("depth"),
    }
}

fn provenance(typed: &[String], outcome: &Outcome, fingerprint: &str, args: &Render) -> Vec<(String, String)> {
    let entry = |key: &str, value: String| (format!("lampyris {key}"), value);
    vec![
        entry("version", env!("CARGO_PKG_VERSION").into()),
        entry("arguments", serde_json::to_string(typed).unwrap_or_default()),
        entry("device", outcome.driver_line.clone()),
        entry("scene", format!("{} {fingerprint}", args.scene)),
        entry("light seed", args.shared.light_seed.to_string()),
    ]
}

fn write_picture(
    args: &Render,
    kind: OutputKind,
    plan: &Plan,
    outcome: &Outcome,
    main: &[[f32; 4]],
    (ev, notes): (f64, &[(String, String)]),
) -> Result<()> {
    let size = [plan.view.width, plan.view.height];
    match (kind, plan.debug_view) {
        (OutputKind::Png, Some(_)) => {
            file::write_png(&args.output, size, &exposure::display(main, 0.0, Tonemap::None), notes)
        }
        (OutputKind::Png, None) => {
            file::write_png(&args.output, size, &exposure::display(main, ev, tonemap(args.tonemap)), notes)
        }
        (OutputKind::Exr, _) => {
            let mut layers = vec!["radiance"];
            if args.layers || plan.debug_view.is_some() {
                layers.extend(outcome.picture.layers.iter().map(|l| l.0.as_str()).filter(|n| *n != "radiance"));
            }
            file::write_exr(&args.output, &outcome.picture, &layers, notes)
        }
    }
}

fn text(args: &Render, scene: &Scene, plan: &Plan, outcome: &Outcome, (ev, automatic): (f64, bool)) -> String {
    let mut out = format!("device    {}\n", outcome.driver_line);
    out += &plan::summary(scene, plan);
    let frame = outcome.times.frame();
    if plan.technique == Technique::Reference {
        out += &format!("traced    {:.2} s\n", frame.median / 1e3);
    } else {
        out += &format!(
            "frame     {:.2} ms median of {} ({:.2} to {:.2})\n",
            frame.median, args.frames, frame.min, frame.max
        );
        for (name, ms) in outcome.times.nodes() {
            out += &match ms {
                Some(ms) => format!("  {name:<18} {ms:>9.3} ms\n"),
                None => format!("  {name:<18}   (no timestamps)\n"),
            };
        }
        out += &format!(
            "start     first frame after {:.0} ms, of which pipelines {:.0} ms and upload {:.0} ms\n",
            outcome.first_frame_ms, outcome.pipelines_ms, outcome.upload_ms
        );
        out += &format!("memory    {} on the device at most\n", report::bytes(outcome.memory_bytes));
    }
    if let Some(complaint) = outcome.times.complaint() {
        out += &format!("note      {complaint}\n");
    }
    if let Some(note) = clamped_note(outcome) {
        out += &format!("note      {note}\n");
    }
    if plan.debug_view.is_none() {
        let how = if automatic { "automatic" } else { "as asked" };
        out += &format!("exposure  {ev:+.2} EV, {how}; tone curve {}\n", tonemap(args.tonemap).name());
    }
    if let Some(messages) = &outcome.validation {
        out += &format!("validation  {} messages\n", messages.len());
        for message in messages {
            out += &format!("  {message}\n");
        }
    }
    out + &format!("picture   {}\n", args.output.display())
}

/// L9 of the hard cases: radiance past f32 is clamped once, and said.
fn clamped_note(outcome: &Outcome) -> Option<String> {
    let values = outcome.picture.layer("radiance")?;
    let clamped = values.chunks_exact(4).filter(|p| p[..3].iter().any(|c| *c >= f32::MAX)).count();
    (clamped > 0)
        .then(|| format!("the radiance of {clamped} pixels passes 32-bit floats and is clamped to their largest"))
}

fn machine_form(args: &Render, scene: &Scene, plan: &Plan, outcome: &Outcome, (ev, fingerprint): (f64, &str)) -> Value {
    let frame = outcome.times.frame();
    let passes: Vec<_> =
        outcome.times.nodes().into_iter().map(|(name, gpu_ms)| json!({ "name": name, "gpu_ms": gpu_ms })).collect();
    let lit_pairs = u64::from(plan.lights.count) * plan.pixels();
    let memory: serde_json::Map<String, Value> =
        outcome.memory.iter().map(|(name, bytes)| (name.clone(), json!(bytes))).collect();
    json!({
        "schema": report::SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "device": outcome.device,
        "scene": plan::scene_json(&args.scene, scene, fingerprint),
        "plan": plan::plan_json(plan),
        "passes": passes,
        "frame_ms": { "median": frame.median, "min": frame.min, "max": frame.max, "frames": outcome.times.wall_ms.len() },
        "startup_ms": { "pipelines": outcome.pipelines_ms, "upload": outcome.upload_ms, "first_frame": outcome.first_frame_ms },
        "memory_bytes": outcome.memory_bytes,
        "memory": memory,
        "counters": { "light_evaluations": lit_pairs, "lists_overflowed": 0 },
        "exposure_ev": ev,
        "notes": plan.notes.iter().chain(&scene.warnings).cloned().chain(clamped_note(outcome)).collect::<Vec<_>>(),
        "output": args.output.display().to_string(),
        "validation": {
            "enabled": outcome.validation.is_some(),
            "messages": outcome.validation.as_ref().map_or(0, Vec::len),
        },
    })
}
