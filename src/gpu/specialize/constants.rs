//! Specialization constants become constants, and what operations on known values give.

use std::collections::{HashMap, HashSet};

use super::module::{Instruction, op};

/// Decoration that gives a constant its id for the host.
const SPEC_ID: u32 = 1;

/// What types and constants say, and what has been found out from them.
#[derive(Debug, Default)]
pub struct Facts {
    /// Every type.
    pub types: HashSet<u32>,
    /// Types whose values are followed: bool, and integers of 32 bits.
    pub followed: HashSet<u32>,
    /// Ids with a known value of such a type; a bool is 0 or 1.
    pub known: HashMap<u32, u32>,
    bools: HashSet<u32>,
    /// Scalars of 32 bits.
    words: HashSet<u32>,
    /// Parts of composite constants.
    parts: HashMap<u32, Vec<u32>>,
}

impl Facts {
    fn note_type(&mut self, i: &Instruction) {
        if !(op::TYPE_VOID..=op::TYPE_FORWARD_POINTER).contains(&i.op) {
            return;
        }
        let id = i.operands[0];
        self.types.insert(id);
        match i.op {
            op::TYPE_BOOL => {
                self.bools.insert(id);
                self.followed.insert(id);
            }
            op::TYPE_INT if i.operands[1] == 32 => {
                self.words.insert(id);
                self.followed.insert(id);
            }
            op::TYPE_FLOAT if i.operands[1] == 32 => {
                self.words.insert(id);
            }
            _ => {}
        }
    }

    fn note_constant(&mut self, i: &Instruction) {
        let bits = match (i.op, &i.operands[..]) {
            (op::CONSTANT_TRUE, _) => 1,
            (op::CONSTANT_FALSE | op::CONSTANT_NULL, _) => 0,
            (op::CONSTANT, &[_, _, bits]) => bits,
            (op::CONSTANT_COMPOSITE, [_, id, parts @ ..]) => {
                self.parts.insert(*id, parts.to_vec());
                return;
            }
            _ => return,
        };
        if self.followed.contains(&i.operands[0]) {
            self.known.insert(i.operands[1], bits);
        }
    }

    /// A part of a composite constant, where it is known.
    fn part(&self, composite: u32, index: u32) -> Option<u32> {
        self.known.get(self.parts.get(&composite)?.get(index as usize)?).copied()
    }

    /// Value of the operation `code` with this result type.
    pub fn evaluate(&self, kind: u32, code: u32, operands: &[u32]) -> Option<u32> {
        if !self.followed.contains(&kind) {
            return None;
        }
        // Operands that are literals are looked up too; no operation that `evaluate` knows has any.
        let values: Vec<_> = operands.iter().map(|id| self.known.get(id).copied()).collect();
        evaluate(code, &values)
    }
}

fn has_id(i: &Instruction) -> bool {
    i.op == op::DECORATE && i.operands[1] == SPEC_ID
}

/// Gives every specialization constant its value, from `values` by its id or its default, and takes the ids away.
///
/// `None` where a constant is not of 32 bits. An operation that is not understood stays: over plain constants it is valid.
pub fn freeze(globals: &mut Vec<Instruction>, values: &[(u32, u32)]) -> Option<Facts> {
    let mut given = HashMap::new();
    for i in globals.iter().filter(|i| has_id(i)) {
        let constant_id = i.operands.get(2)?;
        if let Some((_, bits)) = values.iter().find(|(id, _)| id == constant_id) {
            given.insert(i.operands[0], *bits);
        }
    }
    globals.retain(|i| !has_id(i));
    let mut facts = Facts::default();
    let mut still_special = HashSet::new();
    for i in globals.iter_mut() {
        facts.note_type(i);
        if !make_plain(i, &given, &facts, &still_special)? {
            still_special.insert(i.operands[1]);
        }
        facts.note_constant(i);
    }
    Some(facts)
}

