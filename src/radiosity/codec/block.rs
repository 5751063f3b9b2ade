//! BC1 and BC4 blocks in integers, bit for bit what compute shaders do with the same words (`VK_FORMAT_BC1_RGB_UNORM_BLOCK` and
//! `VK_FORMAT_BC4_UNORM_BLOCK`; Khronos Data Format Specification 1.3, sections 18.1 and 19.1).
//!
//! A block is 8 bytes for 4 x 4 texels, here two little-endian words. Texel t = 4 y + x. Blocks of a matrix lie row-major, [`side`] of them a row; a
//! matrix whose side is no multiple of 4 is padded on the right and below.
//!
//! | words | BC1 | BC4 |
//! |---|---|---|
//! | 0 | end 0 in bits 0..16, end 1 in bits 16..32, each 5:6:5 with red on top | end 0 in bits 0..8, end 1 in bits 8..16, low 16 bits of the indices above |
//! | 1 | index of texel t in bits 2 t, 2 t + 1 | high 32 bits of the indices; index of texel t in bits 3 t .. 3 t + 3 of the 48 |
//!
//! Rounding: the formats leave the last bits to the decoder. Here ends of 5 and 6 bits become 8 by replication of their high bits, and what lies
//! between ends is the exact mean of those 8-bit values rounded to the nearest integer: thirds by `(2 a + b + 1) / 3`, sevenths by
//! `((7 - k) a + k b + 3) / 7`, fifths by `((5 - k) a + k b + 2) / 5`, none of which meets a tie, and the half by `(a + b + 1) / 2`, ties up.
//! Divisions are of unsigned integers, towards zero. Decoders of vendors differ from this by up to 6 codes (F. Giesen, "GPU BCn decoding", 2021).

/// Two words, in memory order.
pub type Block = [u32; 2];

/// A BC1 block of three colours in which every texel is exactly 0.
pub const ZEROS: Block = [0, u32::MAX];

/// A BC4 block of six levels in which every texel is exactly 0.
pub const ZEROS_BC4: Block = [0x6db6_0000, 0xdb6d_b6db];

/// An end of a BC1 block: red in 0..32, green in 0..64, blue in 0..32.
pub type End = [u8; 3];

/// Codes of the four indices of a BC1 block.
pub type Palette = [[u8; 3]; 4];

/// Blocks along a side of a matrix with `n` rows and columns.
pub fn side(n: usize) -> usize {
    n.div_ceil(4)
}

/// 8 bits of 5: the three high bits once more below.
pub fn expand5(x: u8) -> u8 {
    let x = x & 31;
    x << 3 | x >> 2
}

/// 8 bits of 6: the two high bits once more below.
pub fn expand6(x: u8) -> u8 {
    let x = x & 63;
    x << 2 | x >> 4
}

/// 8-bit codes of an end.
pub fn expand([red, green, blue]: End) -> [u8; 3] {
    [expand5(red), expand6(green), expand5(blue)]
}

/// The end nearest to three codes; what lies outside of 0..=255 is clamped, NaN gives 0.
pub fn nearest_end([red, green, blue]: [f32; 3]) -> End {
    let of = |x: f32, most: f32| (x * most / 255.0).round().clamp(0.0, most) as u8;
    [of(red, 31.0), of(green, 63.0), of(blue, 31.0)]
}

/// 16 bits of an end.
pub fn pack_end([red, green, blue]: End) -> u16 {
    u16::from(red & 31) << 11 | u16::from(green & 63) << 5 | u16::from(blue & 31)
}

/// The end in 16 bits.
pub fn unpack_end(bits: u16) -> End {
    [(bits >> 11) as u8, (bits >> 5 & 63) as u8, (bits & 31) as u8]
}

/// Codes of end 0, of end 1, of one third and of two thirds of the way from 0 to 1.
pub fn four_colors(ends: [End; 2]) -> Palette {
    let [a, b] = ends.map(expand);
    let third = |a: u8, b: u8| ((2 * u32::from(a) + u32::from(b) + 1) / 3) as u8;
    [a, b, [0, 1, 2].map(|c| third(a[c], b[c])), [0, 1, 2].map(|c| third(b[c], a[c]))]
}

