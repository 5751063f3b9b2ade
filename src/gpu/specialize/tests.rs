//! Every program with several sets of values; `small` has modules for control flow that programs may come to have.

use std::collections::HashSet;
use std::io::{ErrorKind, Write};
use std::process::{Command, Stdio};

use super::constants::evaluate;
use super::module::op;
use super::specialize;
use crate::shaders::shade::forward;

mod small;

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
            op::SWITCH => operands[1..].iter().step_by(2).copied().collect(),
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
    for program in crate::shaders::ALL {
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
    // 116 and 17; up to 20 leaves room for a few that hang on no constant.
    assert!(after <= 20, "{after}");
}

#[test]
fn operations_have_the_values_of_the_specification() {
    let minus_one = u32::MAX;
    type Case<'a> = (u32, &'a [Option<u32>], Option<u32>);
    let cases: [Case<'_>; 15] = [
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
