use super::*;
use crate::math::random::Random;

fn wide(of: &[[f32; 3]]) -> Vec<[f64; 3]> {
    of.iter().map(|e| e.map(f64::from)).collect()
}

/// Symmetric, with falling values and holes, as exchanges between patches are.
fn matrix(count: usize) -> Vec<f32> {
    let mut random = Random::new(7);
    let mut elements = vec![0f32; count * count];
    for i in 0..count {
        for j in 0..i {
            let apart = (i - j) as f64 / count as f64;
            let open = (i / 16 + j / 16) % 3 != 0;
            let value = if open { (random.unit_f64() + 0.5) / (0.02 + apart * apart) } else { 0.0 };
            elements[i * count + j] = value as f32;
            elements[j * count + i] = value as f32;
        }
    }
    elements
}

fn exact(elements: &[f32], sent: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let of = |row: &[f32]| {
        let sum = |c: usize| row.iter().zip(sent).map(|(x, s)| f64::from(*x) * f64::from(s[c])).sum();
        [sum(0), sum(1), sum(2)]
    };
    elements.chunks(sent.len().max(1)).map(of).collect()
}

/// R7, R12: sizes that are no multiple of a block, one patch, none.
#[test]
fn rows_are_near_what_was_encoded_and_zeros_stay_zeros() {
    for count in [0, 1, 3, 5, 17, 64, 150] {
        let elements = matrix(count);
        let encoded = ZeroBlock::encode(&elements, &vec![1.0; count], 0.01);
        assert_eq!(encoded.residuals.len(), encoded.residual_offsets[count] as usize);
        let least = encoded.tables[0][0];
        for i in 0..count {
            let row = encoded.row(i);
            assert_eq!(row.len(), count);
            for (found, wanted) in row.iter().zip(&elements[i * count..]) {
                // What lies below the least that is told from 0 is the nearer of both.
                let bound = if *wanted < least { 0.51 * least } else { 0.3 * wanted };
                assert!((found - wanted).abs() <= bound, "{found} for {wanted}, least {least}");
            }
        }
        let sent: Vec<[f32; 3]> = (0..count).map(|j| [1.0, j as f32, 0.5]).collect();
        let off =
            super::super::relative_l2(&wide(&encoded.product(&sent, 32)), &exact(&elements, &sent), &vec![1.0; count]);
        // Values without any likeness to their neighbours are the worst there is.
        assert!(off < 0.02, "{count} patches: {off}");
    }
}

/// R7: blocks that are left out are those that a scan finds to be 0; an all-zero matrix has none.
#[test]
fn blocks_that_are_left_out_are_all_zero() {
    let count = 100;
    let elements = matrix(count);
    let encoded = ZeroBlock::encode(&elements, &vec![1.0; count], 0.0);
    for row in 0..encoded.side {
        let kept = &encoded.columns[encoded.offsets[row] as usize..encoded.offsets[row + 1] as usize];
        for column in 0..encoded.side {
            let holds = (0..16).any(|k| elements[(row * 4 + k / 4) * count + column * 4 + k % 4] > 0.0);
            assert_eq!(kept.contains(&(column as u16)), holds, "{row} {column}");
        }
    }
    let none = ZeroBlock::encode(&[0.0; 25], &[1.0; 5], 0.01);
    assert!(none.blocks.is_empty() && none.residuals.is_empty());
    assert_eq!(none.product(&[[1.0; 3]; 5], 8), vec![[0.0; 3]; 5]);
}

/// R10: an impulse comes back as one element and nothing else.
#[test]
fn an_impulse_stays_where_it_is() {
    let mut elements = vec![0f32; 81];
    (elements[2 * 9 + 7], elements[7 * 9 + 2]) = (3.0, 3.0);
    let encoded = ZeroBlock::encode(&elements, &[1.0; 9], 0.0);
    for i in 0..9 {
        for (j, x) in encoded.row(i).into_iter().enumerate() {
            let holds = (i, j) == (2, 7) || (i, j) == (7, 2);
            assert!(if holds { (x - 3.0).abs() < 1e-5 } else { x == 0.0 }, "{i} {j}: {x}");
        }
    }
}

/// R18: the number of residuals is that which was asked for, ties or none.
#[test]
fn ties_do_not_change_how_many_residuals_there_are() {
    let count = 64;
    let mut elements = matrix(count);
    elements.iter_mut().enumerate().for_each(|(at, x)| *x = if at % 3 == 0 { *x } else { 0.7 });
    for extract in [0.0, 0.01, 0.1] {
        let encoded = ZeroBlock::encode(&elements, &vec![1.0; count], extract);
        let wanted = ((count * count) as f64 * extract).round() as usize;
        assert_eq!(encoded.residuals.len(), wanted);
        assert_eq!(encoded.residual_offsets.last().copied(), Some(wanted as u32));
    }
}

/// R11: far apart in size.
#[test]
fn residuals_keep_their_digits_at_any_scale() {
    for scale in [1e-12f32, 1.0, 1e9] {
        let elements: Vec<f32> = matrix(40).iter().map(|x| x * scale).collect();
        let encoded = ZeroBlock::encode(&elements, &[1.0; 40], 0.05);
        let sent = vec![[1f32; 3]; 40];
        let off = super::super::relative_l2(&wide(&encoded.product(&sent, 8)), &exact(&elements, &sent), &[1.0; 40]);
        assert!(off < 0.01, "at {scale}: {off}");
    }
}
