//! Pictures: PNG and JPEG, each decoded once however many images and textures name it.
//!
//! A header may promise any size, so it is weighed against the bytes behind it before anything is allocated. Deflate
//! expands at most 1032 times, so a PNG's own samples cannot be more than that many times its file; a JPEG needs at
//! least one bit for a block of 64 samples, so a byte stands for at most 512 pixels. All
//! pictures of a scene together take at most 64 MiB + 1100 times the bytes read, and never more than 2 GiB: a hostile
//! file can reach that, and so can a legitimate one that holds one colour.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::PathBuf;

use image::{ImageFormat, ImageReader};

use super::json::{Value, shorten};
use super::{Loader, decode, uri};
use crate::error::Result;
use crate::scene::Image;

/// Largest width and height, in texels: what desktop Vulkan drivers commonly offer.
const MAX_SIDE: u32 = 16384;

const PNG_EXPANSION: u64 = 1032;
/// Pixels that a byte of JPEG can stand for: one bit for a block of 64, and chroma at most halved either way beside it.
const JPEG_PIXELS: u64 = 512;

const TOTAL_BASE: u64 = 64 << 20;
const TOTAL_EXPANSION: u64 = 1100;
const TOTAL_LIMIT: u64 = 2 << 30;

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = b"\xFF\xD8\xFF";

/// Where a picture's bytes are, so that none is decoded twice.
#[derive(PartialEq, Eq, Hash)]
enum Source {
    /// Address and length inside the loaded buffers.
    View(usize, usize),
    File(PathBuf),
}

/// Pictures met so far; `None` stands for one of a format that is not supported.
#[derive(Default)]
pub(super) struct Pictures {
    by_image: HashMap<usize, Option<usize>>,
    by_source: HashMap<Source, Option<usize>>,
    decoded_bytes: u64,
}

impl<'a> Loader<'a> {
    /// Index into [`crate::scene::Scene::images`] of the image that the number `reference` names, decoded on first use;
    /// `None` where its format is not supported.
    ///
    /// # Errors
    /// A picture that cannot be read or decoded, or is larger than its bytes can be.
    pub(super) fn picture(&mut self, reference: Value<'a>) -> Result<Option<usize>> {
        let (index, image) = self.document.images.referred(reference)?;
        if let Some(known) = self.pictures.by_image.get(&index) {
            return Ok(*known);
        }
        let picture = self.open_picture(image, index)?;
        self.budget.charge(4 * size_of::<(Source, usize, Image)>() as u64, 0, &"images")?;
        self.pictures.by_image.insert(index, picture);
        Ok(picture)
    }

    fn open_picture(&mut self, image: Value<'a>, index: usize) -> Result<Option<usize>> {
        let mut name = image.name_or(String::new)?;
        let (source, bytes): (Option<Source>, Cow<'a, [u8]>) = if let Some(view) = image.get("bufferView")? {
            let bytes = self.buffers.view(view)?.bytes;
            let source = Source::View(bytes.as_ptr() as usize, bytes.len());
            if let Some(known) = self.pictures.by_source.get(&source) {
                return Ok(*known);
            }
            (Some(source), Cow::Borrowed(bytes))
        } else {
            let place = image.require("uri")?;
            let text = place.text()?;
            if let Some(bytes) = uri::data(text).map_err(|e| e.within(place.path()))? {
                (None, Cow::Owned(bytes))
            } else {
                let path = uri::file(text, self.base).map_err(|e| e.within(place.path()))?;
                let source = Source::File(path.canonicalize().unwrap_or_else(|_| path.clone()));
                if let Some(known) = self.pictures.by_source.get(&source) {
                    return Ok(*known);
                }
                let bytes = uri::read(&path).map_err(|e| e.within(place.path()))?;
                self.budget.add_file(bytes.len());
                if name.is_empty() {
                    name = shorten(text).to_owned();
                }
                (Some(source), Cow::Owned(bytes))
            }
        };
        if name.is_empty() {
            name = format!("images[{index}]");
        }
        let picture = match self.decode(image, &bytes)? {
            Some((width, height, rgba8)) => {
                self.scene.images.push(Image { name, width, height, rgba8 });
                Some(self.scene.images.len() - 1)
            }
            None => None,
        };
        if let Some(source) = source {
            self.pictures.by_source.insert(source, picture);
        }
        Ok(picture)
    }

