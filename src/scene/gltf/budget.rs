//! The memory bound of the loader.
//!
//! For `F` bytes read (the file and all it refers to) the loader holds the files (`F`), decoded data URIs (under `F`),
//! and the JSON tree with what it unpacks: at most 40 MiB + `16 F`, counted here before it is allocated. Before there
//! are data URIs, the parser has a buffer of its own for long numbers and for strings with escapes: under `3 F`, since
//! it doubles when full. That is under 64 MiB + `20 F`; only a text whose tree alone takes half of it (real ones from about
//! a megabyte on) may lift the bound, up to 48 bytes a byte of text. Decoded pictures are bounded apart, by [`super::images`]: a
//! well-packed PNG legitimately grows a thousandfold.

use std::fmt;

use crate::error::{Error, Result};

const BASE_BYTES: u64 = 40 << 20;
const BYTES_PER_FILE_BYTE: u64 = 16;

/// Most that the JSON tree may take a byte of text: real compact texts take up to 38, a text of nothing but brackets 300.
const TREE_BYTES_PER_BYTE: u64 = 48;

/// Bytes unpacked so far, against bytes read so far.
pub(super) struct Budget {
    file_bytes: u64,
    used: u64,
    /// What a large honest tree takes beyond its half of the bound; 0 for texts under half a megabyte.
    lifted: u64,
}

impl Budget {
    pub(super) fn new(file_bytes: usize) -> Self {
        Self { file_bytes: file_bytes as u64, used: 0, lifted: 0 }
    }

    /// Another file of this many bytes has been read.
    pub(super) fn add_file(&mut self, bytes: usize) {
        self.file_bytes = self.file_bytes.saturating_add(bytes as u64);
    }

    /// Bytes of all files read.
    pub(super) fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    fn limit(&self) -> u64 {
        let bound = BASE_BYTES.saturating_add(self.file_bytes.saturating_mul(BYTES_PER_FILE_BYTE));
        bound.saturating_add(self.lifted)
    }

    /// Counts the JSON tree of a text. A compact text of some megabytes with its buffers in other files, not yet read, would pass the
    /// bound although nothing is wrong with it: beyond half the bound its tree counts apart, up to 48 bytes a byte.
    ///
    /// # Errors
    /// A text that is mostly brackets.
    pub(super) fn charge_tree(&mut self, bytes: u64, text_bytes: usize) -> Result<()> {
        let half = self.limit() / 2;
        if bytes <= (text_bytes as u64).saturating_mul(TREE_BYTES_PER_BYTE) {
            self.lifted = bytes.saturating_sub(half);
        }
        self.charge(bytes, 0, &"the JSON text")
    }

    /// True where `bytes` more could be held for a while.
    pub(super) fn has_room(&self, bytes: u64) -> bool {
        self.used.saturating_add(bytes) <= self.limit()
    }

    /// Counts `bytes` that stay until the scene is done, and makes sure that `passing` more fit beside them for a
    /// while.
    ///
    /// # Errors
    /// The bound would be passed: `what` names the part of the file.
    pub(super) fn charge(&mut self, bytes: u64, passing: u64, what: &dyn fmt::Display) -> Result<()> {
        if !self.has_room(bytes.saturating_add(passing)) {
            return Err(Error::new(format!(
                "{what}: unpacking needs more than {} MiB, the most for {} bytes of files",
                self.limit() >> 20,
                self.file_bytes
            )));
        }
        self.used += bytes;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_holds_and_grows_with_the_files() {
        let mut budget = Budget::new(100);
        budget.charge(40 << 20, 0, &"a").unwrap();
        budget.charge(1600, 0, &"b").unwrap();
        let e = budget.charge(1, 0, &"meshes[0]").unwrap_err().to_string();
        assert!(e.starts_with("meshes[0]: unpacking needs more than 40 MiB"), "{e}");
        budget.add_file(1);
        assert!(budget.charge(1, 16, &"c").is_err());
        budget.charge(1, 15, &"c").unwrap();
        assert!(budget.charge(u64::MAX, u64::MAX, &"d").is_err());
    }
}
