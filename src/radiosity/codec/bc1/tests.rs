use super::super::super::order::{self, Order, Orders};
use super::super::residual::Texels;
use super::super::test_scene::{Xorshift, check_decoding, error, scaled, scene};
use super::super::thesis::image;
use super::*;

#[test]
fn r7_zeros_stay_zero_and_skipped_blocks_equal_a_scan() {
    let mut random = Xorshift::new(7);
    for n in [4, 6, 33] {
        for zeros in [0, 3, 10, 12] {
            // Half of the rows zero, and so many twelfths of the rest.
            let values: Vec<f32> = (0..n * n)
                .map(|at| if at / n % 8 < 4 || random.bits() % 12 < zeros { 0.0 } else { 0.1 + random.unit() as f32 })
                .collect();
            let operator = scaled(&values, [1.0, 0.5, 0.1]);
            let encoded = Bc1::encode(n, &operator).unwrap();
            check_decoding(&encoded);
            for row in 0..n {
                for (column, element) in encoded.decode_row(row).into_iter().enumerate() {
                    let wanted = values[row * n + column];
                    assert!((wanted == 0.0) == (element == [0.0; 3]), "{row} {column}: {wanted} {element:?}");
                    assert!(element.iter().all(|x| (wanted == 0.0) == (*x == 0.0)));
                }
            }
            let side = block::side(n);
            let mut stored = 0;
            for block in 0..side * side {
                let holds = |texel: usize| {
                    let (y, x) = (block / side * 4 + texel / 4, block % side * 4 + texel % 4);
                    y < n && x < n && values[y * n + x] > 0.0
                };
                let any = (0..16).any(holds);
                assert_eq!(encoded.stored.find(block), any.then_some(stored), "{block}");
                stored += usize::from(any);
            }
            assert_eq!(encoded.blocks.len(), stored);
        }
    }
    let nothing = Bc1::encode(5, &scaled(&[0.0; 25], [1.0; 3])).unwrap();
    assert!(nothing.blocks.is_empty() && nothing.apart.elements.is_empty());
    assert_eq!(nothing.product(&[[1.0; 3]; 5], 1), [[0.0; 3]; 5]);
}

/// Blocks of all kinds: what is not zero never decodes to zero, in either mode; what is zero always does.
#[test]
fn r8_no_coupling_is_lost_to_the_fourth_entry() {
    let mut random = Xorshift::new(8);
    let logarithms = [Logarithm { top: 1.0, step: 10.0 / 254.0 }; 3];
    let (fitter, tables) = (Fitter::new(logarithms), logarithms.map(|logarithm| logarithm.table()));
    let mut modes = [0; 2];
    for kind in 0..3000 {
        let value = |random: &mut Xorshift| (-10.0 * random.unit()).exp() as f32;
        let base = [0; 3].map(|_| value(&mut random));
        let mut values: [[f32; 3]; 16] = std::array::from_fn(|_| match kind % 3 {
            0 => base,
            1 => base.map(|x| (x * 0.3 * random.unit() as f32).max(5e-5)),
            _ => [0; 3].map(|_| value(&mut random)),
        });
        if kind % 2 == 0 {
            values.iter_mut().filter(|_| random.bits().is_multiple_of(4)).for_each(|value| *value = [0.0; 3]);
        }
        let free = if kind % 5 == 0 { random.bits() as u16 } else { 0 };
        let Some(block) = fitter.fit(&Texels { values, free }) else { continue };
        modes[usize::from(block::is_four_color(block))] += 1;
        for (texel, decoded) in decode(block, &tables).into_iter().enumerate() {
            if free >> texel & 1 == 0 || values[texel] != [0.0; 3] {
                assert!(
                    decoded.iter().zip(values[texel]).all(|(x, v)| (*x == 0.0) == (v == 0.0)),
                    "{values:?} {decoded:?}"
                );
            }
        }
    }
    assert!(modes.iter().all(|count| *count > 500), "both modes occur: {modes:?}");
}

