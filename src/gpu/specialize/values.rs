//! Which results of a function's instructions are known.

use std::collections::HashMap;

use super::constants::Facts;
use super::module::{Function, op};

/// What a local variable holds whenever it is read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Held {
    /// No store yet.
    Nothing,
    /// All stores put this in; a read before them would be undefined, so it may give this too.
    Value(u32),
    /// Not known.
    Anything,
}

impl Held {
    fn and(self, stored: Option<&u32>) -> Self {
        match (self, stored) {
            (Self::Nothing, Some(&bits)) => Self::Value(bits),
            (Self::Value(held), Some(&bits)) if held == bits => self,
            _ => Self::Anything,
        }
    }
}

/// Local variables by id. One whose pointer goes anywhere but into loads and stores may hold anything.
fn variables(function: &Function, known: &HashMap<u32, u32>) -> HashMap<u32, Held> {
    let mut held: HashMap<u32, Held> = HashMap::new();
    for i in function.blocks.iter().flat_map(|b| &b.body) {
        // Literals that look like an id only cost a variable that could have been followed.
        let pointers_leave_by: &[u32] = match i.op {
            op::VARIABLE => {
                let initial = i.operands.get(3).map(|id| Held::Nothing.and(known.get(id)));
                held.insert(i.operands[1], initial.unwrap_or(Held::Nothing));
                &[]
            }
            op::STORE => {
                if let Some(variable) = held.get_mut(&i.operands[0]) {
                    *variable = variable.and(known.get(&i.operands[1]));
                }
                &i.operands[1..]
            }
            op::LOAD | op::LINE => &[],
            _ => &i.operands[..],
        };
        for id in pointers_leave_by {
            if let Some(variable) = held.get_mut(id) {
                *variable = Held::Anything;
            }
        }
    }
    held
}

/// The value that all of them are known to have.
fn agreed(ids: impl Iterator<Item = u32>, known: &HashMap<u32, u32>) -> Option<u32> {
    let mut common: Option<u32> = None;
    for id in ids {
        let bits = *known.get(&id)?;
        if common.is_some_and(|c| c != bits) {
            return None;
        }
        common = Some(bits);
    }
    common
}

/// Adds the results of this function's instructions that have become known to `facts`, and its own value, where it returns
/// only one, to `returns`; whether there were any.
pub fn learn(function: &Function, facts: &mut Facts, returns: &mut HashMap<u32, u32>) -> bool {
    let held = variables(function, &facts.known);
    let mut learned = false;
    for i in function.blocks.iter().flat_map(|b| &b.body) {
        let Some((kind, id)) = i.result(&facts.types) else { continue };
        if !facts.followed.contains(&kind) || facts.known.contains_key(&id) {
            continue;
        }
        let value = match i.op {
            op::LOAD => match held.get(&i.operands[2]) {
                Some(&Held::Value(bits)) => Some(bits),
                _ => None,
            },
            op::FUNCTION_CALL => returns.get(&i.operands[2]).copied(),
            op::PHI => agreed(i.operands[2..].iter().step_by(2).copied(), &facts.known),
            code => facts.evaluate(kind, code, &i.operands[2..]),
        };
        if let Some(bits) = value {
            facts.known.insert(id, bits);
            learned = true;
        }
    }
    let returned = function.blocks.iter().map(|b| &b.terminator).filter(|t| t.op == op::RETURN_VALUE);
    let value = agreed(returned.map(|t| t.operands[0]), &facts.known);
    if let (Some(bits), Some(&id)) = (value, function.head[0].operands.get(1)) {
        learned |= returns.insert(id, bits).is_none();
    }
    learned
}
