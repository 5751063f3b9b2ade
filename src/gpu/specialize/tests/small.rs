//! Small modules written out by hand: loops, a switch, a call, a short circuit, and the same with damage.

use super::super::module::op;
use super::super::specialize;
use super::{assert_plain, assert_valid, count, instructions};

const VOID: u32 = 1;
const MAIN_TYPE: u32 = 2;
const UINT: u32 = 3;
const BOOL: u32 = 4;
const BLOCK: u32 = 5;
const BUFFER_POINTER: u32 = 6;
const PLACE_POINTER: u32 = 7;
const LOCAL_POINTER: u32 = 8;
const KIND_TYPE: u32 = 9;
const BUFFER: u32 = 10;
const U0: u32 = 11;
const U1: u32 = 12;
const U2: u32 = 13;
/// Specialization constant 0, false.
const FLAG: u32 = 14;
/// Specialization constant 1, the number 1.
const NUMBER: u32 = 15;
const MAIN: u32 = 16;
const ENTRY: u32 = 17;
const LOCAL: u32 = 18;
const PLACE: u32 = 19;
/// Has a name, which has to go with it.
const NAMED: u32 = 24;

const ENTRY_POINT: u32 = 15;
const EXECUTION_MODE: u32 = 16;
const TYPE_STRUCT: u32 = 30;
const TYPE_POINTER: u32 = 32;
const TYPE_FUNCTION: u32 = 33;
const ACCESS_CHAIN: u32 = 65;
const RETURN: u32 = 253;