    fn decode(&mut self, image: Value<'a>, bytes: &[u8]) -> Result<Option<(u32, u32, Vec<u8>)>> {
        let format = if bytes.starts_with(PNG_MAGIC) {
            ImageFormat::Png
        } else if bytes.starts_with(JPEG_MAGIC) {
            ImageFormat::Jpeg
        } else if is_other_format(bytes) {
            return Ok(None);
        } else {
            return Err(image.error("the picture is neither PNG nor JPEG"));
        };
        let undecodable = |e: image::ImageError| image.error(format_args!("the picture cannot be decoded: {e}"));
        let size = match format {
            ImageFormat::Png => png_size(bytes),
            _ => {
                let (width, height) =
                    ImageReader::with_format(Cursor::new(bytes), format).into_dimensions().map_err(undecodable)?;
                Some((width, height, u64::from(width) * u64::from(height) / JPEG_PIXELS))
            }
        };
        let Some((width, height, least_bytes)) = size else {
            return Err(image.error("the picture has no PNG header"));
        };
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(image.error(format_args!("the picture is {width}x{height}, each side may be 1 to {MAX_SIDE}")));
        }
        if least_bytes > bytes.len() as u64 {
            return Err(image.error(format_args!("{} bytes cannot hold a picture of {width}x{height}", bytes.len())));
        }
        let rgba8_bytes = u64::from(width) * u64::from(height) * 4;
        self.count_decoded(image, rgba8_bytes)?;
        let decoded = match format {
            ImageFormat::Png => decode::png(bytes, width, height),
            _ => decode::jpeg(bytes, width, height).map_err(|e| e.to_string()),
        };
        let decoded = decoded.map_err(|e| image.error(format_args!("the picture cannot be decoded: {e}")))?;
        if decoded.rows < height {
            let (path, rows) = (image.path(), decoded.rows);
            self.notes.say(format!(
                "{path}: the picture is truncated, {rows} of its {height} rows are there; the last one fills the rest"
            ));
        }
        Ok(Some((width, height, decoded.rgba8)))
    }

    fn count_decoded(&mut self, image: Value<'a>, bytes: u64) -> Result<()> {
        let limit =
            self.budget.file_bytes().saturating_mul(TOTAL_EXPANSION).saturating_add(TOTAL_BASE).min(TOTAL_LIMIT);
        self.pictures.decoded_bytes += bytes;
        if self.pictures.decoded_bytes > limit {
            return Err(
                image.error(format_args!("the pictures need more than {} MiB, the most for this file", limit >> 20))
            );
        }
        Ok(())
    }
}

/// Width, height, and the fewest bytes that so many samples can be packed into (PNG, section 11.2.1).
fn png_size(bytes: &[u8]) -> Option<(u32, u32, u64)> {
    let header = bytes.get(16..26)?;
    let word = |at: usize| header.get(at..)?.first_chunk::<4>().map(|word| u32::from_be_bytes(*word));
    let (width, height) = (word(0)?, word(4)?);
    let channels = match header[9] {
        0 | 3 => 1,
        2 => 3,
        4 => 2,
        _ => 4,
    };
    let samples = u64::from(width).saturating_mul(u64::from(height)).saturating_mul(channels);
    Some((width, height, samples.saturating_mul(u64::from(header[8])) / 8 / PNG_EXPANSION))
}

/// WebP, KTX2, Basis, AVIF, DDS and GIF by their first bytes.
fn is_other_format(bytes: &[u8]) -> bool {
    let starts: [&[u8]; 5] = [b"RIFF", b"\xABKTX", b"sB", b"DDS ", b"GIF8"];
    starts.iter().any(|start| bytes.starts_with(start)) || bytes.get(4..8) == Some(b"ftyp")
}
