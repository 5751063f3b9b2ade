//! `accuracy`: what accuracy costs. Each knob is turned while everything else stays, and each of its settings is timed, compared with
//! the f64 reference and with `forward`, and its lists are judged.

mod bakes;
mod cell;
mod judge;
mod knobs;
mod measure;
mod missed;
mod output;

use std::path::Path;
use std::process::ExitCode;

use clap::ValueEnum;
use serde_json::json;

use super::{measured, plan, report, setup};
use crate::cli::{Accuracy, KnobName};
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::measure::file;
use crate::measure::html::{self, Section};
use crate::plan::{Plan, Request};
use crate::renderer::Renderer;
use crate::scene::{AlphaMode, Scene};
use judge::Judge;
use measure::Runner;
use output::Outcome;

/// Seconds of drawing after which a setting gets no further round, and those of a quick run.
const SETTING_SECONDS: [f64; 2] = [6.0, 1.0];

/// Rounds where `--rounds` does not say, and those of a quick run.
const ROUNDS: [u32; 2] = [9, 3];

/// What was asked for, opened.
struct Session<'a> {
    args: &'a Accuracy,
    renderer: Renderer,
    scene: Scene,
    /// What is drawn where no knob is turned.
    request: Request,
    rounds: u32,
}

/// Runs the command.
///
/// # Errors
/// No device or a lost one, a scene that cannot be loaded, files that cannot be written, or nothing that could be drawn.
pub fn run(args: &Accuracy) -> Result<ExitCode> {
    if let Some(json) = args.json.as_deref().filter(|json| *json != Path::new("-")) {
        file::check_place(json)?;
    }
    let session = Session::open(args)?;
    for folder in [&args.plot, &args.report].into_iter().flatten() {
        measured::make_folder(folder)?;
    }
    let quiet = report::json_on_stdout(args.json.as_deref());
    let made = |name: KnobName| {
        let bakes = bakes::of_knob(name, &session.scene, args.quick)?;
        Ok(knobs::knob(name, &session.request, &bakes))
    };
    let knobs: Vec<_> = asked(args, &session.scene)?.into_iter().map(made).collect::<Result<_>>()?;
    let against: Vec<_> = knobs.iter().map(|knob| knob.against).collect();
    let judge = Judge::new(&session.renderer, &session.scene, &session.request, &against, args.quick)?;
    if !quiet {
        report::print(&session.heading(&judge))?;
    }
    let runner = Runner {
        renderer: &session.renderer,
        scene: &session.scene,
        judge: &judge,
        rounds: session.rounds,
        seconds: if args.quick { SETTING_SECONDS[1] } else { SETTING_SECONDS[0] },
    };
    let how = session.how(runner.seconds);
    let mut outcomes = Vec::new();
    for knob in knobs {
        let cells = runner.measure(&knob)?;
        let mut outcome = Outcome::new(knob, cells, &how);
        if outcome.knob.name == "cull" && args.report.is_some() {
            outcome.section.pictures = missed::pictures(&session.renderer)?;
        }
        if !quiet {
            report::print(&measured::text(&outcome.section, &outcome.notes))?;
        }
        outcomes.push(outcome);
    }
    let refusals: Option<Vec<&str>> = outcomes.iter().map(Outcome::refusal).collect();
    if let Some(why) = refusals.and_then(|all| all.first().map(|why| (*why).to_string())) {
        return Err(Error::new(why));
    }
    session.write(&judge, &outcomes)?;
    Ok(ExitCode::SUCCESS)
}

/// Each knob once, in the order of the list: those that were asked for, else those that the scene calls for.
fn asked(args: &Accuracy, scene: &Scene) -> Result<Vec<KnobName>> {
    let blends = scene.materials.iter().any(|material| material.alpha == AlphaMode::Blend);
    let idle = |name: &KnobName| knobs::needs_blended(*name) && !blends;
    if let Some(name) = args.knob.iter().find(|name| idle(name)) {
        let typed = name.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string());
        return Err(Error::usage(format!("--knob {typed}: nothing in {} is blended", args.scene)));
    }
    let every = KnobName::value_variants().iter().copied();
    // Bakes and paths take minutes.
    let called = |name: &KnobName| !idle(name) && !bakes::is_of_bounces(*name);
    Ok(every.filter(|name| if args.knob.is_empty() { called(name) } else { args.knob.contains(name) }).collect())
}

impl<'a> Session<'a> {
    fn open(args: &'a Accuracy) -> Result<Self> {
        let mut scene = setup::load_scene(&args.scene)?;
        setup::scatter_lights(&mut scene, args.lights, args.light_seed)?;
        let renderer = Renderer::new(&Options { validate: false, driver: args.driver.clone() })?;
        let limits = renderer.limits();
        let request = knobs::base(args, &limits);
        // Said before rays are traced: what the device cannot draw in any way.
        Plan::new(&scene, &request, &limits)?;
        let rounds = args.rounds.unwrap_or(if args.quick { ROUNDS[1] } else { ROUNDS[0] });
        Ok(Self { args, renderer, scene, request, rounds })
    }

