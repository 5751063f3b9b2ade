//! One file a subcommand: from what was typed to the library's calls, and from results to text and JSON.

mod accuracy;
mod bake;
mod bench;
mod check;
mod devices;
mod diff;
mod measured;
mod plan;
mod render;
mod report;
mod scene;
mod setup;

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;

use crate::cli::{Cli, Command};
use crate::error::Result;

/// Runs the command; `started` is when the process began.
///
/// # Errors
/// One sentence; the exit status follows from its kind.
pub fn run(cli: Cli, started: Instant) -> Result<ExitCode> {
    match cli.command {
        None => run(Cli::parse_from(["lampyris", "render"]), started),
        Some(Command::Render(args)) => render::run(args, started),
        Some(Command::Plan(args)) => plan::run(&args),
        Some(Command::Devices(args)) => devices::run(&args),
        Some(Command::Scene(args)) => scene::run(&args),
        Some(Command::Diff(args)) => diff::run(&args),
        Some(Command::Check(args)) => check::run(&args),
        Some(Command::Bake(args)) => bake::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Accuracy(args)) => accuracy::run(&args),
    }
}
