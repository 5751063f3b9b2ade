//! The command line program: parses, runs, and turns an error into one sentence and an exit status.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind as ClapKind;
use lampyris::cli::Cli;
use lampyris::error::ErrorKind;

fn main() -> ExitCode {
    let started = std::time::Instant::now();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            let harmless = matches!(error.kind(), ClapKind::DisplayHelp | ClapKind::DisplayVersion);
            return if harmless { ExitCode::SUCCESS } else { ExitCode::from(2) };
        }
    };
    match lampyris::commands::run(cli, started) {
        Ok(code) => code,
        Err(error) => {
            // A closed standard error is no reason to panic.
            let _ = writeln!(std::io::stderr(), "lampyris: {error}");
            match error.kind() {
                ErrorKind::Failed => ExitCode::from(1),
                ErrorKind::Usage => ExitCode::from(2),
            }
        }
    }
}
