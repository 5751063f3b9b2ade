//! Text and JSON on their way out. A closed pipe ends quietly.

use std::io::{ErrorKind, Write};
use std::path::Path;

use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::gpu::features::Facts;
use crate::measure::file;

/// Version of the machine forms; raised when a key changes its meaning, never for an added key.
pub const SCHEMA: u32 = 1;

/// Prints lines to standard output.
///
/// # Errors
/// Anything but a closed pipe.
pub fn print(text: &str) -> Result<()> {
    // Names that a file brings along are shown, not obeyed, where they hold escape sequences.
    let shown: String = text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect();
    let mut out = std::io::stdout().lock();
    match out.write_all(shown.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new(format!("standard output could not be written: {e}")))
        }
        _ => Ok(()),
    }
}

/// Writes a machine form to a file or, for `-`, to standard output.
///
/// # Errors
/// See [`file::write`].
pub fn write_json(path: &Path, value: &Value) -> Result<()> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::new(format!("the report could not be written as JSON: {e}")))?;
    text.push('\n');
    if path == Path::new("-") { print(&text) } else { file::write(path, text.as_bytes()) }
}

/// True where the machine form takes standard output, so that no other text may go there.
pub fn json_on_stdout(json: Option<&Path>) -> bool {
    json == Some(Path::new("-"))
}

/// A device in machine form.
pub fn device_json(facts: &Facts) -> Value {
    let (major, minor, patch) = facts.api;
    json!({
        "name": facts.name,
        "driver": facts.driver,
        "api": format!("{major}.{minor}.{patch}"),
        "kind": facts.kind,
        "subgroup_size": facts.subgroup_size,
    })
}

/// A number and its noun, in the singular for 1.
pub fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// Bytes as people read them.
pub fn bytes(n: u64) -> String {
    match n {
        0..1024 => format!("{n} B"),
        1024..1_048_576 => format!("{:.1} KiB", n as f64 / 1024.0),
        _ => format!("{:.1} MiB", n as f64 / 1_048_576.0),
    }
}
