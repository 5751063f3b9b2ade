//! `bench`: experiments. Each gives a table, rows for machines and figures; a page has them all.

mod ceiling;
mod cell;
mod effects;
mod keys;
mod lights;
mod materials;
mod million;
mod msaa;
mod output;
mod path;
mod prepass;
mod profile;
mod radiosity;
mod resolution;
mod run;
mod sweep;
mod tiles;
mod transparency;
mod views;

use std::path::Path;
use std::process::ExitCode;

use serde_json::{Value, json};

use super::{measured, report};
use crate::cli::{Bench, BenchName};
use crate::error::{Error, Result};
use crate::measure::file;
use keys::CameraPath;
use output::Outcome;
use run::Runner;

/// Seconds of `all` and of a quick one that its experiments share. Cells draw fewer rounds where a share runs out, but each is prepared
/// and drawn: what is left of 15 and of 2 minutes is for that.
const ALL_SECONDS: [f64; 2] = [780.0, 90.0];

struct Experiment {
    name: BenchName,
    /// Of the seconds of `all`.
    share: f64,
    run: fn(&Runner) -> Result<Outcome>,
}

const EXPERIMENTS: [Experiment; 13] = [
    Experiment { name: BenchName::Ceiling, share: 0.02, run: ceiling::run },
    Experiment { name: BenchName::Lights, share: 0.19, run: lights::run },
    Experiment { name: BenchName::Prepass, share: 0.05, run: prepass::run },
    Experiment { name: BenchName::Tiles, share: 0.10, run: tiles::run },
    Experiment { name: BenchName::Resolution, share: 0.11, run: resolution::run },
    Experiment { name: BenchName::Views, share: 0.09, run: views::run },
    Experiment { name: BenchName::Path, share: 0.13, run: path::run },
    Experiment { name: BenchName::Million, share: 0.10, run: million::run },
    Experiment { name: BenchName::Transparency, share: 0.05, run: transparency::run },
    Experiment { name: BenchName::Materials, share: 0.05, run: materials::run },
    Experiment { name: BenchName::Msaa, share: 0.04, run: msaa::run },
    Experiment { name: BenchName::Effects, share: 0.04, run: effects::run },
    Experiment { name: BenchName::Radiosity, share: 0.03, run: radiosity::run },
];

/// Runs the experiment, or all of them.
///
/// # Errors
/// No device or a lost one, files that cannot be read or written, or nothing that could be drawn.
pub fn run(args: &Bench) -> Result<ExitCode> {
    if args.name == BenchName::Profile {
        refuse_ignored(args)?;
        return profile::run(args);
    }
    let all = args.name == BenchName::All;
    if args.path.is_some() && !all && args.name != BenchName::Path {
        return Err(Error::usage("--path is the camera path of `path`; this experiment has none"));
    }
    if args.patches.is_some() && !all && args.name != BenchName::Radiosity {
        return Err(Error::usage("--patches is of `radiosity`; this experiment has none"));
    }
    let path = CameraPath::load(args.path.as_deref())?;
    if let Some(json) = args.json.as_deref().filter(|json| *json != Path::new("-")) {
        file::check_place(json)?;
    }
    let mut runner = Runner::new(args, path)?;
    for folder in [&args.plot, &args.report].into_iter().flatten() {
        measured::make_folder(folder)?;
    }
    let quiet = report::json_on_stdout(args.json.as_deref());
    if !quiet {
        let lines = runner.renderers.iter().map(|renderer| format!("device    {}\n", renderer.device().facts.line()));
        report::print(&lines.collect::<String>())?;
    }
    let mut outcomes = Vec::new();
    for experiment in EXPERIMENTS.iter().filter(|experiment| all || experiment.name == args.name) {
        runner.seconds = all.then(|| experiment.share * runner.either(ALL_SECONDS[0], ALL_SECONDS[1]));
        let outcome = (experiment.run)(&runner)?;
        if !quiet {
            report::print(&outcome.text())?;
        }
        outcomes.push(outcome);
    }
    if let [Outcome { refusal: Some(why), .. }, rest @ ..] = outcomes.as_slice()
        && rest.iter().all(|outcome| outcome.refusal.is_some())
    {
        return Err(Error::new(why.clone()));
    }
    write(&runner, &outcomes)?;
    Ok(ExitCode::SUCCESS)
}

/// `profile` measures one device by loads of its own.
fn refuse_ignored(args: &Bench) -> Result<()> {
    let ignored = [
        (args.plot.is_some(), "--plot"),
        (args.report.is_some(), "--report"),
        (args.path.is_some(), "--path"),
        (args.patches.is_some(), "--patches"),
        (!args.lights.is_empty(), "--lights"),
        (args.light_range.is_some(), "--light-range"),
        (args.driver.len() > 1, "second --driver"),
    ];
    match ignored.iter().find(|option| option.0) {
        Some((_, name)) => Err(Error::usage(format!("bench profile takes no {name}"))),
        None => Ok(()),
    }
}

/// Writes every file that was asked for.
fn write(runner: &Runner, outcomes: &[Outcome]) -> Result<()> {
    let origin = output::origin(runner);
    if let Some(folder) = &runner.args.plot {
        outcomes.iter().try_for_each(|outcome| outcome.write_figures(folder, &origin))?;
    }
    if let Some(folder) = &runner.args.report {
        output::write_page(folder, outcomes, &origin)?;
    }
    let Some(path) = &runner.args.json else { return Ok(()) };
    let mut values: Vec<Value> = outcomes.iter().map(|outcome| outcome.json(runner)).collect();
    let value = match (runner.args.name, values.pop()) {
        (BenchName::All, last) => {
            values.extend(last);
            json!({
                "schema": report::SCHEMA,
                "version": env!("CARGO_PKG_VERSION"),
                "arguments": measured::typed_arguments(),
                "experiments": values,
            })
        }
        (_, only) => only.unwrap_or_default(),
    };
    report::write_json(path, &value)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    #[test]
    fn all_is_every_experiment_and_their_shares_make_a_whole() {
        let names: Vec<BenchName> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
        let apart = [BenchName::All, BenchName::Profile];
        let expected: Vec<_> = BenchName::value_variants().iter().filter(|name| !apart.contains(name)).collect();
        assert_eq!(names.iter().collect::<Vec<_>>(), expected);
        assert!((EXPERIMENTS.iter().map(|experiment| experiment.share).sum::<f64>() - 1.0).abs() < 1e-9);
    }
}
