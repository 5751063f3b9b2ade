//! CPU twin of the scan: the same levels in the same order.

use crate::shared::SCAN_RUN;

/// What precedes each item in sum, and last the total: one more than there are items. Sums past 2^32 wrap, as on the device.
pub fn run(items: &[u32]) -> Vec<u32> {
    let run_length = SCAN_RUN as usize;
    let parents = if items.len() > run_length {
        let sums: Vec<u32> =
            items.chunks(run_length).map(|c| c.iter().fold(0, |sum: u32, x| sum.wrapping_add(*x))).collect();
        run(&sums)
    } else {
        vec![0]
    };
    let mut offsets = Vec::with_capacity(items.len() + 1);
    let mut total = 0;
    for (chunk, parent) in items.chunks(run_length).zip(parents) {
        total = parent;
        for item in chunk {
            offsets.push(total);
            total = total.wrapping_add(*item);
        }
    }
    offsets.push(total);
    offsets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn equals_a_running_sum() {
        let mut random = Random::new(11);
        for count in [0, 1, 2, 63, 64, 65, 4095, 4096, 4097, 70_000] {
            let items: Vec<u32> = (0..count).map(|_| (random.next_u64() >> 49) as u32).collect();
            let (mut sum, mut wanted) = (0u32, vec![0u32]);
            for item in &items {
                sum += *item;
                wanted.push(sum);
            }
            assert_eq!(run(&items), wanted, "{count} items");
        }
    }

    #[test]
    fn sums_wrap() {
        assert_eq!(run(&[u32::MAX, 2, 5]), [0, u32::MAX, 1, 6]);
        let many = vec![u32::MAX; 65];
        assert_eq!(run(&many)[65], u32::MAX - 64);
    }
}
