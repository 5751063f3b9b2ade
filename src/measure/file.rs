//! PNG and EXR files, written beside their place and renamed, so that no reader ever sees half of one.

use std::path::Path;

use exr::prelude as exr;
use image::ImageEncoder;

use super::picture::Picture;
use crate::error::{Error, Result};

pub use crate::whole_file::{check_place, remove_parts, write};

/// Writes an RGBA8 picture as PNG with text entries (keyword, text).
///
/// # Errors
/// See [`write()`].
pub fn write_png(path: &Path, size: [u32; 2], rgba8: &[u8], notes: &[(String, String)]) -> Result<()> {
    let bytes = png(size, rgba8).map_err(|e| e.within(path.display()))?;
    write(path, &with_text(bytes, notes))
}

/// A PNG file of RGBA bytes, rows from the top.
///
/// # Errors
/// Another number of bytes than `size` has.
pub fn png(size: [u32; 2], rgba8: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    encoder
        .write_image(rgba8, size[0], size[1], image::ExtendedColorType::Rgba8)
        .map_err(|e| Error::new(format!("a PNG could not be encoded: {e}")))?;
    Ok(bytes)
}

/// PNG bytes with iTXt chunks after the header (PNG specification, 11.3.4.5).
fn with_text(png: Vec<u8>, notes: &[(String, String)]) -> Vec<u8> {
    // Signature, then the header chunk: length, type, 13 bytes, checksum.
    const AFTER_HEADER: usize = 8 + 4 + 4 + 13 + 4;
    let mut out = png[..AFTER_HEADER].to_vec();
    for (keyword, text) in notes {
        let mut chunk = b"iTXt".to_vec();
        chunk.extend_from_slice(keyword.as_bytes());
        chunk.extend_from_slice(&[0, 0, 0, 0, 0]);
        chunk.extend_from_slice(text.as_bytes());
        out.extend_from_slice(&(chunk.len() as u32 - 4).to_be_bytes());
        let sum = crc32(&chunk);
        out.extend_from_slice(&chunk);
        out.extend_from_slice(&sum.to_be_bytes());
    }
    out.extend_from_slice(&png[AFTER_HEADER..]);
    out
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, &byte: &u8| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// Text entries of a PNG that [`write_png`] wrote.
pub fn png_text(png: &[u8]) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut at = 8;
    while let Some(head) = png.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(data) = png.get(at + 8..at + 8 + length) else { break };
        if &head[4..8] == b"iTXt"
            && let Some(end) = data.iter().position(|&b| b == 0)
            && let Some(text) = data.get(end + 5..)
        {
            let string = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
            found.push((string(&data[..end]), string(text)));
        }
        at += 12 + length;
    }
    found
}

/// Text attributes of an EXR that [`write_exr`] wrote.
pub fn exr_text(bytes: &[u8]) -> Vec<(String, String)> {
    let Ok(meta) = ::exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false) else {
        return Vec::new();
    };
    let Some(header) = meta.headers.first() else { return Vec::new() };
    let text = |(key, value): (&exr::Text, &exr::AttributeValue)| match value {
        exr::AttributeValue::Text(text) => Some((key.to_string(), text.to_string())),
        _ => None,
    };
    header.own_attributes.other.iter().filter_map(text).collect()
}

/// Writes chosen layers of a picture as one EXR of f32 channels: the first layer as R, G, B, A, others as `name.R` ... or `name.Y`.
///
/// # Errors
/// See [`write()`].
pub fn write_exr(path: &Path, picture: &Picture, layers: &[&str], notes: &[(String, String)]) -> Result<()> {
    let size = (picture.width as usize, picture.height as usize);
    let mut channels = Vec::new();
    for (index, &name) in layers.iter().enumerate() {
        let Some(values) = picture.layer(name) else { continue };
        let of_pixel = values.len() / (size.0 * size.1).max(1);
        let letters: &[&str] = if of_pixel == 4 { &["R", "G", "B", "A"] } else { &["Y"] };
        for (k, letter) in letters.iter().enumerate() {
            let channel = if index == 0 && of_pixel == 4 { letter.to_string() } else { format!("{name}.{letter}") };
            let samples: Vec<f32> = values.iter().skip(k).step_by(of_pixel).copied().collect();
            channels.push(exr::AnyChannel::new(channel.as_str(), exr::FlatSamples::F32(samples)));
        }
    }
    let mut attributes = exr::LayerAttributes::named("lampyris");
    for (key, text) in notes {
        let value = exr::AttributeValue::Text(text.as_str().into());
        attributes.other.insert(key.as_str().into(), value);
    }
    let layer =
        exr::Layer::new(size, attributes, exr::Encoding::FAST_LOSSLESS, exr::AnyChannels::sort(channels.into()));
    let mut bytes = std::io::Cursor::new(Vec::new());
    exr::WritableImage::write(&exr::Image::from_layer(layer))
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::new(format!("{} could not be encoded: {e}", path.display())))?;
    write(path, &bytes.into_inner())
}