    /// Device, scene and reference for people.
    fn heading(&self, judge: &Judge) -> String {
        let (width, height) = (self.request.width, self.request.height);
        let lights = report::count(self.scene.lights.len(), "light");
        let mut said = format!("device    {}\n", self.renderer.device().facts.line());
        said += &format!("scene     {}: {lights}, {width}x{height}\n", self.args.scene);
        said += &format!(
            "reference rays in f64; errors are over the {:.1} % of the pixels whose neighbourhood is one surface\n",
            100.0 * judge.interior_share()
        );
        for note in self.scene.warnings.iter().chain(&judge.note) {
            said += &format!("note      {note}\n");
        }
        said
    }

    /// How everything is measured, for people.
    fn how(&self, seconds: f64) -> String {
        format!(
            "{} at {}x{}, {} shading; medians of up to {} interleaved frames of each setting, fewer where they take over \
             {seconds} s.",
            self.args.scene,
            self.request.width,
            self.request.height,
            self.request.shading.name(),
            self.rounds
        )
    }

    /// Where figures come from, by keyword.
    fn origin(&self, fingerprint: &str) -> Vec<(String, String)> {
        let origin = [
            ("version", env!("CARGO_PKG_VERSION").to_string()),
            ("arguments", measured::typed_arguments().join(" ")),
            ("light seed", self.args.light_seed.to_string()),
            ("host cores", measured::host_cores().to_string()),
            ("device", self.renderer.device().facts.line()),
            ("scene", format!("{} {fingerprint}", self.args.scene)),
        ];
        origin.map(|(key, value)| (key.to_string(), value)).to_vec()
    }

    /// Writes every file that was asked for.
    fn write(&self, judge: &Judge, outcomes: &[Outcome]) -> Result<()> {
        let fingerprint = self.scene.fingerprint();
        let origin = self.origin(&fingerprint);
        if let Some(folder) = &self.args.plot {
            let write = |outcome: &Outcome| {
                measured::write_figures(folder, outcome.knob.name, &outcome.section.figures, &origin)
            };
            outcomes.iter().try_for_each(write)?;
        }
        if let Some(folder) = &self.args.report {
            let sections: Vec<Section> = outcomes.iter().map(Outcome::page_section).collect();
            let page = html::page("Lampyris: what accuracy costs", &origin, &sections)?;
            file::write(&folder.join("index.html"), page.as_bytes())?;
        }
        let Some(path) = &self.args.json else { return Ok(()) };
        let rows = outcomes.iter().flat_map(|outcome| outcome.cells.iter().map(move |cell| cell.json(&outcome.knob)));
        let value = json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "arguments": measured::typed_arguments(),
            "device": report::device_json(&self.renderer.device().facts),
            "host_cores": measured::host_cores(),
            "scene": plan::scene_json(&self.args.scene, &self.scene, &fingerprint),
            "light_seed": self.args.light_seed,
            "width": self.request.width,
            "height": self.request.height,
            "shading": self.request.shading.name(),
            "rounds": self.rounds,
            "interior_share": judge.interior_share(),
            "notes": self.scene.warnings.iter().chain(&judge.note).collect::<Vec<_>>(),
            "rows": rows.collect::<Vec<_>>(),
        });
        report::write_json(path, &value)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Cli, Command, ShadingArg};
    use crate::plan::{GbufferLayout, Limits};
    use crate::scene::builtin;

    fn parsed(options: &[&str]) -> Accuracy {
        let all = ["lampyris", "accuracy"].iter().chain(options);
        match Cli::try_parse_from(all).map(|cli| cli.command) {
            Ok(Some(Command::Accuracy(args))) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn knobs_come_once_and_in_order() {
        let [glass, opaque] = ["glass", "cornell"].map(|name| builtin::load(name).expect("a built-in scene"));
        let found = |options: &[&str], scene: &Scene| asked(&parsed(options), scene);
        let without_bounces: Vec<_> =
            KnobName::value_variants().iter().copied().filter(|name| !bakes::is_of_bounces(*name)).collect();
        assert_eq!(found(&[], &glass).expect("knobs"), without_bounces);
        assert_eq!(found(&["--knob", "gi-codec"], &opaque).expect("knobs"), [KnobName::GiCodec]);
        let some = found(&["--knob", "slices,tile,slices"], &opaque).expect("knobs");
        assert_eq!(some, [KnobName::Tile, KnobName::Slices]);
        let called = found(&[], &opaque).expect("knobs");
        assert!(called.contains(&KnobName::Msaa) && !called.contains(&KnobName::TransparentSort));
        let refused = found(&["--knob", "transparent-sort"], &opaque).expect_err("nothing is blended").to_string();
        assert!(refused.contains("transparent-sort") && refused.contains("blended"), "{refused}");
    }

    #[test]
    fn options_reach_the_request() {
        let base = |options: &[&str]| knobs::base(&parsed(options), &Limits::MINIMUM);
        let request = base(&["--quick", "--light-range", "2", "--shading", "lambert"]);
        assert_eq!((request.width, request.height), (160, 90));
        assert_eq!(request.rules.range, setup::range(2.0));
        assert_eq!(request.shading, setup::shading(ShadingArg::Lambert));
        assert_eq!(request.gbuffer, GbufferLayout::Compact);
        assert_eq!(base(&["--quick", "--size", "20x10"]).width, 20);
        assert_eq!(base(&[]).rules, Request::default().rules);
        let five = Limits { max_color_attachments: 5, ..Limits::MINIMUM };
        assert_eq!(knobs::base(&parsed(&[]), &five).gbuffer, GbufferLayout::Fat);
    }
}