/// Whether the instruction is not, or no longer, a specialization constant.
fn make_plain(
    i: &mut Instruction,
    given: &HashMap<u32, u32>,
    facts: &Facts,
    still_special: &HashSet<u32>,
) -> Option<bool> {
    let bool_constant = |bits: u32| if bits == 0 { op::CONSTANT_FALSE } else { op::CONSTANT_TRUE };
    match i.op {
        op::SPEC_CONSTANT_TRUE | op::SPEC_CONSTANT_FALSE => {
            let default = u32::from(i.op == op::SPEC_CONSTANT_TRUE);
            i.op = bool_constant(given.get(&i.operands[1]).copied().unwrap_or(default));
        }
        op::SPEC_CONSTANT => {
            if i.operands.len() != 3 || !facts.words.contains(&i.operands[0]) {
                return None;
            }
            i.op = op::CONSTANT;
            if let Some(&bits) = given.get(&i.operands[1]) {
                i.operands[2] = bits;
            }
        }
        op::SPEC_CONSTANT_COMPOSITE => {
            if i.operands[2..].iter().any(|part| still_special.contains(part)) {
                return Some(false);
            }
            i.op = op::CONSTANT_COMPOSITE;
        }
        op::SPEC_CONSTANT_OP => {
            let (kind, id) = (i.operands[0], i.operands[1]);
            let bits = match i.operands[2..] {
                // Of the size of a group, for one.
                [op::COMPOSITE_EXTRACT, composite, index] => facts.part(composite, index),
                [code, ..] => facts.evaluate(kind, code, &i.operands[3..]),
                [] => None,
            };
            let Some(bits) = bits else { return Some(false) };
            *i = if facts.bools.contains(&kind) {
                Instruction::new(bool_constant(bits), vec![kind, id])
            } else {
                Instruction::new(op::CONSTANT, vec![kind, id, bits])
            };
        }
        _ => {}
    }
    Some(true)
}

/// Value of an operation on bools (0 or 1) and integers of 32 bits; `None` where an operand that matters is not known, where
/// SPIR-V leaves the value undefined, and for every other operation.
pub fn evaluate(code: u32, operands: &[Option<u32>]) -> Option<u32> {
    match (code, operands) {
        (op::LOGICAL_AND, [Some(0), _] | [_, Some(0)]) => Some(0),
        (op::LOGICAL_OR, [Some(1), _] | [_, Some(1)]) => Some(1),
        (op::SELECT, &[Some(condition), yes, no]) => {
            if condition == 0 {
                no
            } else {
                yes
            }
        }
        (_, &[Some(a)]) => unary(code, a),
        (_, &[Some(a), Some(b)]) => binary(code, a, b),
        _ => None,
    }
}

fn unary(code: u32, a: u32) -> Option<u32> {
    match code {
        op::COPY_OBJECT | op::BITCAST => Some(a),
        op::LOGICAL_NOT => Some(a ^ 1),
        op::NOT => Some(!a),
        op::S_NEGATE => Some(a.wrapping_neg()),
        _ => None,
    }
}

fn binary(code: u32, a: u32, b: u32) -> Option<u32> {
    let (signed_a, signed_b) = (a as i32, b as i32);
    let value = match code {
        op::I_ADD => a.wrapping_add(b),
        op::I_SUB => a.wrapping_sub(b),
        op::I_MUL => a.wrapping_mul(b),
        op::LOGICAL_EQUAL | op::I_EQUAL => u32::from(a == b),
        op::LOGICAL_NOT_EQUAL | op::I_NOT_EQUAL => u32::from(a != b),
        op::U_GREATER_THAN => u32::from(a > b),
        op::S_GREATER_THAN => u32::from(signed_a > signed_b),
        op::U_GREATER_THAN_EQUAL => u32::from(a >= b),
        op::S_GREATER_THAN_EQUAL => u32::from(signed_a >= signed_b),
        op::U_LESS_THAN => u32::from(a < b),
        op::S_LESS_THAN => u32::from(signed_a < signed_b),
        op::U_LESS_THAN_EQUAL => u32::from(a <= b),
        op::S_LESS_THAN_EQUAL => u32::from(signed_a <= signed_b),
        op::SHIFT_RIGHT_LOGICAL => a.checked_shr(b)?,
        op::SHIFT_RIGHT_ARITHMETIC => signed_a.checked_shr(b)? as u32,
        op::SHIFT_LEFT_LOGICAL => a.checked_shl(b)?,
        op::LOGICAL_OR | op::BITWISE_OR => a | b,
        op::LOGICAL_AND | op::BITWISE_AND => a & b,
        op::BITWISE_XOR => a ^ b,
        _ => return None,
    };
    Some(value)
}
