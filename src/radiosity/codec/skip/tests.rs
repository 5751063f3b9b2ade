use super::super::test_scene::Xorshift;
use super::*;

#[test]
fn r7_ranks_equal_a_scan() {
    let mut random = Xorshift::new(7);
    for count in [0, 1, 31, 32, 33, 64, 1000] {
        for share in [0, 1, 2, 3] {
            let stored: Vec<bool> = (0..count).map(|_| random.bits() % 3 < share).collect();
            let list = Stored::new(stored.iter().copied());
            let mut next = 0;
            for (number, is_stored) in stored.iter().enumerate() {
                assert_eq!(list.find(number), is_stored.then_some(next));
                next += usize::from(*is_stored);
            }
            assert_eq!(list.find(stored.len().next_multiple_of(32)), None);
            assert_eq!(list.bytes(), 8 * stored.len().div_ceil(32));
        }
    }
}