type Code = [(u32, &'static [u32])];

/// A compute shader over one storage buffer with one uint, up to the first instructions of `main`.
const START: &Code = &[
    (op::CAPABILITY, &[1]),
    (op::MEMORY_MODEL, &[0, 1]),
    (ENTRY_POINT, &[5, MAIN, 0x6e69_616d, 0, BUFFER]),
    (EXECUTION_MODE, &[MAIN, 17, 1, 1, 1]),
    (op::NAME, &[NAMED, 0x61]),
    (op::DECORATE, &[FLAG, 1, 0]),
    (op::DECORATE, &[NUMBER, 1, 1]),
    (op::DECORATE, &[BLOCK, 2]),
    (op::MEMBER_DECORATE, &[BLOCK, 0, 35, 0]),
    (op::DECORATE, &[BUFFER, 33, 0]),
    (op::DECORATE, &[BUFFER, 34, 0]),
    (op::TYPE_VOID, &[VOID]),
    (TYPE_FUNCTION, &[MAIN_TYPE, VOID]),
    (op::TYPE_INT, &[UINT, 32, 0]),
    (op::TYPE_BOOL, &[BOOL]),
    (TYPE_STRUCT, &[BLOCK, UINT]),
    (TYPE_POINTER, &[BUFFER_POINTER, 12, BLOCK]),
    (TYPE_POINTER, &[PLACE_POINTER, 12, UINT]),
    (TYPE_POINTER, &[LOCAL_POINTER, 7, UINT]),
    (TYPE_FUNCTION, &[KIND_TYPE, UINT]),
    (op::VARIABLE, &[BUFFER_POINTER, BUFFER, 12]),
    (op::CONSTANT, &[UINT, U0, 0]),
    (op::CONSTANT, &[UINT, U1, 1]),
    (op::CONSTANT, &[UINT, U2, 2]),
    (op::SPEC_CONSTANT_FALSE, &[BOOL, FLAG]),
    (op::SPEC_CONSTANT, &[UINT, NUMBER, 1]),
    (op::FUNCTION, &[VOID, MAIN, 0, MAIN_TYPE]),
    (op::LABEL, &[ENTRY]),
    (op::VARIABLE, &[LOCAL_POINTER, LOCAL, 7]),
    (ACCESS_CHAIN, &[PLACE_POINTER, PLACE, BUFFER, U0]),
];

/// `while (FLAG) { .. }`, the continue construct two blocks long.
const WHILE: &Code = &[
    (op::BRANCH, &[20]),
    (op::LABEL, &[20]),
    (op::LOOP_MERGE, &[26, 22, 0]),
    (op::BRANCH, &[21]),
    (op::LABEL, &[21]),
    (op::BRANCH_CONDITIONAL, &[FLAG, NAMED, 26]),
    (op::LABEL, &[NAMED]),
    (op::I_ADD, &[UINT, 30, U1, U2]),
    (op::STORE, &[PLACE, 30]),
    (op::BRANCH, &[22]),
    (op::LABEL, &[22]),
    (op::BRANCH, &[23]),
    (op::LABEL, &[23]),
    (op::BRANCH, &[20]),
    (op::LABEL, &[26]),
    (op::STORE, &[PLACE, U1]),
    (RETURN, &[]),
    (op::FUNCTION_END, &[]),
];

/// `do { .. } while (FLAG);`
const DO_WHILE: &Code = &[
    (op::BRANCH, &[20]),
    (op::LABEL, &[20]),
    (op::LOOP_MERGE, &[26, 22, 0]),
    (op::BRANCH, &[NAMED]),
    (op::LABEL, &[NAMED]),
    (op::STORE, &[PLACE, U2]),
    (op::BRANCH, &[22]),
    (op::LABEL, &[22]),
    (op::BRANCH_CONDITIONAL, &[FLAG, 20, 26]),
    (op::LABEL, &[26]),
    (op::STORE, &[PLACE, U1]),
    (RETURN, &[]),
    (op::FUNCTION_END, &[]),
];

/// `switch (NUMBER)` whose case 1 has `if (..) break;`.
const SWITCH: &Code = &[
    (op::LOAD, &[UINT, 30, PLACE]),
    (op::U_LESS_THAN, &[BOOL, 31, 30, U2]),
    (op::SELECTION_MERGE, &[26, 0]),
    (op::SWITCH, &[NUMBER, 26, 1, NAMED, 2, 25]),
    (op::LABEL, &[NAMED]),
    (op::SELECTION_MERGE, &[22, 0]),
    (op::BRANCH_CONDITIONAL, &[31, 21, 22]),
    (op::LABEL, &[21]),
    (op::BRANCH, &[26]),
    (op::LABEL, &[22]),
    (op::STORE, &[PLACE, U0]),
    (op::BRANCH, &[26]),
    (op::LABEL, &[25]),
    (op::STORE, &[PLACE, U2]),
    (op::BRANCH, &[26]),
    (op::LABEL, &[26]),
    (RETURN, &[]),
    (op::FUNCTION_END, &[]),
];

/// `if (kind() == 1) { .. }` where `kind` is `FLAG ? NUMBER : buffer`, through a local variable in both functions.
const CALL: &Code = &[
    (op::FUNCTION_CALL, &[UINT, 30, 40]),
    (op::STORE, &[LOCAL, 30]),
    (op::LOAD, &[UINT, 31, LOCAL]),
    (op::I_EQUAL, &[BOOL, 32, 31, U1]),
    (op::SELECTION_MERGE, &[26, 0]),
    (op::BRANCH_CONDITIONAL, &[32, NAMED, 26]),
    (op::LABEL, &[NAMED]),
    (op::STORE, &[PLACE, U2]),
    (op::BRANCH, &[26]),
    (op::LABEL, &[26]),
    (RETURN, &[]),
    (op::FUNCTION_END, &[]),
    (op::FUNCTION, &[UINT, 40, 0, KIND_TYPE]),
    (op::LABEL, &[41]),
    (op::VARIABLE, &[LOCAL_POINTER, 42, 7]),
    (op::SELECTION_MERGE, &[45, 0]),
    (op::BRANCH_CONDITIONAL, &[FLAG, 43, 44]),
    (op::LABEL, &[43]),
    (op::STORE, &[42, NUMBER]),
    (op::BRANCH, &[45]),
    (op::LABEL, &[44]),
    (ACCESS_CHAIN, &[PLACE_POINTER, 46, BUFFER, U0]),
    (op::LOAD, &[UINT, 47, 46]),
    (op::STORE, &[42, 47]),
    (op::BRANCH, &[45]),
    (op::LABEL, &[45]),
    (op::LOAD, &[UINT, 48, 42]),
    (op::RETURN_VALUE, &[48]),
    (op::FUNCTION_END, &[]),
];

/// `if (FLAG && buffer < 2) { .. }` with a short circuit.
const SHORT_CIRCUIT: &Code = &[
    (op::SELECTION_MERGE, &[26, 0]),
    (op::BRANCH_CONDITIONAL, &[FLAG, NAMED, 26]),
    (op::LABEL, &[NAMED]),
    (op::LOAD, &[UINT, 30, PLACE]),
    (op::U_LESS_THAN, &[BOOL, 31, 30, U2]),
    (op::BRANCH, &[26]),
    (op::LABEL, &[26]),
    (op::PHI, &[BOOL, 33, FLAG, ENTRY, 31, NAMED]),
    (op::SELECTION_MERGE, &[28, 0]),
    (op::BRANCH_CONDITIONAL, &[33, 27, 28]),
    (op::LABEL, &[27]),
    (op::STORE, &[PLACE, U0]),
    (op::BRANCH, &[28]),
    (op::LABEL, &[28]),
    (RETURN, &[]),
    (op::FUNCTION_END, &[]),
];

fn assemble(body: &Code) -> Vec<u32> {
    let mut words = vec![0x0723_0203, 0x0001_0500, 0, 64, 0];
    for (code, operands) in START.iter().chain(body) {
        words.push(((operands.len() as u32 + 1) << 16) | code);
        words.extend(*operands);
    }
    words
}

/// Module, FLAG, NUMBER; then what is left: blocks, conditional branches, whether the named block is there.
const CASES: [(&str, &Code, u32, u32, usize, usize, bool); 14] = [
    ("while", WHILE, 0, 1, 5, 0, false),
    ("while", WHILE, 1, 1, 7, 0, true),
    ("do while", DO_WHILE, 0, 1, 5, 1, true),
    ("do while", DO_WHILE, 1, 1, 5, 0, true),
    ("switch", SWITCH, 0, 0, 2, 0, false),
    ("switch", SWITCH, 0, 1, 5, 1, true),
    ("switch", SWITCH, 0, 2, 3, 0, false),
    ("call", CALL, 0, 1, 6, 1, true),
    ("call", CALL, 1, 0, 5, 0, false),
    ("call", CALL, 1, 1, 6, 0, true),
    ("call", CALL, 1, 2, 5, 0, false),
    ("short circuit", SHORT_CIRCUIT, 0, 1, 3, 0, false),
    ("short circuit", SHORT_CIRCUIT, 1, 1, 5, 1, true),
    ("short circuit", SHORT_CIRCUIT, 7, 1, 5, 1, true),
];

#[test]
fn small_modules_lose_what_is_not_reached() {
    for (name, body, flag, number, blocks, branches, named) in CASES {
        let what = format!("{name} FLAG={flag} NUMBER={number}");
        let before = assemble(body);
        assert_valid(&before, &what);
        let after = specialize(&before, &[(0, flag), (1, number)]);
        assert_plain(&after, &what);
        assert_valid(&after, &what);
        assert_eq!(specialize(&after, &[]), after, "{what}: not the same when done again");
        assert_eq!(count(&after, op::LABEL), blocks, "{what}: blocks");
        assert_eq!(count(&after, op::BRANCH_CONDITIONAL), branches, "{what}: conditional branches");
        assert_eq!(count(&after, op::NAME), usize::from(named), "{what}: names");
        let is_number = |i: &(u32, &[u32])| i.0 == op::CONSTANT && *i.1 == [UINT, NUMBER, number];
        assert!(instructions(&after).iter().any(is_number), "{what}: NUMBER");
    }
}

#[test]
fn what_is_not_understood_comes_back_as_it_was() {
    let whole = assemble(SWITCH);
    assert_ne!(specialize(&whole, &[]), whole);
    let unknown: [&[u32]; 3] = [&whole[..5], &[(2 << 16) | 4999, 1], &whole[5..]];
    let unknown = unknown.concat();
    let cases: [&[u32]; 5] = [&[], &whole[..4], &whole[..whole.len() - 1], &whole[1..], &unknown];
    for damaged in cases {
        assert_eq!(specialize(damaged, &[(1, 2)]), damaged);
    }
}

#[test]
fn a_damaged_word_does_not_stop_the_program() {
    for (_, body, flag, number, ..) in CASES {
        let whole = assemble(body);
        for at in 0..whole.len() {
            for damage in [0, 1, NAMED, u32::MAX, (1 << 16) | op::PHI, (2 << 16) | op::LABEL, whole[at] ^ (1 << 16)] {
                let mut damaged = whole.clone();
                damaged[at] = damage;
                let _ = specialize(&damaged, &[(0, flag), (1, number)]);
            }
        }
    }
}
