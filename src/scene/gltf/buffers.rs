//! Buffers (external, data URI, GLB chunk) and the views into them, every range checked.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::document::Document;
use super::json::Value;
use super::uri;
use crate::error::Result;

enum Blob<'a> {
    /// Neither a URI nor the GLB chunk: an error only where it is read, since files with fallback buffers have such
    /// ones.
    Absent,
    Bytes(Cow<'a, [u8]>),
    /// The same file as an earlier buffer.
    Same(usize),
}

/// All buffers of a document.
pub(super) struct Buffers<'a> {
    document: &'a Document<'a>,
    blobs: Vec<Blob<'a>>,
}

/// A range of a buffer.
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    /// Bytes from one element to the next; `None` where they are packed.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads every buffer; each file once, however many buffers name it.
    ///
    /// # Errors
    /// A URI that cannot be read, or fewer bytes than `byteLength`.
    pub(super) fn load(
        document: &'a Document<'a>,
        chunk: Option<&'a [u8]>,
        base: Option<&Path>,
        budget: &mut Budget,
    ) -> Result<Self> {
        let count = document.buffers.len();
        budget.charge((count * size_of::<Blob>()) as u64, 0, &"buffers")?;
        let mut buffers = Self { document, blobs: Vec::with_capacity(count) };
        let mut files: HashMap<PathBuf, usize> = HashMap::new();
        for (index, buffer) in document.buffers.iter().enumerate() {
            let blob = match (buffer.get("uri")?, chunk) {
                (Some(uri), _) => from_uri(uri, base, &mut files, index, budget)?,
                (None, Some(chunk)) if index == 0 => Blob::Bytes(Cow::Borrowed(chunk)),
                (None, _) => Blob::Absent,
            };
            buffers.blobs.push(blob);
            let Some(there) = buffers.bytes(index).map(<[u8]>::len) else {
                continue;
            };
            let said = buffer.require("byteLength")?.index()?;
            if said > there {
                return Err(buffer.error(format_args!("byteLength is {said}, but there are {there} bytes")));
            }
        }
        Ok(buffers)
    }

    fn bytes(&self, index: usize) -> Option<&[u8]> {
        match self.blobs.get(index)? {
            Blob::Absent => None,
            Blob::Bytes(bytes) => Some(bytes),
            Blob::Same(other) => match self.blobs.get(*other)? {
                Blob::Bytes(bytes) => Some(bytes),
                _ => None,
            },
        }
    }

    /// The view that the number `reference` names.
    ///
    /// # Errors
    /// A view that passes the end of its buffer, or whose buffer has no data.
    pub(super) fn view(&self, reference: Value<'a>) -> Result<View<'_>> {
        let (_, view) = self.document.buffer_views.referred(reference)?;
        let (index, buffer) = self.document.buffers.referred(view.require("buffer")?)?;
        let Some(bytes) = self.bytes(index) else {
            return Err(buffer.error("has no uri and is not the GLB file's binary chunk"));
        };
        let declared = buffer.require("byteLength")?.index()?.min(bytes.len());
        let offset = view.get("byteOffset")?.map_or(Ok(0), Value::index)?;
        let length = view.require("byteLength")?.index()?;
        let range = offset.checked_add(length).and_then(|end| bytes[..declared].get(offset..end));
        let Some(bytes) = range else {
            return Err(view.error(format_args!(
                "byteOffset {offset} + {length} bytes pass the end of buffers[{index}] ({declared} bytes)"
            )));
        };
        // 0 is not allowed, but files have it where they mean "packed".
        let stride = view.get("byteStride")?.map(Value::index).transpose()?.filter(|stride| *stride > 0);
        Ok(View { bytes, stride })
    }
}

fn from_uri<'a>(
    uri: Value<'a>,
    base: Option<&Path>,
    files: &mut HashMap<PathBuf, usize>,
    index: usize,
    budget: &mut Budget,
) -> Result<Blob<'a>> {
    let text = uri.text()?;
    if let Some(bytes) = uri::data(text).map_err(|e| e.within(uri.path()))? {
        return Ok(Blob::Bytes(Cow::Owned(bytes)));
    }
    let path = uri::file(text, base).map_err(|e| e.within(uri.path()))?;
    // Different spellings of one path are one file.
    let path = path.canonicalize().unwrap_or(path);
    if let Some(other) = files.get(&path) {
        return Ok(Blob::Same(*other));
    }
    let bytes = uri::read(&path).map_err(|e| e.within(uri.path()))?;
    budget.add_file(bytes.len());
    files.insert(path, index);
    Ok(Blob::Bytes(Cow::Owned(bytes)))
}
