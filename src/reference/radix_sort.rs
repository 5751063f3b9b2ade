//! CPU twin of the radix sort, digit by digit and block by block, and of the keys that checks sort.

use super::scan;
use crate::shared::{
    KEYS_ALIKE, KEYS_ASCENDING, KEYS_DESCENDING, KEYS_EQUAL, KEYS_EXTREME, KEYS_STEP, RADIX_BITS, RADIX_BLOCK,
    RADIX_DIGITS,
};

/// Keys and values in the stable order of the keys' low `bits` bits. What the longer of the two has beyond the shorter is
/// left out.
pub fn run(keys: &[u32], values: &[u32], bits: u32) -> (Vec<u32>, Vec<u32>) {
    let mut pairs: Vec<(u32, u32)> = keys.iter().copied().zip(values.iter().copied()).collect();
    let bits = bits.min(u32::BITS);
    for shift in (0..bits).step_by(RADIX_BITS as usize) {
        let mask = (1u32 << (bits - shift).min(RADIX_BITS)) - 1;
        pairs = scatter(&pairs, |key| (key >> shift) & mask);
    }
    pairs.into_iter().unzip()
}

/// One digit.
fn scatter(pairs: &[(u32, u32)], digit: impl Fn(u32) -> u32) -> Vec<(u32, u32)> {
    let blocks: Vec<_> = pairs.chunks(RADIX_BLOCK as usize).collect();
    let place = |digit: u32, block: usize| digit as usize * blocks.len() + block;
    let mut counts = vec![0; RADIX_DIGITS as usize * blocks.len()];
    for (block, pairs) in blocks.iter().enumerate() {
        for (key, _) in *pairs {
            counts[place(digit(*key), block)] += 1;
        }
    }
    let mut next = scan::run(&counts);
    let mut moved = vec![(0, 0); pairs.len()];
    for (block, pairs) in blocks.iter().enumerate() {
        for pair in *pairs {
            let next = &mut next[place(digit(pair.0), block)];
            moved[*next as usize] = *pair;
            *next += 1;
        }
    }
    moved
}

/// Key number `index` of a kind (`KEYS_*`): twin of `glsl/prim/make_keys.comp`.
pub fn key(kind: u32, index: u32) -> u32 {
    match kind {
        KEYS_EQUAL => KEYS_ALIKE,
        KEYS_ASCENDING => index.wrapping_mul(KEYS_STEP),
        KEYS_DESCENDING => u32::MAX - index.wrapping_mul(KEYS_STEP),
        KEYS_EXTREME if index & 1 == 0 => u32::MAX,
        KEYS_EXTREME => 0,
        _ => hash(index),
    }
}

/// Finalizer of MurmurHash3 (A. Appleby, public domain): one to one.
fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::KEYS_HASHED;

    const KINDS: [u32; 5] = [KEYS_EQUAL, KEYS_ASCENDING, KEYS_DESCENDING, KEYS_HASHED, KEYS_EXTREME];

    fn stable(keys: &[u32], bits: u32) -> (Vec<u32>, Vec<u32>) {
        let low = (1u64 << bits) - 1;
        let mut pairs: Vec<_> = keys.iter().copied().zip(0..).collect();
        pairs.sort_by_key(|&(key, _)| u64::from(key) & low);
        pairs.into_iter().unzip()
    }

    #[test]
    fn equals_the_stable_sort_of_the_standard_library() {
        for count in [0, 1, 2, 255, 256, 257, 5000] {
            let values: Vec<u32> = (0..count).collect();
            for kind in KINDS {
                for (mask, bits) in
                    [(u32::MAX, 32), (u32::MAX, 6), (u32::MAX, 0), (15, 32), (0xfff0_000f, 32), (0x3ff, 10)]
                {
                    let keys: Vec<u32> = (0..count).map(|i| key(kind, i) & mask).collect();
                    let found = run(&keys, &values, bits);
                    assert_eq!(found, stable(&keys, bits), "{count} keys of kind {kind}, {bits} bits");
                }
            }
        }
    }

    #[test]
    fn kinds_are_what_they_are_called() {
        let keys = |kind| (0..=1 << 20).map(move |i| key(kind, i));
        assert!(keys(KEYS_ASCENDING).is_sorted_by(|a, b| a < b));
        assert!(keys(KEYS_DESCENDING).is_sorted_by(|a, b| a > b));
        assert!(keys(KEYS_EQUAL).all(|k| k == KEYS_ALIKE));
        assert!([0, u32::MAX].iter().all(|extreme| keys(KEYS_EXTREME).any(|k| k == *extreme)));
        let mut hashed: Vec<u32> = keys(KEYS_HASHED).collect();
        assert!(!hashed.is_sorted());
        hashed.sort_unstable();
        hashed.dedup();
        assert_eq!(hashed.len(), (1 << 20) + 1);
    }
}