/// Codes of end 0, of end 1, of the middle, and zero.
pub fn three_colors(ends: [End; 2]) -> Palette {
    let [a, b] = ends.map(expand);
    let middle = |c: usize| (u32::from(a[c]) + u32::from(b[c])).div_ceil(2) as u8;
    [a, b, [0, 1, 2].map(middle), [0; 3]]
}

/// A BC1 block from its ends as they are to be stored and 16 indices of 0..4: four colours where end 0 is the greater 16-bit number, otherwise three.
pub fn bc1(ends: [End; 2], indices: &[u8; 16]) -> Block {
    let [a, b] = ends.map(|end| u32::from(pack_end(end)));
    let indices = indices.iter().rev().fold(0, |word, index| word << 2 | u32::from(index & 3));
    [a | b << 16, indices]
}

/// Whether a BC1 block decodes with four colours (end 0 is the greater).
pub fn is_four_color(block: Block) -> bool {
    block[0] & 0xffff > block[0] >> 16
}

/// Codes of the four indices of a BC1 block.
pub fn bc1_palette(block: Block) -> Palette {
    let ends = [block[0] & 0xffff, block[0] >> 16].map(|bits| unpack_end(bits as u16));
    if is_four_color(block) { four_colors(ends) } else { three_colors(ends) }
}

/// Index of a texel of a BC1 block.
pub fn bc1_index(block: Block, texel: usize) -> usize {
    (block[1] >> (2 * (texel & 15)) & 3) as usize
}

/// Codes of the 16 texels of a BC1 block.
pub fn bc1_texels(block: Block) -> [[u8; 3]; 16] {
    let palette = bc1_palette(block);
    std::array::from_fn(|texel| palette[bc1_index(block, texel)])
}

/// Codes of the eight indices between BC4 ends: six between them where end 0 is the greater, otherwise four, 0 and 255.
pub fn bc4_levels([a, b]: [u8; 2]) -> [u8; 8] {
    let (x, y) = (u32::from(a), u32::from(b));
    let mut levels = [a, b, 0, 0, 0, 0, 0, 255];
    if a > b {
        for k in 1..7 {
            levels[k as usize + 1] = (((7 - k) * x + k * y + 3) / 7) as u8;
        }
    } else {
        for k in 1..5 {
            levels[k as usize + 1] = (((5 - k) * x + k * y + 2) / 5) as u8;
        }
    }
    levels
}

/// A BC4 block from its ends as they are to be stored and 16 indices of 0..8.
pub fn bc4(ends: [u8; 2], indices: &[u8; 16]) -> Block {
    let indices = indices.iter().rev().fold(0u64, |bits, index| bits << 3 | u64::from(index & 7));
    let bits = u64::from(ends[0]) | u64::from(ends[1]) << 8 | indices << 16;
    [bits as u32, (bits >> 32) as u32]
}

/// Codes of the eight indices of a BC4 block.
pub fn bc4_palette(block: Block) -> [u8; 8] {
    bc4_levels([block[0] as u8, (block[0] >> 8) as u8])
}

/// Index of a texel of a BC4 block.
pub fn bc4_index(block: Block, texel: usize) -> usize {
    let bits = u64::from(block[0]) | u64::from(block[1]) << 32;
    (bits >> (16 + 3 * (texel & 15)) & 7) as usize
}

/// Codes of the 16 texels of a BC4 block.
pub fn bc4_texels(block: Block) -> [u8; 16] {
    let levels = bc4_palette(block);
    std::array::from_fn(|texel| levels[bc4_index(block, texel)])
}

/// The bytes of blocks as files and textures hold them.
pub fn to_bytes(blocks: &[Block]) -> Vec<u8> {
    blocks.iter().flatten().flat_map(|word| word.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests;
