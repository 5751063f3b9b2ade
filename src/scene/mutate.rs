//! Damaged files by the thousand, the same for the same seed: the fuzzer of the loaders on a stable compiler.

use crate::math::random::Random;

/// Numbers at the edges of their types, as JSON writes them.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1",
    "2",
    "255",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e999",
    "-1e38",
    "1e-40",
    "0.5",
    "99999999",
];

/// Integers at the edges of their types.
const WORDS: [u32; 8] = [0, 1, 0x7F, 0xFF, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFE, 0xFFFF_FFFF];

/// Names that a glTF document may swap for one another without ceasing to be JSON.
const NAMES: [&[u8]; 8] =
    [b"POSITION", b"NORMAL", b"TANGENT", b"indices", b"mesh", b"children", b"byteOffset", b"count"];

/// Makes damaged copies of files.
pub struct Mutator {
    random: Random,
}

impl Mutator {
    /// Equal seeds give equal copies in equal order.
    pub fn new(seed: u64) -> Self {
        Self { random: Random::new(seed) }
    }

    /// A copy of `input` with one to four damages. Half of the GLB copies keep a header length that fits.
    pub fn mutate(&mut self, input: &[u8]) -> Vec<u8> {
        let mut bytes = input.to_vec();
        for _ in 0..=self.below(4) {
            match self.below(10) {
                0 => self.flip_bit(&mut bytes),
                1 => self.set_byte(&mut bytes),
                2 => bytes.truncate(self.below(bytes.len() + 1)),
                3 => self.repeat_range(&mut bytes),
                4 => self.remove_range(&mut bytes),
                5 => self.set_word(&mut bytes),
                6 | 7 => self.replace_number(&mut bytes),
                8 => self.swap_ranges(&mut bytes),
                _ => self.replace_name(&mut bytes),
            }
        }
        if bytes.starts_with(b"glTF") && bytes.len() >= 12 && self.below(2) == 0 {
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
        }
        bytes
    }

    /// From 0 to `end - 1`; 0 where `end` is 0.
    fn below(&mut self, end: usize) -> usize {
        (self.random.next_u64() % end.max(1) as u64) as usize
    }

    /// A range of at most 64 bytes inside `length`.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let end = (start + 1 + self.below(64)).min(length);
        start..end
    }

    fn flip_bit(&mut self, bytes: &mut [u8]) {
        let (at, bit) = (self.below(bytes.len()), self.below(8));
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 1 << bit;
        }
    }

    fn set_byte(&mut self, bytes: &mut [u8]) {
        let (at, value) = (self.below(bytes.len()), self.below(256));
        if let Some(byte) = bytes.get_mut(at) {
            *byte = value as u8;
        }
    }

    fn set_word(&mut self, bytes: &mut [u8]) {
        let at = self.below(bytes.len() / 4) * 4;
        let word = WORDS[self.below(WORDS.len())];
        if let Some(place) = bytes.get_mut(at..at + 4) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    fn repeat_range(&mut self, bytes: &mut Vec<u8>) {
        let range = self.range(bytes.len());
        let copy = bytes[range.clone()].to_vec();
        bytes.splice(range.end..range.end, copy);
    }

    fn remove_range(&mut self, bytes: &mut Vec<u8>) {
        let range = self.range(bytes.len());
        bytes.drain(range);
    }

    fn swap_ranges(&mut self, bytes: &mut [u8]) {
        let (a, b) = (self.range(bytes.len()), self.range(bytes.len()));
        let length = a.len().min(b.len());
        for i in 0..length {
            bytes.swap(a.start + i, b.start + i);
        }
    }

    /// Puts another number in the place of one written in ASCII, which leaves JSON to be JSON.
    fn replace_number(&mut self, bytes: &mut Vec<u8>) {
        let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'+' | b'.' | b'e' | b'E');
        let from = self.below(bytes.len());
        let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit).map(|at| from + at) else {
            return;
        };
        let start = bytes[..start].iter().rposition(|b| !is_number(b)).map_or(0, |before| before + 1);
        let end = bytes[start..].iter().position(|b| !is_number(b)).map_or(bytes.len(), |at| start + at);
        let number = NUMBERS[self.below(NUMBERS.len())];
        self.replace(bytes, start..end, number.as_bytes());
    }

    fn replace_name(&mut self, bytes: &mut Vec<u8>) {
        let (old, new) = (NAMES[self.below(NAMES.len())], NAMES[self.below(NAMES.len())]);
        let found = bytes.windows(old.len()).position(|window| window == old);
        if let Some(start) = found {
            self.replace(bytes, start..start + old.len(), new);
        }
    }

    /// Replaces a range and keeps the lengths of a GLB file and its JSON chunk in step three times of four.
    fn replace(&mut self, bytes: &mut Vec<u8>, range: std::ops::Range<usize>, new: &[u8]) {
        let (old_length, is_inside) = (bytes.len(), range.start >= 20);
        bytes.splice(range, new.iter().copied());
        if is_inside && bytes.starts_with(b"glTF") && self.below(4) > 0 {
            let chunk = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
            let chunk = (chunk + bytes.len()).saturating_sub(old_length) as u32;
            bytes[12..16].copy_from_slice(&chunk.to_le_bytes());
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_one_sequence() {
        let input = br#"{"asset":{"version":"2.0"},"count":12,"POSITION":-3.5}"#;
        let sequence = |seed: u64| {
            let mut mutator = Mutator::new(seed);
            (0..100).map(|_| mutator.mutate(input)).collect::<Vec<_>>()
        };
        assert_eq!(sequence(5), sequence(5));
        assert_ne!(sequence(5), sequence(6));
        let changed = sequence(5).iter().filter(|copy| copy.as_slice() != input.as_slice()).count();
        assert!(changed > 90, "{changed} of 100 differ");
    }

    #[test]
    fn small_inputs_are_no_trouble() {
        let mut mutator = Mutator::new(1);
        for input in ["", "1", "glTF", "glTF12345678"] {
            for _ in 0..500 {
                mutator.mutate(input.as_bytes());
            }
        }
    }

    #[test]
    fn numbers_are_replaced_whole() {
        let mut changed = 0;
        for seed in 0..50 {
            let mut bytes = b"[-12.5e3]".to_vec();
            Mutator::new(seed).replace_number(&mut bytes);
            let text = String::from_utf8(bytes).unwrap();
            changed += u32::from(text != "[-12.5e3]");
            let is_whole = NUMBERS.iter().any(|number| text == format!("[{number}]"));
            assert!(is_whole || text == "[-12.5e3]", "{text}");
        }
        assert!(changed > 25, "{changed} of 50");
    }
}
