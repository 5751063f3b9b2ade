//! URIs of buffers and images: `data:` with base64 (RFC 2397, RFC 4648) and paths relative to the file (RFC 3986).

use std::fs;
use std::path::{Path, PathBuf};

use super::json::shorten;
use crate::error::{Error, Result};

/// Largest file that is read, as lengths inside a GLB file are 32 bits.
const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// The bytes of a `data:` URI; `None` where `uri` is of another kind.
pub(super) fn data(uri: &str) -> Result<Option<Vec<u8>>> {
    if !uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return Ok(None);
    }
    let Some((header, body)) = uri[5..].split_once(',') else {
        return Err(Error::new("the data URI has no comma"));
    };
    if header.to_ascii_lowercase().ends_with(";base64") {
        return base64(body.as_bytes()).map(Some);
    }
    percent_decoded(body).map(Some)
}

/// Where a relative URI leads from the folder `base`.
///
/// # Errors
/// A scheme, a host or an absolute path: a scene is read from its own neighbourhood and never from a network.
pub(super) fn file(uri: &str, base: Option<&Path>) -> Result<PathBuf> {
    let shown = shorten(uri);
    let Some(base) = base else {
        return Err(Error::new(format!("\"{shown}\" is another file, and only data inside the file can be read here")));
    };
    let name_end = uri.find(['/', '?', '#']).unwrap_or(uri.len());
    if uri[..name_end].contains(':') {
        return Err(Error::new(format!("\"{shown}\" has a scheme; only data: and relative paths can be read")));
    }
    let decoded = percent_decoded(uri)?;
    let text = String::from_utf8(decoded).map_err(|_| Error::new(format!("\"{shown}\" is not UTF-8")))?;
    if text.is_empty() || text.contains('\0') {
        return Err(Error::new(format!("\"{shown}\" is not a file name")));
    }
    if text.starts_with(['/', '\\']) || Path::new(&text).is_absolute() {
        return Err(Error::new(format!("\"{shown}\" is an absolute path; only relative ones can be read")));
    }
    Ok(base.join(text))
}

/// The whole of a regular file: a pipe or a device could go on for ever.
pub(super) fn read(path: &Path) -> Result<Vec<u8>> {
    let unreadable = |e: std::io::Error| Error::new(format!("{} cannot be read: {e}", path.display()));
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(Error::new(format!("{} is not a file", path.display())));
    }
    if metadata.len() > MAX_FILE_BYTES {
        return Err(Error::new(format!("{} is larger than 4 GiB", path.display())));
    }
    fs::read(path).map_err(unreadable)
}

fn percent_decoded(text: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut parts = text.split('%');
    bytes.extend(parts.next().unwrap_or_default().bytes());
    for part in parts {
        let code = part.get(..2).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()));
        let Some(code) = code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) else {
            return Err(Error::new(format!("\"{}\" has a % without two hexadecimal digits", shorten(text))));
        };
        bytes.push(code);
        bytes.extend(&part.as_bytes()[2..]);
    }
    Ok(bytes)
}

/// Both alphabets of RFC 4648 are taken, with or without padding.
fn base64(text: &[u8]) -> Result<Vec<u8>> {
    let end = text.iter().rposition(|b| *b != b'=').map_or(0, |last| last + 1);
    let (text, padding) = text.split_at(end);
    if text.len() % 4 == 1 || padding.len() > 2 {
        return Err(Error::new("the base64 data of a data URI has a wrong length"));
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    for (group, chunk) in text.chunks(4).enumerate() {
        let mut bits = 0u32;
        for (i, byte) in chunk.iter().enumerate() {
            let Some(six) = base64_digit(*byte) else {
                let at = group * 4 + i;
                return Err(Error::new(format!("the data URI has a character that is not base64 at {at}")));
            };
            bits |= six << (18 - 6 * i);
        }
        bytes.extend(&bits.to_be_bytes()[1..chunk.len()]);
    }
    Ok(bytes)
}

fn base64_digit(byte: u8) -> Option<u32> {
    let digit = match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' | b'-' => 62,
        b'/' | b'_' => 63,
        _ => return None,
    };
    Some(u32::from(digit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zm9vYmE", "fooba"),
        ] {
            let uri = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(data(&uri).unwrap().unwrap(), bytes.as_bytes(), "{text}");
        }
        for text in ["Z", "Zm9v!a==", "Zg===", "Zm 9"] {
            assert!(data(&format!("data:;base64,{text}")).is_err(), "{text}");
        }
        assert_eq!(data("data:,a%20b").unwrap().unwrap(), b"a b");
        assert!(data("data:none").is_err());
        assert!(data("data.bin").unwrap().is_none());
    }

    #[test]
    fn paths() {
        let base = Path::new("scenes");
        assert_eq!(file("a%20b.bin", Some(base)).unwrap(), Path::new("scenes/a b.bin"));
        assert_eq!(file("../up/x.png", Some(base)).unwrap(), Path::new("scenes/../up/x.png"));
        for (uri, word) in [
            ("http://host/a.bin", "scheme"),
            ("file:///etc/passwd", "scheme"),
            ("/etc/passwd", "absolute"),
            ("%2fetc/passwd", "absolute"),
            ("\\\\host\\x", "absolute"),
            ("a%2", "hexadecimal"),
            ("a%zz", "hexadecimal"),
            ("", "file name"),
        ] {
            let e = file(uri, Some(base)).unwrap_err().to_string();
            assert!(e.contains(word), "{uri}: {e}");
        }
        assert!(file("a.bin", None).unwrap_err().to_string().contains("inside the file"));
        assert!(read(Path::new("/")).unwrap_err().to_string().contains("is not a file"));
    }
}
