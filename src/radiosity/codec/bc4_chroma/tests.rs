use super::super::super::order::{self, Order, Orders};
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
            let encoded = Bc4Chroma::encode(n, &operator).unwrap();
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
    let nothing = Bc4Chroma::encode(5, &scaled(&[0.0; 25], [1.0; 3])).unwrap();
    assert!(nothing.blocks.is_empty() && nothing.apart.elements.is_empty());
    assert_eq!(nothing.product(&[[1.0; 3]; 5], 1), [[0.0; 3]; 5]);
}

/// Blocks of all kinds: what is not zero never decodes to zero, with six levels or eight; what is zero always does.
#[test]
fn r8_no_coupling_is_lost_to_the_level_of_zero() {
    let mut random = Xorshift::new(8);
    let logarithm = Logarithm { top: 1.0, step: 10.0 / 254.0 };
    let (fitter, table) = (Fitter::new(logarithm), logarithm.table());
    let mut modes = [0; 2];
    for kind in 0..3000 {
        let base = (-10.0 * random.unit()).exp() as f32;
        let texels = std::array::from_fn(|_| {
            let value = match kind % 3 {
                0 => base,
                1 => base * random.unit() as f32,
                _ => (-11.0 * random.unit()).exp() as f32,
            };
            match random.bits() % 8 {
                0 if kind % 2 == 0 => Texel::Zero,
                1 if kind % 5 == 0 => Texel::Beyond,
                2 if kind % 7 == 0 => Texel::Free(value),
                _ => Texel::Value(value),
            }
        });
        let block = fitter.fit(&texels);
        let [low, high] = [block[0] & 255, block[0] >> 8 & 255];
        modes[usize::from(low > high)] += 1;
        for (code, texel) in block::bc4_texels(block).into_iter().zip(texels) {
            let wanted = if let Texel::Value(x) | Texel::Free(x) = texel { x } else { 0.0 };
            assert!(texel == Texel::Beyond || (code == 0) == (wanted == 0.0), "{texels:?}");
            if kind % 3 == 0 && wanted > 0.0 {
                // Half a code, and what the middle of two values is off that of their logarithms.
                assert!((table[usize::from(code)] / wanted).ln().abs() <= 5.1 / 254.0, "{texels:?}");
            }
        }
    }
    assert!(modes.iter().all(|count| *count > 500), "both modes occur: {modes:?}");
    assert_eq!(block::bc4_texels(fitter.fit(&[Texel::Zero; 16])), [0; 16]);
}

#[test]
fn grey_stays_grey() {
    let mut random = Xorshift::new(3);
    let values: Vec<f32> = (0..400).map(|_| random.unit() as f32).collect();
    let encoded = Bc4Chroma::encode(20, &scaled(&values, [1.0; 3])).unwrap();
    assert_eq!(encoded.tables.red, [1.0; 256]);
    assert_eq!(encoded.tables.blue, [1.0; 256]);
    (0..20).flat_map(|row| encoded.decode_row(row)).for_each(|[r, g, b]| assert!(r == g && g == b));
}

/// The one element within 1 %, half a step of 8 bits over the narrowest scale, and all others exactly 0.
#[test]
fn r10_an_impulse_is_one_element() {
    for n in [1, 5, 9, 17] {
        for at in [0, n + 2, n * n / 2, n * n - 1].map(|at| at % (n * n)) {
            let mut values = vec![0.0; n * n];
            values[at] = 0.25;
            let encoded = Bc4Chroma::encode(n, &scaled(&values, [1.0, 0.3, 0.1])).unwrap();
            for row in 0..n {
                for (column, element) in encoded.decode_row(row).into_iter().enumerate() {
                    if row * n + column == at {
                        let wanted = [0.25, 0.075, 0.025];
                        assert!(element.iter().zip(wanted).all(|(x, w)| (x / w - 1.0f32).abs() < 0.01), "{element:?}");
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
    let product = Bc4Chroma::encode(n, &operator).unwrap().product(&vec![[1.0; 3]; n], 1);
    let red = |y: &[f32; 3]| y[0] > 3.0 * y[1] && y[0] > 3.0 * y[2];
    assert!(product.iter().enumerate().all(|(i, y)| red(y) == (i == 7)), "{product:?}");
}

/// 27.6 nats: at most 12 are within the scale, and nothing is off by more than the least code stands for or by a share of itself.
#[test]
fn r11_values_of_all_sizes() {
    let n = 40;
    for size in [1.0f32, 1e-20, 1e20] {
        let values: Vec<f32> = (0..n * n).map(|at| size * 10f32.powf(-12.0 * (at / n / 4) as f32 / 9.0)).collect();
        let encoded = Bc4Chroma::encode(n, &scaled(&values, [1.0; 3])).unwrap();
        check_decoding(&encoded);
        for row in 0..n {
            for element in encoded.decode_row(row) {
                let wanted = values[row * n];
                let off = element.iter().map(|x| (x - wanted).abs()).fold(0.0, f32::max);
                assert!(off < 0.1 * wanted || off <= encoded.tables.luminance[1], "{row}: {wanted} {element:?}");
            }
        }
    }
}

#[test]
fn r12_any_size_and_r18_counts() {
    let mut random = Xorshift::new(12);
    for n in [0, 1, 3, 5, 17, 34] {
        let values: Vec<f32> = (0..n * n).map(|_| random.unit() as f32).collect();
        let encoded = Bc4Chroma::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap();
        check_decoding(&encoded);
        let count = sparse::share(n, SHARE);
        assert_eq!(encoded.apart.elements.len(), count);
        assert_eq!((0..n).map(|row| encoded.apart.row(row).count()).sum::<usize>(), count);
        // All blocks alike: as many misses tie as there are blocks, and either none or all of the share is kept apart.
        let values: Vec<f32> = (0..n * n).map(|at| 0.1 + (at / n.max(1) % 4 * 4 + at % n.max(1) % 4) as f32).collect();
        let same = Bc4Chroma::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap();
        assert_eq!(same.apart.elements.len(), count);
        assert_eq!(same.apart.offsets.last().map(|last| *last as usize), Some(count));
        assert_eq!(same, Bc4Chroma::encode(n, &scaled(&values, [1.0, 0.3, 0.7])).unwrap());
    }
    assert!(Bc4Chroma::encode(1, &scaled(&[f32::NAN], [1.0; 3])).is_err());
    assert!(Bc4Chroma::encode(2, &scaled(&[1.0], [1.0; 3])).is_err());
}

#[test]
fn product_of_a_room() {
    let scene = scene(8, 3);
    let operator = scene.resolvent();
    for which in Order::ALL {
        let orders = Orders::new(which, &image(scene.n, &operator).unwrap(), scene.n, 3).unwrap();
        let ordered = [0, 1, 2].map(|c| orders.apply(&operator[c]).unwrap());
        let lights: Vec<_> = scene.lights.iter().map(|x| order::gather(x, &orders.columns)).collect();
        let encoded = Bc4Chroma::encode(scene.n, &ordered).unwrap();
        check_decoding(&encoded);
        let error = error(&encoded, &ordered, &lights);
        let an_element = encoded.bytes().total() as f64 / (scene.n * scene.n) as f64;
        println!(
            "n {}, bc4-chroma, {}: {:.2} % relL2, {an_element:.3} B an element",
            scene.n,
            which.name(),
            100.0 * error
        );
        // Saturated walls next to white ones are what one colour a block is worst at: 0.4 to 0.5 % where all is grey.
        assert!(error < 0.02, "{error}");
    }
}
