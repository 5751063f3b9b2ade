//! The binary container (glTF 2.0, section 4): header, JSON chunk, optional BIN chunk.
//!
//! Not the `gltf` crate's `Glb::from_slice` (1.4.1): it subtracts 12 from the header's length unchecked, which panics
//! for lengths below 12 where overflow is checked; it reads chunks past that length, to the end of the slice; and it
//! refuses a second chunk of unknown kind, which section 4.4.3 says to ignore. Its errors name no lengths.

use crate::error::{Error, Result};

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The JSON text of a `.gltf` or `.glb` file, and the binary chunk where there is one.
///
/// # Errors
/// A container whose lengths pass its end, or of another version.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(Error::new("the GLB header ends too early"));
    };
    if version != 2 {
        return Err(Error::new(format!("GLB version {version} is not supported, only 2")));
    }
    let Some(body) = bytes.get(12..length as usize) else {
        return Err(Error::new(format!("the GLB header says {length} bytes, the file has {}", bytes.len())));
    };
    let (kind, json, mut rest) = chunk(body)?;
    if kind != JSON_CHUNK {
        return Err(Error::new("the first chunk of the GLB file is not JSON"));
    }
    // Chunks of unknown kind are skipped, as the specification asks.
    while rest.len() >= 8 {
        let (kind, data, after) = chunk(rest)?;
        if kind == BIN_CHUNK {
            return Ok((json, Some(data)));
        }
        rest = after;
    }
    Ok((json, None))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk::<4>().map(|word| u32::from_le_bytes(*word))
}

/// Kind and bytes of the first chunk, and what follows it.
fn chunk(bytes: &[u8]) -> Result<(u32, &[u8], &[u8])> {
    let (Some(length), Some(kind)) = (word(bytes, 0), word(bytes, 4)) else {
        return Err(Error::new("a GLB chunk header ends too early"));
    };
    let rest = &bytes[8..];
    match rest.split_at_checked(length as usize) {
        Some((data, after)) => Ok((kind, data, after)),
        None => Err(Error::new(format!("a GLB chunk says {length} bytes, {} are left", rest.len()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn container(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*data);
        }
        let mut bytes = b"glTF".to_vec();
        bytes.extend(2u32.to_le_bytes());
        bytes.extend((body.len() as u32 + 12).to_le_bytes());
        bytes.extend(body);
        bytes
    }

    #[test]
    fn chunks_are_found() {
        let bytes = container(&[(b"JSON", b"{}  "), (b"what", b"1234"), (b"BIN\0", b"5678")]);
        assert_eq!(split(&bytes).unwrap(), (b"{}  ".as_slice(), Some(b"5678".as_slice())));
        assert_eq!(split(&container(&[(b"JSON", b"{}")])).unwrap().1, None);
        assert_eq!(split(b"{}").unwrap(), (b"{}".as_slice(), None));
    }

    #[test]
    fn every_truncation_is_refused() {
        let bytes = container(&[(b"JSON", b"{}  "), (b"BIN\0", b"5678")]);
        for end in 4..bytes.len() {
            assert!(split(&bytes[..end]).is_err(), "{end}");
        }
        assert!(split(&container(&[(b"BIN\0", b"5678")])).is_err());
        let mut other = bytes.clone();
        other[4] = 1;
        assert!(split(&other).unwrap_err().to_string().contains("version 1"));
        let mut short = bytes;
        short[8..12].copy_from_slice(&5u32.to_le_bytes());
        assert!(split(&short).is_err());
    }
}
