//! Files that are whole or not there: written beside their place and renamed, and removed where the program is interrupted before that.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};

fn io_error(path: &Path, e: &std::io::Error) -> Error {
    Error::new(format!("{} could not be written: {e}", path.display()))
}

/// Partial files that exist now.
static PARTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes every partial file: for the handler of an interrupt, after which nothing else runs.
pub fn remove_parts() {
    for path in PARTS.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// A partial file, removed on any way out that is not success.
struct Part(PathBuf);

impl Part {
    fn new(path: PathBuf) -> Self {
        PARTS.lock().unwrap_or_else(PoisonError::into_inner).push(path.clone());
        Self(path)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Renamed by now where all went well: then there is nothing to remove.
        let _ = fs::remove_file(&self.0);
        PARTS.lock().unwrap_or_else(PoisonError::into_inner).retain(|p| *p != self.0);
    }
}

/// Writes `bytes` beside `path` and renames.
///
/// # Errors
/// A folder that is not there, no permission, a full disk; nothing is left behind then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().ok_or_else(|| Error::new(format!("{} is not a file name", path.display())))?;
    let mut part_name = std::ffi::OsString::from(".");
    part_name.push(name);
    part_name.push(format!(".{}.tmp-lampyris", std::process::id()));
    let part = Part::new(path.with_file_name(part_name));
    let mut file = fs::File::create(&part.0).map_err(|e| io_error(path, &e))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|e| io_error(path, &e))?;
    drop(file);
    fs::rename(&part.0, path).map_err(|e| io_error(path, &e))
}

/// Says before the work what [`write()`] would find after it: a folder that is not there, or a folder in the file's place.
///
/// # Errors
/// See above; the file and its folder are named.
pub fn check_place(path: &Path) -> Result<()> {
    let refuse = |why: String| Err(Error::new(format!("{} could not be written: {why}", path.display())));
    match path.parent().filter(|p| !p.as_os_str().is_empty()) {
        Some(folder) if !folder.is_dir() => refuse(format!("{} is not a folder", folder.display())),
        _ if path.is_dir() => refuse("it is a folder".into()),
        _ => Ok(()),
    }
}
