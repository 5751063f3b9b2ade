//! Every program with several sets of values, and small modules for control flow that programs may come to have.

use std::collections::HashSet;
use std::io::{ErrorKind, Write};
use std::process::{Command, Stdio};

use super::constants::evaluate;
use super::module::op;
use super::specialize;
use crate::graph::program::Program;
use crate::shaders::shade::forward;
use crate::shaders::{depth, prim, shade};

static PROGRAMS: [&Program; 7] = [
    &depth::depth_prepass::PROGRAM,
    &depth::depth_prepass_masked::PROGRAM,
    &prim::layout_probe::PROGRAM,
    &prim::write_index::PROGRAM,
    &shade::ceiling::PROGRAM,
    &shade::forward::PROGRAM,
    &shade::surface::PROGRAM,
];

/// Point lights through a texel buffer on plain Lambert surfaces: the least work that a variant does with lights.
fn plain_lambert() -> forward::Spec {
    forward::Spec {
        LIGHT_FETCH: 2,
        LIGHT_KINDS: 1,
        LIGHT_TEXELS: 2,
        LIGHT_SEEK: false,
        SHADING: 0,
        TEXTURES: 0,
        ..forward::Spec::default()
    }
}

fn value_sets() -> Vec<Vec<(u32, u32)>> {
    let everything = forward::Spec {
        LIGHT_UNIFORM_TEXELS: 64,
        INVERSE_SQUARE: false,
        TEXTURES: 31,
        ALPHA_MASK: true,
        UV_SETS: 0xffff,
        UV_TRANSFORMS: true,
        VERTEX_COLORS: true,
        MIRRORED_LENS: true,
        ..forward::Spec::default()
    };
    let phong_spots = forward::Spec {
        LIGHT_FETCH: 1,
        LIGHT_KINDS: 2,
        LIGHT_UNIFORM_TEXELS: 1000,
        SHADING: 1,
        UNLIT: true,
        ..forward::Spec::default()
    };
    let no_lights = forward::Spec { LIGHT_KINDS: 0, ..plain_lambert() };
    let specs = [forward::Spec::default(), plain_lambert(), everything, phong_spots, no_lights];
    specs.iter().map(forward::Spec::values).chain([Vec::new()]).collect()
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// (opcode, operands) of each instruction.
fn instructions(words: &[u32]) -> Vec<(u32, &[u32])> {
    let (mut found, mut rest) = (Vec::new(), &words[5..]);
    while let Some(&first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        found.push((first & 0xffff, &instruction[1..]));
        rest = after;
    }
    found
}

fn count(words: &[u32], code: u32) -> usize {
    instructions(words).iter().filter(|i| i.0 == code).count()
}

fn assert_valid(words: &[u32], what: &str) {
    let mut command = Command::new("spirv-val");
    command.args(["--target-env", "vulkan1.2", "--scalar-block-layout"]);
    let started = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = match started {
        Err(e) if e.kind() == ErrorKind::NotFound => {
            println!("spirv-val is not there");
            return;
        }
        started => started.expect("spirv-val starts"),
    };
    child.stdin.take().expect("a pipe").write_all(bytemuck::cast_slice(words)).expect("spirv-val reads");
    let output = child.wait_with_output().expect("spirv-val ends");
    assert!(
        output.status.success(),
        "{what}: {}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

/// No specialization constant is left, every label that is named exists, no branch but a loop's own has a constant condition.
fn assert_plain(words: &[u32], what: &str) {
    let all = instructions(words);
    let labels: HashSet<u32> = all.iter().filter(|i| i.0 == op::LABEL).map(|i| i.1[0]).collect();
    let constants: HashSet<u32> =
        all.iter().filter(|i| matches!(i.0, op::CONSTANT_TRUE | op::CONSTANT_FALSE)).map(|i| i.1[1]).collect();
    for (at, (code, operands)) in all.iter().enumerate() {
        assert!(!(op::SPEC_CONSTANT_TRUE..=op::SPEC_CONSTANT_OP).contains(code), "{what}: opcode {code}");
        assert!(*code != op::DECORATE || operands[1] != 1, "{what}: SpecId of {}", operands[0]);
        let named: Vec<u32> = match *code {
            op::BRANCH | op::SELECTION_MERGE => vec![operands[0]],
            op::LOOP_MERGE => vec![operands[0], operands[1]],
            op::BRANCH_CONDITIONAL => vec![operands[1], operands[2]],
            op::PHI => operands[2..].iter().skip(1).step_by(2).copied().collect(),
            _ => Vec::new(),
        };
        assert!(named.iter().all(|label| labels.contains(label)), "{what}: {named:?}");
        if *code == op::BRANCH_CONDITIONAL && all[at - 1].0 == op::SELECTION_MERGE {
            assert!(!constants.contains(&operands[0]), "{what}: a branch on a constant");
        }
    }
}

#[test]
fn every_program_becomes_plain_and_valid() {
    for program in PROGRAMS {
        for stage in program.stages {
            let before = words(stage.spirv);
            for values in value_sets() {
                let what = format!("{} {:?} {values:?}", program.name, stage.stage);
                let after = specialize(&before, &values);
                assert_plain(&after, &what);
                assert_valid(&after, &what);
                assert_eq!(specialize(&after, &values), after, "{what}: not the same when done again");
            }
        }
    }
}

#[test]
fn plain_lambert_keeps_few_branches() {
    let before = words(forward::PROGRAM.stages[1].spirv);
    let after = specialize(&before, &plain_lambert().values());
    let (before, after) = (count(&before, op::BRANCH_CONDITIONAL), count(&after, op::BRANCH_CONDITIONAL));
    println!("forward.frag: {before} conditional branches, {after} specialised");
    // 43 and 16 when this was written; branches on constants alone are 24.
    assert!(after <= 20, "{after}");
}

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
        let constants = instructions(&after);
        assert!(constants.contains(&(op::CONSTANT, &[UINT, NUMBER, number])), "{what}: NUMBER");
    }
}

#[test]
fn operations_have_the_values_of_the_specification() {
    let minus_one = u32::MAX;
    let cases: [(u32, &[Option<u32>], Option<u32>); 15] = [
        (op::I_ADD, &[Some(minus_one), Some(2)], Some(1)),
        (op::I_SUB, &[Some(0), Some(1)], Some(minus_one)),
        (op::S_LESS_THAN, &[Some(minus_one), Some(0)], Some(1)),
        (op::U_LESS_THAN, &[Some(minus_one), Some(0)], Some(0)),
        (op::SHIFT_LEFT_LOGICAL, &[Some(1), Some(31)], Some(1 << 31)),
        (op::SHIFT_LEFT_LOGICAL, &[Some(1), Some(32)], None),
        (op::SHIFT_RIGHT_ARITHMETIC, &[Some(minus_one), Some(4)], Some(minus_one)),
        (op::SHIFT_RIGHT_LOGICAL, &[Some(minus_one), Some(4)], Some(minus_one >> 4)),
        (op::LOGICAL_NOT, &[Some(1)], Some(0)),
        (op::NOT, &[Some(1)], Some(minus_one - 1)),
        (op::LOGICAL_AND, &[None, Some(0)], Some(0)),
        (op::LOGICAL_AND, &[None, Some(1)], None),
        (op::LOGICAL_OR, &[Some(1), None], Some(1)),
        (op::SELECT, &[Some(0), None, Some(7)], Some(7)),
        (op::SELECT, &[Some(1), None, Some(7)], None),
    ];
    for (code, operands, value) in cases {
        assert_eq!(evaluate(code, operands), value, "opcode {code} of {operands:?}");
    }
}

#[test]
fn what_is_not_understood_comes_back_as_it_was() {
    let whole = assemble(SWITCH);
    assert_ne!(specialize(&whole, &[]), whole);
    let mut foreign = whole.clone();
    foreign.splice(5..5, [(2 << 16) | 4999, 1]);
    for damaged in [&[], &whole[..4], &whole[..whole.len() - 1], &whole[1..], &foreign] {
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
