//! `check`: hard cases and equalities on the chosen driver, as a table of passes and failures.

use std::process::ExitCode;

use serde_json::json;

use super::report;
use crate::checks::{self, Row};
use crate::cli::Check;
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::renderer::Renderer;

/// The checks that were asked for.
///
/// # Errors
/// None of that name.
fn chosen(args: &Check) -> Result<Vec<&'static (&'static str, checks::Check)>> {
    let part = args.only.as_deref().unwrap_or_default();
    let deep = if args.deep { checks::DEEP } else { &[] };
    let all = || checks::ALL.iter().chain(deep);
    let found: Vec<_> = all().filter(|check| check.0.contains(part)).collect();
    if found.is_empty() {
        let names: Vec<&str> = all().map(|check| check.0).collect();
        return Err(Error::usage(format!("--only {part}: no check has that in its name: {}", names.join(", "))));
    }
    Ok(found)
}

/// Runs every check that was asked for.
///
/// # Errors
/// Any check that failed or could not run.
pub fn run(args: &Check) -> Result<ExitCode> {
    let chosen = chosen(args)?;
    let renderer = Renderer::new(&Options { validate: args.validate, driver: args.driver.clone() })?;
    let facts = &renderer.device().facts;
    let quiet = report::json_on_stdout(args.json.as_deref());
    if !quiet {
        report::print(&format!("{}\n", facts.line()))?;
    }
    let mut rows: Vec<Row> = Vec::new();
    for (name, check) in chosen {
        let mut found = check(&renderer).unwrap_or_else(|e| {
            vec![Row { name: (*name).into(), passed: false, detail: format!("could not run: {e}") }]
        });
        if args.validate {
            let messages = renderer.take_messages();
            let detail =
                messages.first().map_or("0 messages".to_string(), |m| format!("{} messages: {m}", messages.len()));
            found.push(Row { name: format!("validation of {name}"), passed: messages.is_empty(), detail });
        }
        if !quiet {
            let line =
                |row: &Row| format!("{}  {:<44} {}\n", if row.passed { "pass" } else { "FAIL" }, row.name, row.detail);
            report::print(&found.iter().map(line).collect::<String>())?;
        }
        rows.extend(found);
    }
    let failed = rows.iter().filter(|r| !r.passed).count();
    if !quiet {
        report::print(&format!("{} checks, {failed} failed\n", rows.len()))?;
    }
    if let Some(path) = &args.json {
        let listed: Vec<_> =
            rows.iter().map(|r| json!({ "name": r.name, "passed": r.passed, "detail": r.detail })).collect();
        let device = report::device_json(facts);
        report::write_json(
            path,
            &json!({ "schema": report::SCHEMA, "version": env!("CARGO_PKG_VERSION"), "device": device, "rows": listed, "failed": failed }),
        )?;
    }
    if failed > 0 {
        return Err(Error::new(format!("{failed} of {} checks failed", rows.len())));
    }
    Ok(ExitCode::SUCCESS)
}
