//! Which bindings a module can reach: those of variables that functions name which the entry points call, on whatever way. What is left of a
//! specialised module needs no other descriptor.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::module::{Instruction, Module, op};

/// Decorations: `Binding` and `DescriptorSet`.
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const ENTRY_POINT: u32 = 15;

/// (set, binding) of every variable that is reached; `None` for a module that cannot be taken apart.
pub fn used_bindings(words: &[u32]) -> Option<BTreeSet<(u32, u32)>> {
    let module = Module::parse(words)?;
    let mut places: HashMap<u32, [Option<u32>; 2]> = HashMap::new();
    let mut reached = Vec::new();
    for Instruction { op: code, operands } in &module.globals {
        match (*code, &operands[..]) {
            (op::DECORATE, &[id, DESCRIPTOR_SET, set, ..]) => places.entry(id).or_default()[0] = Some(set),
            (op::DECORATE, &[id, BINDING, binding, ..]) => places.entry(id).or_default()[1] = Some(binding),
            (ENTRY_POINT, &[_, function, ..]) => reached.push(function),
            _ => {}
        }
    }
    let ids: HashMap<u32, usize> = module
        .functions
        .iter()
        .enumerate()
        .filter_map(|(at, f)| Some((*f.head.first()?.operands.get(1)?, at)))
        .collect();
    let mut seen = HashSet::new();
    let mut used = BTreeSet::new();
    while let Some(id) = reached.pop() {
        let Some(function) = ids.get(&id).filter(|_| seen.insert(id)).map(|&at| &module.functions[at]) else {
            continue;
        };
        for instruction in function.blocks.iter().flat_map(|block| &block.body) {
            if instruction.op == op::FUNCTION_CALL {
                reached.extend(instruction.operands.get(2));
            }
            // A literal that happens to equal an id makes a binding count as used, which is safe.
            for operand in &instruction.operands {
                if let Some([Some(set), Some(binding)]) = places.get(operand) {
                    used.insert((*set, *binding));
                }
            }
        }
    }
    Some(used)
}