/// The one element within 5 %, the step of five bits of the narrowest scale halved, and all others exactly 0.
#[test]
fn r10_an_impulse_is_one_element() {
    for n in [1, 5, 9, 17] {
        for at in [0, n + 2, n * n / 2, n * n - 1].map(|at| at % (n * n)) {
            let mut values = vec![0.0; n * n];
            values[at] = 0.25;
            let encoded = Bc1::encode(n, &scaled(&values, [1.0, 0.3, 0.1])).unwrap();
            for row in 0..n {
                for (column, element) in encoded.decode_row(row).into_iter().enumerate() {
                    if row * n + column == at {
                        let wanted = [0.25, 0.075, 0.025];
                        assert!(element.iter().zip(wanted).all(|(x, w)| (x / w - 1.0f32).abs() < 0.05), "{element:?}");
                    } else {
                        assert_eq!(element, [0.0; 3], "{row} {column}");
                    }
                }
            }
        }
    }
}

#[test]
fn r10_one_red_row_is_red_and_its_column_is_not() {
    let n = 24;
    let mut random = Xorshift::new(10);
    let values: Vec<f32> = (0..n * n).map(|_| 0.01 + 0.002 * random.unit() as f32).collect();
    let mut operator = scaled(&values, [1.0; 3]);
    (0..n).for_each(|j| (1..3).for_each(|c| operator[c][7 * n + j] *= 0.05));
    let product = Bc1::encode(n, &operator).unwrap().product(&vec![[1.0; 3]; n], 1);
    let red = |y: &[f32; 3]| y[0] > 3.0 * y[1] && y[0] > 3.0 * y[2];
    assert!(product.iter().enumerate().all(|(i, y)| red(y) == (i == 7)), "{product:?}");
}

/// 27.6 nats: at most 12 are within the scale, and nothing is off by more than the least code stands for or by a share of itself.
#[test]
fn r11_values_of_all_sizes() {
    let n = 40;
    for size in [1.0f32, 1e-20, 1e20] {
        let values: Vec<f32> = (0..n * n).map(|at| size * 10f32.powf(-12.0 * (at / n / 4) as f32 / 9.0)).collect();
        let encoded = Bc1::encode(n, &scaled(&values, [1.0; 3])).unwrap();
        check_decoding(&encoded);
        for row in 0..n {
            for element in encoded.decode_row(row) {
                let wanted = values[row * n];
                let off = element.iter().map(|x| (x - wanted).abs()).fold(0.0, f32::max);
                assert!(off < 0.1 * wanted || off <= encoded.tables[0][1], "{row}: {wanted} {element:?}");
            }
        }
    }
}

#[test]
fn r12_any_size_and_r18_counts() {
    let mut random = Xorshift::new(12);
    for n in [0, 1, 3, 5, 17, 34] {
        let values: Vec<f32> = (0..n * n).map(|_| random.unit() as f32).collect();
        let encoded = Bc1::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap();
        check_decoding(&encoded);
        let count = sparse::share(n, SHARE);
        assert_eq!(encoded.apart.elements.len(), count);
        assert_eq!((0..n).map(|row| encoded.apart.row(row).count()).sum::<usize>(), count);
        // All blocks alike: as many misses tie as there are blocks, and either none or all of the share is kept apart.
        let values: Vec<f32> = (0..n * n).map(|at| 0.1 + (at / n.max(1) % 4 * 4 + at % n.max(1) % 4) as f32).collect();
        let same = Bc1::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap();
        assert_eq!(same.apart.elements.len(), count);
        assert_eq!(same.apart.offsets.last().map(|last| *last as usize), Some(count));
        assert_eq!(same, Bc1::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap());
    }
    assert!(Bc1::encode(1, &scaled(&[f32::NAN], [1.0; 3])).is_err());
    assert!(Bc1::encode(2, &scaled(&[1.0], [1.0; 3])).is_err());
}

#[test]
fn product_of_a_room() {
    let scene = scene(8, 3);
    let operator = scene.resolvent();
    for which in Order::ALL {
        let orders = Orders::new(which, &image(scene.n, &operator).unwrap(), scene.n, 3).unwrap();
        let ordered = [0, 1, 2].map(|c| orders.apply(&operator[c]).unwrap());
        let lights: Vec<_> = scene.lights.iter().map(|x| order::gather(x, &orders.columns)).collect();
        let encoded = Bc1::encode(scene.n, &ordered).unwrap();
        check_decoding(&encoded);
        let error = error(&encoded, &ordered, &lights);
        let an_element = encoded.bytes().total() as f64 / (scene.n * scene.n) as f64;
        println!("n {}, bc1, {}: {:.2} % relL2, {an_element:.3} B an element", scene.n, which.name(), 100.0 * error);
        // 1.0 % with twice as many patches: their blocks are as much smoother.
        assert!(error < 0.018, "{error}");
    }
}
