//! A matrix of compressed blocks as a texture file (Khronos, "KTX File Format Specification", version 2.0): one level, one layer, no supercompression.

use crate::radiosity::codec::block::{Block, side, to_bytes};

const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes before the index of levels, of which there is one.
const HEADER: usize = 80;
const LEVEL: usize = 24;
/// A descriptor of one sample, with its own length before it.
const DESCRIPTOR: usize = 4 + 24 + 16;

/// Which format blocks have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `VK_FORMAT_BC1_RGB_UNORM_BLOCK`.
    Bc1,
    /// `VK_FORMAT_BC4_UNORM_BLOCK`.
    Bc4,
}

impl Format {
    /// VkFormat and colour model of the Khronos Data Format.
    fn numbers(self) -> [u32; 2] {
        match self {
            Self::Bc1 => [131, 128],
            Self::Bc4 => [139, 131],
        }
    }
}

fn head(format: Format, count: usize) -> Vec<u8> {
    let [vk_format, model] = format.numbers();
    let blocks = side(count) * side(count);
    let data_at = (HEADER + LEVEL + DESCRIPTOR).next_multiple_of(8);
    let mut bytes = IDENTIFIER.to_vec();
    let mut words = |all: &[u32]| all.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    // Format, bytes of a unit, size, depth, layers, faces, levels, supercompression.
    words(&[vk_format, 1, count as u32, count as u32, 0, 0, 1, 1, 0]);
    // Descriptor, key/value data, and supercompression data: none of the last two.
    words(&[(HEADER + LEVEL) as u32, DESCRIPTOR as u32, 0, 0, 0, 0, 0, 0]);
    // The level: where it begins, its bytes, and its bytes without supercompression, 64 bits each.
    words(&[data_at as u32, 0, (8 * blocks) as u32, 0, (8 * blocks) as u32, 0]);
    // Basic descriptor block of version 2; BT.709 primaries, linear, straight alpha; 4 x 4 texels in 8 bytes.
    words(&[DESCRIPTOR as u32, 0, 2 | (24 + 16) << 16, model | 1 << 8 | 1 << 16, 3 | 3 << 8, 8, 0]);
    // The sample: all 64 bits, from 0 to the largest number.
    words(&[63 << 16, 0, 0, u32::MAX]);
    bytes.resize(data_at, 0);
    bytes
}

/// The file of a square matrix with `count` rows.
pub fn write(format: Format, count: usize, blocks: &[Block]) -> Vec<u8> {
    let mut bytes = head(format, count);
    bytes.extend(to_bytes(blocks));
    bytes
}

/// Blocks of a file as [`write`] makes it.
///
/// # Errors
/// Another form or size, in words.
pub fn read(format: Format, count: usize, bytes: &[u8]) -> Result<Vec<Block>, String> {
    let head = head(format, count);
    let data = bytes
        .strip_prefix(head.as_slice())
        .ok_or_else(|| format!("is no {format:?} texture of {count} x {count} texels in the form that bake writes"))?;
    if data.len() != 8 * side(count) * side(count) {
        return Err(format!("has {} bytes of blocks, {count} rows need {}", data.len(), 8 * side(count) * side(count)));
    }
    let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    Ok(data.chunks_exact(8).map(|b| [word(&b[..4]), word(&b[4..])]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader that nobody here wrote finds what was written.
    #[test]
    fn another_reader_finds_format_size_and_blocks() {
        for (format, known) in
            [(Format::Bc1, ktx2::Format::BC1_RGB_UNORM_BLOCK), (Format::Bc4, ktx2::Format::BC4_UNORM_BLOCK)]
        {
            for count in [1, 4, 9] {
                let blocks: Vec<Block> = (0..(side(count) * side(count)) as u32).map(|k| [k, !k]).collect();
                let bytes = write(format, count, &blocks);
                let reader = ktx2::Reader::new(bytes.as_slice()).expect("a KTX2 file");
                let header = reader.header();
                assert_eq!(header.format, Some(known));
                assert_eq!((header.pixel_width as usize, header.pixel_height as usize), (count, count));
                assert_eq!((header.level_count, header.face_count, header.supercompression_scheme), (1, 1, None));
                assert_eq!(reader.levels().next().expect("a level").data, to_bytes(&blocks));
                let (basic, _) = ktx2::dfd::Basic::from_format(known).expect("a known format");
                assert_eq!(reader.basic_dfd(), Some(&basic));
                assert_eq!(read(format, count, &bytes), Ok(blocks));
            }
        }
        let bytes = write(Format::Bc1, 5, &[[0; 2]; 4]);
        assert!(read(Format::Bc4, 5, &bytes).is_err() && read(Format::Bc1, 6, &bytes).is_err());
        assert!(read(Format::Bc1, 5, &bytes[..bytes.len() - 1]).is_err());
    }
}
