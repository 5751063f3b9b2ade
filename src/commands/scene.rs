//! `scene`: writes a procedural scene as glTF, or lists them.

use std::process::ExitCode;

use super::{report, setup};
use crate::cli::SceneArgs;
use crate::error::{Error, Result};
use crate::measure::file;
use crate::scene::{builtin, write};

/// Runs the command.
///
/// # Errors
/// An unknown name, or a file that cannot be written.
pub fn run(args: &SceneArgs) -> Result<ExitCode> {
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        let list: String = builtin::NAMES.iter().map(|(name, what)| format!("{name:<10} {what}\n")).collect();
        report::print(&list)?;
        return Ok(ExitCode::SUCCESS);
    };
    if output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("glb")) {
        return Err(Error::usage(format!("{}: a scene is written as .glb", output.display())));
    }
    let mut scene = builtin::load(name.strip_prefix("builtin:").unwrap_or(name))?;
    setup::scatter_lights(&mut scene, args.lights, args.light_seed)?;
    let bytes = write::glb(&scene)?;
    file::write(output, &bytes)?;
    report::print(&format!(
        "{}: {} triangles, {} lights, {}\n",
        output.display(),
        scene.triangle_count(),
        scene.lights.len(),
        report::bytes(bytes.len() as u64)
    ))?;
    Ok(ExitCode::SUCCESS)
}
