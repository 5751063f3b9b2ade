//! `render`: plan, draw or trace, measure, write.

mod gbuffer;
mod lists;
mod outcome;
mod said;

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;

use super::{report, setup};
use crate::cli::{Cli, Command, Render, TechniqueChoice, TonemapArg};
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::measure::exposure::{self, Tonemap};
use crate::measure::memory::ProcessMemory;
use crate::measure::picture::Picture;
use crate::measure::{file, views};
use crate::plan::{DebugView, Plan, Technique, estimate};
use crate::renderer::Renderer;
use outcome::{Outcome, draw, trace};

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
    let mut process = ProcessMemory::default();
    process.stage("program");
    let kind = output_kind(&args.output)?;
    if let Some(path) = args.json.as_deref().filter(|p| *p != Path::new("-")) {
        file::check_place(path)?;
        if path == args.output {
            return Err(Error::usage(format!("{}: picture and report cannot be one file", path.display())));
        }
    }
    check_options(&args, kind)?;
    let ev = exposure_of(&args.exposure)?;
    let (scene, request) = setup::scene_and_request(&args.scene, &args.shared)?;
    process.stage("scene");
    let renderer = if request.technique == Technique::Reference {
        None
    } else {
        let options = Options { validate: args.validate, driver: args.shared.driver.clone() };
        Some(Renderer::new(&options)?)
    };
    let limits = setup::limits(&args.shared, renderer.as_ref());
    process.stage("driver");
    let mut planned = Plan::new(&scene, &request, &limits)?;
    estimate(&mut planned, &scene, request.tile, &limits.profile.unwrap_or_default());
    let outcome = match &renderer {
        Some(renderer) => draw(renderer, &scene, &planned, &args, (started, process))?,
        None => trace(&scene, &planned, (started, process))?,
    };
    let automatic = outcome.picture.rgba("radiance").map_or(0.0, exposure::automatic_ev);
    let ev_used = ev.unwrap_or(automatic);
    let shown = planned.debug_view.map(|view| show(view, &args, &planned, &outcome.picture, ev_used)).transpose()?;
    let fingerprint = scene.fingerprint();
    let notes = said::provenance(&typed, &outcome, &fingerprint, &args);
    write_picture(&args, kind, &outcome, shown.as_ref(), (ev_used, &notes))?;
    let failed = outcome.validation.as_ref().is_some_and(|m| !m.is_empty());
    let quiet = report::json_on_stdout(args.json.as_deref());
    if !quiet {
        let mut said = said::text(&args, &scene, &planned, &outcome, (ev_used, ev.is_none()));
        if let Some(shown) = &shown {
            said += &format!("legend    {}\n", shown.legend.sentence());
        }
        report::print(&said)?;
    }
    if let Some(path) = &args.json {
        report::write_json(
            path,
            &said::machine_form((&args, &typed), &scene, &planned, &outcome, (ev_used, &fingerprint)),
        )?;
    }
    if failed {
        let count = outcome.validation.as_ref().map_or(0, Vec::len);
        let first = outcome.validation.as_ref().and_then(|m| m.first()).cloned().unwrap_or_default();
        return Err(Error::new(format!("validation found {count} messages, the first: {first}")));
    }
    Ok(ExitCode::SUCCESS)
}

/// Options that ask a technique or a file for what it does not have.
fn check_options(args: &Render, kind: OutputKind) -> Result<()> {
    let traced = args.shared.technique == TechniqueChoice::Reference;
    if traced && args.shared.debug_view.is_some() {
        return Err(Error::usage("--debug-view shows what a device draws; --technique reference has no such views"));
    }
    if traced && args.validate {
        return Err(Error::usage("--validate watches a device; --technique reference uses none"));
    }
    if traced && args.counters {
        return Err(Error::usage("--counters counts what a device loops over; --technique reference uses none"));
    }
    if args.layers && kind == OutputKind::Png {
        return Err(Error::usage("--layers adds layers to an EXR; a PNG has none"));
    }
    Ok(())
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

/// The picture of a debug view.
fn show(view: DebugView, args: &Render, plan: &Plan, picture: &Picture, ev: f64) -> Result<views::Shown> {
    let lit = || lit_bytes(picture, ev, args);
    let of_layer = match view {
        DebugView::Quads => {
            let (outlines, text) = lists::outlines(plan);
            return Ok(views::outlined(lit()?, plan.view.width, &outlines, text));
        }
        DebugView::Missed => {
            let missed = picture.layer("missed").ok_or_else(|| Error::new("the lists were not judged"))?;
            return Ok(views::missed(&lit()?, missed));
        }
        DebugView::Albedo => Some(views::View::Color("base_metallic")),
        DebugView::Normals => Some(views::View::Direction("normal_occlusion")),
        DebugView::Depth => Some(views::View::Distance("position_roughness")),
        DebugView::DepthRaw => Some(views::View::Raw("depth")),
        _ => lists::shown(view, plan).or_else(|| gbuffer::shown(view, plan)),
    };
    let of_layer = of_layer.ok_or_else(|| Error::new(format!("--debug-view {} has no layer", view.name())))?;
    views::draw(picture, of_layer)
}

/// Display bytes of the radiance.
fn lit_bytes(picture: &Picture, ev: f64, args: &Render) -> Result<Vec<u8>> {
    let radiance = picture.rgba("radiance").ok_or_else(|| Error::new("the frame has no radiance to show"))?;
    Ok(exposure::display(radiance, ev, tonemap(args.tonemap)))
}

fn write_picture(
    args: &Render,
    kind: OutputKind,
    outcome: &Outcome,
    shown: Option<&views::Shown>,
    (ev, notes): (f64, &[(String, String)]),
) -> Result<()> {
    let picture = &outcome.picture;
    match (kind, shown) {
        (OutputKind::Png, Some(shown)) => {
            let (rows, height) = shown.with_legend(picture.width)?;
            file::write_png(&args.output, [picture.width, height], &rows, notes)
        }
        (OutputKind::Png, None) => {
            let size = [picture.width, picture.height];
            file::write_png(&args.output, size, &lit_bytes(picture, ev, args)?, notes)
        }
        (OutputKind::Exr, _) => {
            let mut layers = vec!["radiance"];
            if args.layers || shown.is_some() {
                layers.extend(picture.layers.iter().map(|l| l.0.as_str()).filter(|n| *n != "radiance"));
            }
            file::write_exr(&args.output, picture, &layers, notes)
        }
    }
}
