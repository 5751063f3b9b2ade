//! `render`: plan, draw or trace, measure, write.

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
use crate::plan::{DebugView, Plan, Technique};
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
    if args.shared.technique == TechniqueChoice::Reference && args.shared.debug_view.is_some() {
        return Err(Error::usage("--debug-view shows what a device draws; --technique reference has no such views"));
    }
    if args.shared.technique == TechniqueChoice::Reference && args.validate {
        return Err(Error::usage("--validate watches a device; --technique reference uses none"));
    }
    if args.layers && kind == OutputKind::Png {
        return Err(Error::usage("--layers adds layers to an EXR; a PNG has none"));
    }
    let ev = exposure_of(&args.exposure)?;
    let request = setup::request(&args.shared)?;
    let scene = setup::scene(&args.scene, &args.shared)?;
    process.stage("scene");
    let renderer = if request.technique == Technique::Reference {
        None
    } else {
        let options = Options { validate: args.validate, driver: args.shared.driver.clone() };
        Some(Renderer::new(&options)?)
    };
    let limits = setup::limits(&args.shared, renderer.as_ref());
    process.stage("driver");
    let planned = Plan::new(&scene, &request, &limits)?;
    let outcome = match &renderer {
        Some(renderer) => draw(renderer, &scene, &planned, &args, (started, process))?,
        None => trace(&scene, &planned, (started, process))?,
    };
    let main = main_layer(&outcome.picture, &planned)?;
    let automatic = exposure::automatic_ev(&main.pixels);
    let ev_used = ev.unwrap_or(automatic);
    let fingerprint = scene.fingerprint();
    let notes = said::provenance(&typed, &outcome, &fingerprint, &args);
    write_picture(&args, kind, &planned, &outcome, &main.pixels, (ev_used, &notes))?;
    let failed = outcome.validation.as_ref().is_some_and(|m| !m.is_empty());
    let quiet = report::json_on_stdout(args.json.as_deref());
    if !quiet {
        let mut said = said::text(&args, &scene, &planned, &outcome, (ev_used, ev.is_none()));
        if let Some([low, high]) = main.range {
            said += &format!("colours   {low:.4} (first) to {high:.4} (last)\n");
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

fn main_layer<'a>(picture: &'a Picture, plan: &Plan) -> Result<views::Shown<'a>> {
    match plan.debug_view {
        Some(view) => views::draw(picture, shown(view)),
        None => {
            let pixels = picture.rgba("radiance").ok_or_else(|| Error::new("the frame has no radiance to show"))?;
            Ok(views::Shown { pixels: pixels.into(), range: None })
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
