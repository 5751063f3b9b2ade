use super::super::test_scene::Xorshift;
use super::*;

#[test]
fn r18_ties_neither_add_nor_lose_one() {
    let mut random = Xorshift::new(18);
    for n in [1, 2, 3, 5, 17, 64] {
        for levels in [1, 2, 3, 1000] {
            let values: Vec<f32> = (0..n * n).map(|_| (random.bits() % levels) as f32).collect();
            let above = values.iter().filter(|x| **x > 0.0).count();
            for count in [0, 1, share(n, 0.04), n * n / 2, n * n, n * n + 1] {
                let chosen = largest(&values, count);
                assert_eq!(chosen.len(), count.min(above));
                assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]));
                // Whatever was left out is smaller, or the same with a higher number.
                let least = chosen.iter().map(|at| values[*at]).fold(f32::INFINITY, f32::min);
                let last = chosen.iter().filter(|at| values[**at] == least).max();
                for (at, value) in values.iter().enumerate().filter(|(at, _)| !chosen.contains(at)) {
                    assert!(*value < least || (*value == least && Some(&at) > last) || *value == 0.0);
                }
                let sparse = Values::new(n, chosen.iter().map(|at| (*at, values[*at])));
                let read: Vec<_> =
                    (0..n + 2).flat_map(|row| sparse.row(row).map(move |(x, v)| (row * n + x, v))).collect();
                assert_eq!(read, chosen.iter().map(|at| (*at, values[*at])).collect::<Vec<_>>());
                assert_eq!(sparse.offsets.last().copied(), Some(chosen.len() as u32));
            }
        }
    }
    assert!(largest(&[], 3).is_empty());
    assert_eq!(Values::new(0, std::iter::empty()).row(0).count(), 0);
}

#[test]
fn r11_residuals_of_any_size_fit_into_f16() {
    for size in [1e-36f32, 1e-20, 1e-6, 1.0, 1e5, 1e30] {
        let values: Vec<(usize, [f32; 3])> =
            [0usize, 3, 4, 8].iter().map(|at| (*at, [size, -size * 0.37, size * 1e-3 * (*at as f32 + 1.0)])).collect();
        let sparse = Residuals::new(3, &values);
        let read: Vec<_> = (0..4).flat_map(|row| sparse.row(row).map(move |(x, v)| (row * 3 + x, v))).collect();
        assert_eq!(read.len(), values.len());
        assert_eq!(sparse.scale.to_bits() & 0x7f_ffff, 0, "a power of two");
        for ((at, value), (read_at, read)) in values.iter().zip(read) {
            assert_eq!(*at, read_at);
            for c in 0..3 {
                assert!((value[c] - read[c]).abs() <= value[c].abs() / 2048.0, "{size}: {value:?} {read:?}");
            }
        }
    }
    let none = Residuals::new(0, &[]);
    assert_eq!((none.offsets.len(), none.row(0).count(), none.bytes()), (1, 0, 8));
    assert_eq!(Residuals::new(1, &[(0, [0.0; 3])]).row(0).next(), Some((0, [0.0; 3])));
}
