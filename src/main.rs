//! The command line program: parses, runs, and turns an error into one sentence and an exit status.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind as ClapKind;
use lampyris::cli::Cli;
use lampyris::error::ErrorKind;

fn main() -> ExitCode {
    let started = std::time::Instant::now();
    // 128 + SIGINT, as shells count; without a handler an interrupt would leave the file that is being written.
    let _ = ctrlc::set_handler(|| {
        lampyris::measure::file::remove_parts();
        std::process::exit(130);
    });
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if matches!(error.kind(), ClapKind::DisplayHelp | ClapKind::DisplayVersion) => {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            complain(&sentence(&error.to_string()));
            return ExitCode::from(2);
        }
    };
    match lampyris::commands::run(cli, started) {
        Ok(code) => code,
        Err(error) => {
            complain(&error.to_string());
            match error.kind() {
                ErrorKind::Failed => ExitCode::from(1),
                ErrorKind::Usage => ExitCode::from(2),
            }
        }
    }
}

/// clap's report of a wrong command line without the usage that `--help` shows.
fn sentence(report: &str) -> String {
    let parts = report.strip_prefix("error: ").unwrap_or(report).split("\n\n").map(str::trim);
    let facts = parts.take_while(|part| !part.starts_with("Usage:") && !part.starts_with("For more information"));
    let lines: Vec<String> = facts.map(|part| part.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    format!("{}; see --help", lines.join("; "))
}

/// Says one line. Names that a file brings along are shown, not obeyed, where they hold line breaks or escape sequences.
fn complain(message: &str) {
    let mut line = String::from("lampyris: ");
    for c in message.chars() {
        if c.is_control() { line.extend(c.escape_default()) } else { line.push(c) }
    }
    line.push('\n');
    // A closed standard error is no reason to panic.
    let _ = std::io::stderr().write_all(line.as_bytes());
}
