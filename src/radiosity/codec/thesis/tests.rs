use super::super::super::order::{self, Order, Orders};
use super::super::test_scene::{self, Xorshift, check_decoding, error, scaled, scene};
use super::*;

const BOTH: [Holes; 2] = [Holes::Zero, Holes::Filled];

#[test]
fn r7_zeros_stay_zero_and_nothing_leaks() {
    for holes in BOTH {
        // Nothing at all.
        let encoded = Thesis::encode(6, &scaled(&[0.0; 36], [1.0; 3]), holes).unwrap();
        (0..6).for_each(|row| assert_eq!(encoded.decode_row(row), [[0.0; 3]; 6]));
        // Rows 4..8 zero: whole blocks of code 0 beside others.
        let values: Vec<f32> =
            (0..144).map(|at| if (4..8).contains(&(at / 12)) { 0.0 } else { 0.01 + at as f32 }).collect();
        let encoded = Thesis::encode(12, &scaled(&values, [1.0, 0.5, 0.1]), holes).unwrap();
        (4..8).for_each(|row| assert_eq!(encoded.decode_row(row), [[0.0; 3]; 12]));
        assert!(
            encoded
                .product(&[[1.0; 3]; 12], 1)
                .iter()
                .enumerate()
                .all(|(i, y)| (4..8).contains(&i) == (*y == [0.0; 3]))
        );
    }
}

#[test]
fn r8_all_blocks_have_four_colors() {
    let mut random = Xorshift::new(8);
    for kind in 0..4000 {
        // Flat blocks, two values, a line, anything.
        let base: [f32; 3] = [0; 3].map(|_| (random.bits() % 256) as f32);
        let codes: Codes = std::array::from_fn(|_| match kind % 4 {
            0 => base,
            1 => base.map(|x| if random.bits().is_multiple_of(2) { x } else { 0.0 }),
            2 => base.map(|x| x * (random.bits() % 16) as f32 / 16.0),
            _ => [0; 3].map(|_| (random.bits() % 256) as f32),
        });
        let weights = std::array::from_fn(|texel| if kind % 8 == 7 && texel % 4 == 3 { 0.0 } else { 1.0 });
        let block = fit::four_color_block(&codes, &weights);
        assert!(block::is_four_color(block), "{codes:?}");
        let texels = block::bc1_texels(block);
        if kind % 4 == 0 {
            // Two steps of 5 bits apart thirds leave 3 codes at most, thirds of green 1.
            for c in 0..3 {
                assert!((f32::from(texels[0][c]) - base[c]).abs() <= 3.0, "{base:?} {:?}", texels[0]);
            }
        }
        if codes.iter().flatten().all(|x| *x > 64.0) {
            assert!(texels.iter().zip(weights).all(|(texel, weight)| weight == 0.0 || *texel != [0; 3]));
        }
    }
    assert!(block::is_four_color(fit::four_color_block(&[[0.0; 3]; 16], &[0.0; 16])));
    assert_eq!(block::bc1_texels(fit::four_color_block(&[[0.0; 3]; 16], &[1.0; 16])), [[0; 3]; 16]);
}

