use super::super::test_scene::Xorshift;
use super::*;

/// The mean of reals, rounded.
fn mean(a: u8, b: u8, share: f64) -> u8 {
    (f64::from(a) * (1.0 - share) + f64::from(b) * share).round() as u8
}

#[test]
fn ends_expand_to_within_a_code_of_their_share_of_255() {
    for x in 0..32u8 {
        assert!((f64::from(expand5(x)) - f64::from(x) * 255.0 / 31.0).abs() < 0.75, "{x}");
    }
    for x in 0..64u8 {
        assert!((f64::from(expand6(x)) - f64::from(x) * 255.0 / 63.0).abs() < 0.75, "{x}");
        assert_eq!(nearest_end(expand([x / 2, x, x / 2]).map(f32::from)), [x / 2, x, x / 2]);
    }
    assert_eq!(nearest_end([-3.0, f32::NAN, 999.0]), [0, 0, 31]);
}

#[test]
fn every_pair_of_levels_is_rounded_to_nearest() {
    for a in 0..=255u8 {
        for b in 0..=255u8 {
            let levels = bc4_levels([a, b]);
            assert_eq!(levels[..2], [a, b]);
            let (steps, rest): (usize, &[u8]) = if a > b { (7, &[]) } else { (5, &[0, 255]) };
            for k in 1..steps {
                assert_eq!(levels[k + 1], mean(a, b, k as f64 / steps as f64), "{a} {b} {k}");
            }
            assert_eq!(levels[steps + 1..], *rest);
        }
    }
    for a in 0..32u8 {
        for b in 0..32u8 {
            let [x, y] = [a, b].map(expand5);
            let ends = [[a, a, a], [b, b, b]];
            assert_eq!(four_colors(ends)[2][0], mean(x, y, 1.0 / 3.0));
            assert_eq!(four_colors(ends)[3][0], mean(x, y, 2.0 / 3.0));
            assert_eq!(three_colors(ends)[2][0], mean(x, y, 0.5));
            assert_eq!(three_colors(ends)[3], [0; 3]);
        }
    }
}

#[test]
fn blocks_are_as_in_dds_files() {
    // Red 31 and blue 31; texels 0, 1, 2, 3 of the first row have index 0, 1, 2, 3, all others 0.
    let mut indices = [0; 16];
    indices[..4].copy_from_slice(&[0, 1, 2, 3]);
    let block = bc1([[31, 0, 0], [0, 0, 31]], &indices);
    assert_eq!(to_bytes(&[block]), [0x00, 0xF8, 0x1F, 0x00, 0b1110_0100, 0, 0, 0]);
    assert!(is_four_color(block));
    assert_eq!(bc1_texels(block)[..5], [[255, 0, 0], [0, 0, 255], [170, 0, 85], [85, 0, 170], [255, 0, 0]]);

    let swapped = bc1([[0, 0, 31], [31, 0, 0]], &indices);
    assert!(!is_four_color(swapped));
    assert_eq!(bc1_texels(swapped)[..4], [[0, 0, 255], [255, 0, 0], [128, 0, 128], [0, 0, 0]]);

    indices = std::array::from_fn(|t| (t % 8) as u8);
    let block = bc4([200, 60], &indices);
    // Eight indices 0..8 are 0xFAC688 in three bytes, twice.
    assert_eq!(to_bytes(&[block]), [200, 60, 0x88, 0xC6, 0xFA, 0x88, 0xC6, 0xFA]);
    assert_eq!(bc4_texels(block)[..8], [200, 60, 180, 160, 140, 120, 100, 80]);
    assert_eq!(bc4_texels(bc4([60, 200], &indices))[..8], [60, 200, 88, 116, 144, 172, 0, 255]);
}

/// 2^16 random blocks: what the palette and the index say, straight from the bits (R9, the side of the CPU).
#[test]
fn r9_random_blocks_decode_to_what_their_bits_say() {
    let mut random = Xorshift::new(9);
    for _ in 0..1 << 16 {
        let block = [random.bits() as u32, random.bits() as u32];
        let bits = u64::from(block[0]) | u64::from(block[1]) << 32;
        let (colors, levels) = (bc1_texels(block), bc4_texels(block));
        let ends: [u16; 2] = [bits as u16, (bits >> 16) as u16];
        let channel = |end: u16, c: usize| -> u32 {
            match c {
                0 => u32::from(end >> 11) * 33 / 4,
                1 => u32::from(end >> 5 & 63) * 65 / 16,
                _ => u32::from(end & 31) * 33 / 4,
            }
        };
        for t in 0..16 {
            for (c, color) in colors[t].into_iter().enumerate() {
                let (a, b) = (channel(ends[0], c), channel(ends[1], c));
                let wanted = match (bits >> (32 + 2 * t) & 3, ends[0] > ends[1]) {
                    (0, _) => a,
                    (1, _) => b,
                    (2, true) => (2 * a + b + 1) / 3,
                    (2, false) => (a + b).div_ceil(2),
                    (_, true) => (a + 2 * b + 1) / 3,
                    _ => 0,
                };
                assert_eq!(u32::from(color), wanted);
            }
            let (a, b) = (bits as u32 & 255, bits as u32 >> 8 & 255);
            let wanted = match ((bits >> (16 + 3 * t) & 7) as u32, a > b) {
                (0, _) => a,
                (1, _) => b,
                (k, true) => ((8 - k) * a + (k - 1) * b + 3) / 7,
                (6, false) => 0,
                (7, false) => 255,
                (k, false) => ((6 - k) * a + (k - 1) * b + 2) / 5,
            };
            assert_eq!(u32::from(levels[t]), wanted);
        }
        let indices = std::array::from_fn(|t| bc1_index(block, t) as u8);
        assert_eq!(bc1(ends.map(unpack_end), &indices), block);
        let indices = std::array::from_fn(|t| bc4_index(block, t) as u8);
        assert_eq!(bc4([bits as u8, (bits >> 8) as u8], &indices), block);
    }
}
