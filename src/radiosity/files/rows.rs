//! Rows of a bake that is not done: a file a run, so that a bake goes on where it was left, on this machine or on several.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{VERSION, hash};
use crate::error::{Error, Result};
use crate::radiosity::factors::RawRows;
use crate::whole_file;

/// The file of a run of rows.
pub fn rows_path(folder: &Path, rows: &Range<usize>) -> PathBuf {
    folder.join(format!("rows-{:05}.bin", rows.start))
}

/// What a file of rows begins with: version, what is baked, rows, and counters; a line.
fn head(key: &str, rows: &Range<usize>, counted: [u64; 4], sum: &str) -> String {
    let [near, between, far, rays] = counted;
    format!("lampyris rows {VERSION} {key} {} {} {near} {between} {far} {rays} {sum}\n", rows.start, rows.end)
}

/// Writes rows; `key` says of what bake they are.
///
/// # Errors
/// A full disk, no permission.
pub fn store_rows(folder: &Path, key: &str, raw: &RawRows) -> Result<()> {
    let rows = raw.first..raw.first + raw.exchanges.len();
    let data: Vec<u8> = raw.exchanges.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let mut bytes = head(key, &rows, raw.counted, &hash(&data)).into_bytes();
    bytes.extend(data);
    whole_file::write(&rows_path(folder, &rows), &bytes)
}

/// Reads rows; `None` where there are none of this bake.
///
/// # Errors
/// A file that is damaged.
pub fn load_rows(folder: &Path, key: &str, rows: &Range<usize>, count: usize) -> Result<Option<RawRows>> {
    let path = rows_path(folder, rows);
    let Ok(bytes) = fs::read(&path) else { return Ok(None) };
    let refuse = |why: &str| Error::new(format!("{}: {why}", path.display()));
    let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(|| refuse("has no first line"))?;
    let line = String::from_utf8_lossy(&bytes[..=end]).into_owned();
    let data = &bytes[end + 1..];
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.get(..2) == Some(&["lampyris", "rows"]) && words.get(2) != Some(&VERSION.to_string().as_str()) {
        return Err(refuse(&format!(
            "is of version {}: this build reads version {VERSION}",
            words.get(2).unwrap_or(&"?")
        )));
    }
    let counted: Vec<u64> = words.iter().skip(6).take(4).filter_map(|word| word.parse().ok()).collect();
    let counted: [u64; 4] = counted.try_into().map_err(|_| refuse("its first line lacks counters"))?;
    if words.get(3) != Some(&key) {
        return Err(refuse(&format!("is of the bake {}, not of {key}", words.get(3).unwrap_or(&"?"))));
    }
    if line != head(key, rows, counted, &hash(data)) {
        return Err(refuse("is damaged: its first line does not fit what follows"));
    }
    let lengths: Vec<usize> = rows.clone().map(|row| count - row - 1).collect();
    if data.len() != 4 * lengths.iter().sum::<usize>() {
        return Err(refuse("has another number of elements than its rows"));
    }
    let mut values = data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let exchanges = lengths.into_iter().map(|length| values.by_ref().take(length).collect()).collect();
    Ok(Some(RawRows { first: rows.start, exchanges, counted }))
}
