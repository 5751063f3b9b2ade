use super::*;

/// A value and the code nearest to it are half a step apart at most; codes that tables have come back as they are.
#[test]
fn codes_and_tables_agree() {
    for top in [1.0, 3e-7, 1e5] {
        for logarithm in [Logarithm::thesis(top), Logarithm { top, step: 10.0 / 254.0 }] {
            let table = logarithm.table();
            assert_eq!((table[0], table[255]), (0.0, top as f32));
            for code in 1..=255u8 {
                assert_eq!(logarithm.code(table[usize::from(code)].into()), code);
                assert!(table[usize::from(code)] > table[usize::from(code) - 1]);
            }
        }
    }
}

#[test]
fn r7_the_logarithm_of_zero_is_code_0_and_that_is_zero() {
    let logarithm = Logarithm::thesis(1.0);
    for x in [0.0, -1.0, -0.0, f64::NAN, f64::NEG_INFINITY, 1e-300] {
        assert_eq!((logarithm.code(x), logarithm.real_code(x)), (0, 0.0), "{x}");
    }
    assert_eq!(logarithm.table()[0].to_bits(), 0);
    let empty = Logarithm::thesis(0.0);
    assert_eq!((empty.code(1.0), empty.code(0.0)), (0, 0));
    assert_eq!(empty.table(), [0.0; 256]);
}
