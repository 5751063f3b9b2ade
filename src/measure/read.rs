//! Reading pictures back from files for comparison.

use std::path::Path;

use exr::prelude as exr;

use crate::error::{Error, Result};

/// RGBA of a file: linear values of an EXR, display values 0..1 of a PNG.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Rows from the top.
    pub rgba: Vec<[f64; 4]>,
    /// True for an EXR.
    pub linear: bool,
}

/// Reads a PNG or an EXR.
///
/// # Errors
/// A file that cannot be read or is neither, named.
pub fn load(path: &Path) -> Result<Loaded> {
    let refuse = |why: String| Error::new(format!("{}: {why}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| refuse(format!("could not be read: {e}")))?;
    if bytes.starts_with(b"\x89PNG") {
        let picture = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png);
        let picture = picture.map_err(|e| refuse(format!("is damaged: {e}")))?.to_rgba8();
        let rgba = picture.pixels().map(|p| p.0.map(|c| f64::from(c) / 255.0)).collect();
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        return Ok(Loaded { width, height, rgba, linear: false });
    }
    if !bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return Err(refuse("is neither a PNG nor an EXR".into()));
    }
    use exr::{ReadChannels, ReadLayers};
    let read = exr::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (vec![[0f64; 4]; size.area()], size.width()),
            |(pixels, width): &mut (Vec<[f64; 4]>, usize), at, (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b, a].map(f64::from);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|e| refuse(format!("is damaged: {e}")))?;
    let size = read.layer_data.size;
    let rgba = read.layer_data.channel_data.pixels.0;
    Ok(Loaded { width: size.width(), height: size.height(), rgba, linear: true })
}
