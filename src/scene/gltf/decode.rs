//! Decoding of one PNG or JPEG into RGBA8, in memory that grows with what is really there.
//!
//! A PNG is decoded row by row, so a header that promises more than its data holds allocates little, and a truncated picture
//! keeps its rows. An interlaced PNG and a JPEG are decoded into the one buffer that stays; their headers have been weighed
//! against the bytes behind them before (see [`super::images`]).

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder, ImageResult};
use png::{DecodingError, Transformations};

/// Channels of the result.
const RGBA: usize = 4;

/// A decoded picture.
pub(super) struct Decoded {
    pub(super) rgba8: Vec<u8>,
    /// Rows that were there; the last of them fills the rest.
    pub(super) rows: u32,
}

/// Bytes that may go into texts and profiles of a picture beside its rows.
const METADATA_BYTES: usize = 16 << 20;

/// Decodes a PNG of the given size.
pub(super) fn png(bytes: &[u8], width: u32, height: u32) -> Result<Decoded, String> {
    let limits = png::Limits { bytes: METADATA_BYTES + width as usize * 64 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    if reader.info().interlaced {
        let rgba8 = whole(|| PngDecoder::new(Cursor::new(bytes)), width, height).map_err(|e| e.to_string())?;
        return Ok(Decoded { rgba8, rows: height });
    }
    let grey = reader.output_color_type().0 == png::ColorType::GrayscaleAlpha;
    let row_bytes = width as usize * RGBA;
    let mut rgba8 = Vec::new();
    let mut rows = 0;
    while rows < height {
        match reader.next_row() {
            Ok(Some(row)) => append_row(&mut rgba8, row.data(), grey),
            Ok(None) => break,
            Err(e) if rows > 0 && ends_early(&e) => break,
            Err(e) => return Err(e.to_string()),
        }
        rows += 1;
        if rgba8.len() != rows as usize * row_bytes {
            return Err("its rows are not as long as its header says".into());
        }
    }
    if rows == 0 {
        return Err("it has no rows".into());
    }
    let last = rgba8[(rows as usize - 1) * row_bytes..].to_vec();
    for _ in rows..height {
        rgba8.extend_from_slice(&last);
    }
    Ok(Decoded { rgba8, rows })
}

fn ends_early(error: &DecodingError) -> bool {
    match error {
        DecodingError::IoError(e) => e.kind() == std::io::ErrorKind::UnexpectedEof,
        other => other.to_string().contains("end of file"),
    }
}

/// Adds a row of grey and alpha, or of RGBA: the two that the transformations leave.
fn append_row(rgba8: &mut Vec<u8>, row: &[u8], grey: bool) {
    if grey {
        rgba8.extend(row.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]));
    } else {
        rgba8.extend_from_slice(row);
    }
}

/// Decodes a JPEG of the given size.
pub(super) fn jpeg(bytes: &[u8], width: u32, height: u32) -> ImageResult<Decoded> {
    let rgba8 = whole(|| JpegDecoder::new(Cursor::new(bytes)), width, height)?;
    Ok(Decoded { rgba8, rows: height })
}

/// Decodes into the front of the buffer that stays and spreads the channels from the back.
fn whole<D: ImageDecoder>(open: impl FnOnce() -> ImageResult<D>, width: u32, height: u32) -> ImageResult<Vec<u8>> {
    let decoder = open()?;
    let pixels = width as usize * height as usize;
    let color = decoder.color_type();
    let bytes = decoder.total_bytes() as usize;
    let mut buffer = vec![0; bytes.max(pixels * RGBA)];
    decoder.read_image(&mut buffer[..bytes])?;
    let (channels, wide) = match color {
        ColorType::L8 => (1, 1),
        ColorType::La8 => (2, 1),
        ColorType::Rgb8 => (3, 1),
        ColorType::L16 => (1, 2),
        ColorType::La16 => (2, 2),
        ColorType::Rgb16 => (3, 2),
        ColorType::Rgba16 => (4, 2),
        _ => (4, 1),
    };
    // The upper byte of a native 16-bit sample; exact to half a step of 8 bits.
    let high = if cfg!(target_endian = "little") { wide - 1 } else { 0 };
    let read = |buffer: &[u8], pixel: usize| {
        let at = |channel: usize| buffer[(pixel * channels + channel) * wide + high];
        match channels {
            1 => [at(0), at(0), at(0), 255],
            2 => [at(0), at(0), at(0), at(1)],
            3 => [at(0), at(1), at(2), 255],
            _ => [at(0), at(1), at(2), at(3)],
        }
    };
    if channels * wide <= RGBA {
        for pixel in (0..pixels).rev() {
            let value = read(&buffer, pixel);
            buffer[pixel * RGBA..][..RGBA].copy_from_slice(&value);
        }
    } else {
        for pixel in 0..pixels {
            let value = read(&buffer, pixel);
            buffer[pixel * RGBA..][..RGBA].copy_from_slice(&value);
        }
    }
    buffer.truncate(pixels * RGBA);
    buffer.shrink_to_fit();
    Ok(buffer)
}
