use super::super::codec::test_scene::{Xorshift, scene};
use super::super::codec::thesis::image;
use super::*;

fn is_permutation(order: &[u32]) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted == identity(order.len())
}

#[test]
fn orders_are_permutations_of_any_size() {
    let mut random = Xorshift::new(1);
    for n in [0, 1, 3, 5, 130] {
        for channels in [1, 3] {
            let image: Vec<u8> = (0..n * n * channels).map(|_| random.bits() as u8).collect();
            for order in Order::ALL {
                let orders = Orders::new(order, &image, n, channels).unwrap();
                assert!(is_permutation(&orders.rows) && is_permutation(&orders.columns), "{}", order.name());
                assert_eq!(orders, Orders::new(order, &image, n, channels).unwrap());
                // R10: a product in any order is the product.
                let values: Vec<f64> = (0..n * n).map(|_| random.unit()).collect();
                let x: Vec<f64> = (0..n).map(|_| random.unit()).collect();
                let times = |matrix: &[f64], x: &[f64]| -> Vec<f64> {
                    matrix.chunks(n.max(1)).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
                };
                let stored = orders.apply(&values).unwrap();
                let y = scatter(&times(&stored, &gather(&x, &orders.columns)), &orders.rows);
                times(&values, &x).iter().zip(&y).for_each(|(a, b)| assert!((a - b).abs() < 1e-9));
                // Back again.
                let back = Orders { rows: inverse(&orders.rows), columns: inverse(&orders.columns) };
                assert_eq!(back.apply(&stored).unwrap(), values);
            }
            assert!(Orders::new(Order::Rows, &image, n + 1, channels).is_err());
            assert_eq!(rows(&image, n + 1, channels), identity(n + 1));
        }
    }
    assert!(Orders { rows: vec![1], columns: vec![0] }.apply(&[1.0]).is_err());
    assert!(Orders { rows: vec![0], columns: vec![] }.apply(&[1.0]).is_err());
}

/// By hand: rows 0, 9, 1, 8, 2 one after another, and a tie between rows 1 and 2 that goes to the lower.
#[test]
fn the_nearest_row_comes_next() {
    let one = |values: [u8; 5]| -> Vec<u8> { values.iter().flat_map(|x| [*x, 0, 0, 0, 0]).collect() };
    assert_eq!(rows(&one([0, 9, 1, 8, 2]), 5, 1), [0, 2, 4, 3, 1]);
    assert_eq!(rows(&one([5, 7, 3, 7, 3]), 5, 1), [0, 1, 3, 2, 4]);
    assert_eq!(transpose(&[1, 2, 3, 4, 5, 6, 7, 8], 2, 2), [1, 2, 5, 6, 3, 4, 7, 8]);
}

#[test]
fn neighbours_of_a_room_are_nearer_in_order() {
    let scene = scene(8, 3);
    // As a voxeliser might give them: in no order at all.
    let mut random = Xorshift::new(2);
    let mut shuffled = identity(scene.n);
    (1..scene.n).for_each(|k| shuffled.swap(k, random.bits() as usize % (k + 1)));
    let orders = Orders { rows: shuffled.clone(), columns: shuffled };
    let operator = scene.polynomial(3).map(|channel| orders.apply(&channel).unwrap());
    let image = image(scene.n, &operator).unwrap();
    let across = transpose(&image, scene.n, 3);
    let sums = Order::ALL.map(|order| {
        let orders = Orders::new(order, &image, scene.n, 3).unwrap();
        let sums = [(&image, &orders.rows), (&across, &orders.columns)]
            .map(|(image, order)| neighbour_distance(image, scene.n, 3, order));
        println!("{}: L1 of neighbouring rows {}, columns {}", order.name(), sums[0], sums[1]);
        sums
    });
    let [none, rows, both, landmarks] = sums;
    assert!(rows[0] < none[0] / 2 && both[0] == rows[0] && both[1] < none[1] / 2);
    assert!((0..2).all(|k| landmarks[k] as f64 <= 1.1 * both[k] as f64), "{landmarks:?} {both:?}");
}