/// One element among zeros: it comes back, and nothing else is above the bound of 0 (it is kept apart, or one of a flat block of its own).
#[test]
fn r10_an_impulse_is_one_element() {
    for holes in BOTH {
        for n in [5, 9] {
            for at in [0, n + 2, n * n - 1] {
                let mut values = vec![0.0; n * n];
                values[at] = 0.25;
                let encoded = Thesis::encode(n, &scaled(&values, [1.0, 2.0, 4.0]), holes).unwrap();
                for row in 0..n {
                    for (column, element) in encoded.decode_row(row).into_iter().enumerate() {
                        let wanted = if row * n + column == at { [0.25, 0.5, 1.0] } else { [0.0; 3] };
                        assert_eq!(element, wanted, "{row} {column}");
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
    for holes in BOTH {
        let encoded = Thesis::encode(n, &operator, holes).unwrap();
        let red = |y: [f32; 3]| y[0] > 3.0 * y[1] && y[0] > 3.0 * y[2];
        let product = encoded.product(&vec![[1.0; 3]; n], 1);
        assert!(product.iter().enumerate().all(|(i, y)| red(*y) == (i == 7)), "{product:?}");
    }
}

/// 27.6 nats are more than the 25 of the scale: what is beyond decodes to 0, what is within to the nearest of 256 where a block is flat.
#[test]
fn r11_values_of_all_sizes() {
    let n = 40;
    let values: Vec<f32> = (0..n * n).map(|at| 10f32.powf(-12.0 * (at / n / 4) as f32 / 9.0)).collect();
    let encoded = Thesis::encode(n, &scaled(&values, [1.0; 3]), Holes::Filled).unwrap();
    for row in 4..n {
        let wanted = values[row * n];
        for element in encoded.decode_row(row) {
            let lost = wanted < (-25.0f32).exp() && element == [0.0; 3];
            // Three codes of 255 / 25 a nat.
            assert!(lost || element.iter().all(|x| (x / wanted).ln().abs() < 0.35), "{row}: {wanted} {element:?}");
        }
    }
    check_decoding(&encoded);
}

#[test]
fn r12_any_size_and_r18_counts() {
    let mut random = Xorshift::new(12);
    for n in [0, 1, 3, 5, 17] {
        let values: Vec<f32> = (0..n * n).map(|_| random.unit() as f32).collect();
        for holes in BOTH {
            let encoded = Thesis::encode(n, &scaled(&values, [1.0, 0.3, 0.7]), holes).unwrap();
            check_decoding(&encoded);
            let same = Thesis::encode(n, &scaled(&vec![0.5; n * n], [1.0; 3]), holes).unwrap();
            let count = sparse::share(n, SHARE);
            assert!(same.apart.iter().all(|values| values.values.len() == count));
            assert_eq!(same.published_sparse_bytes(), 24 * count);
            let blocks = block::side(n) * block::side(n);
            assert_eq!(same.bytes(), Bytes { blocks: 8 * blocks, sparse: 3 * (4 * (n + 1) + 6 * count), tables: 3072 });
        }
        assert_eq!(image(n, &scaled(&values, [1.0; 3])).unwrap().len(), 3 * n * n);
    }
    let bad = |x: f32| Thesis::encode(2, &scaled(&[1.0, x, 1.0, 1.0], [1.0; 3]), Holes::Zero).unwrap_err();
    assert!(
        bad(-1.0).contains("row 0, column 1") && bad(f32::NAN).contains("NaN") && bad(f32::INFINITY).contains("inf")
    );
    assert!(Thesis::encode(3, &scaled(&[1.0], [1.0; 3]), Holes::Zero).is_err());
    assert!(Thesis::encode(65537, &Default::default(), Holes::Zero).is_err());
}

#[test]
fn product_of_a_room() {
    let scene = scene(8, 3);
    let operator = scene.polynomial(3);
    let orders = Orders::new(Order::RowsColumns, &image(scene.n, &operator).unwrap(), scene.n, 3).unwrap();
    let ordered = [0, 1, 2].map(|c| orders.apply(&operator[c]).unwrap());
    let lights: Vec<_> = scene.lights.iter().map(|x| order::gather(x, &orders.columns)).collect();
    let [plain, filled] = BOTH.map(|holes| {
        let encoded = Thesis::encode(scene.n, &ordered, holes).unwrap();
        check_decoding(&encoded);
        let error = error(&encoded, &ordered, &lights);
        let an_element = |bytes: usize| bytes as f64 / (scene.n * scene.n) as f64;
        let published = encoded.bytes().blocks + encoded.published_sparse_bytes();
        println!(
            "n {}, {holes:?}: {:.2} % relL2, {:.3} B an element, {:.3} as published",
            scene.n,
            100.0 * error,
            an_element(encoded.bytes().total()),
            an_element(published)
        );
        error
    });
    let all = scene.resolvent();
    let cut: f64 = scene
        .lights
        .iter()
        .map(|x| test_scene::relative(&test_scene::exact(scene.n, &operator, x), &test_scene::exact(scene.n, &all, x)))
        .sum();
    println!("cut after three bounces: {:.2} % relL2", 100.0 * cut / scene.lights.len() as f64);
    assert!(plain < 0.2 && filled < 0.05 && filled < 0.7 * plain, "{plain} {filled}");
}
