//! The measured profile on disk, by device and driver version. A file that is damaged or of another form is passed over.

use std::fs;
use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::gpu::features::Facts;
use crate::gpu::pipeline_cache;
use crate::plan::profile::Profile;

fn path(facts: &Facts) -> Option<PathBuf> {
    let uuid: String = facts.cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
    let file = format!("profile-{uuid}-{:x}-{}.json", facts.driver_version, env!("CARGO_PKG_VERSION"));
    pipeline_cache::folder().map(|f| f.join(file))
}

/// What was measured on this device, else the defaults of its kind.
pub fn load(facts: &Facts) -> Profile {
    let stored = path(facts).and_then(|p| fs::read(p).ok());
    let measured = stored.and_then(|bytes| serde_json::from_slice::<Profile>(&bytes).ok());
    measured.filter(Profile::is_sound).unwrap_or_else(|| defaults(facts))
}

/// Defaults by the driver's name.
fn defaults(facts: &Facts) -> Profile {
    let line = facts.line();
    if line.contains("llvmpipe") {
        Profile::lavapipe()
    } else if line.contains("SwiftShader") {
        Profile::swiftshader()
    } else {
        Profile::default()
    }
}

/// Stores a measured profile for later runs; where it went.
///
/// # Errors
/// No cache folder, or one that cannot be written.
pub fn store(facts: &Facts, profile: &Profile) -> Result<PathBuf> {
    let path =
        path(facts).ok_or_else(|| Error::new("neither XDG_CACHE_HOME nor HOME is set: a profile has no place"))?;
    let refused = |e: std::io::Error| Error::new(format!("{}: could not be written: {e}", path.display()));
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(refused)?;
    }
    let bytes = serde_json::to_vec_pretty(profile).map_err(|e| Error::new(format!("the profile: {e}")))?;
    let part = path.with_extension(format!("{}.part", std::process::id()));
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, &path)).map_err(refused)?;
    Ok(path)
}
