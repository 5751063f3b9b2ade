//! What a module can reach: variables that functions name which the entry points call, on whatever way. What is left of a specialised module
//! needs no other descriptor.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::module::{Instruction, Module, op};

/// Decorations: `Binding` and `DescriptorSet`.
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
/// Decoration `BuiltIn`, and the one of fragments' sample masks.
const BUILT_IN: u32 = 11;
const SAMPLE_MASK: u32 = 20;
const ENTRY_POINT: u32 = 15;

/// (set, binding) of every variable that is reached; `None` for a module that cannot be taken apart.
pub fn used_bindings(words: &[u32]) -> Option<BTreeSet<(u32, u32)>> {
    let module = Module::parse(words)?;
    let mut places: HashMap<u32, [Option<u32>; 2]> = HashMap::new();
    for Instruction { op: code, operands } in &module.globals {
        match (*code, &operands[..]) {
            (op::DECORATE, &[id, DESCRIPTOR_SET, set, ..]) => places.entry(id).or_default()[0] = Some(set),
            (op::DECORATE, &[id, BINDING, binding, ..]) => places.entry(id).or_default()[1] = Some(binding),
            _ => {}
        }
    }
    let (_, named) = reached(&module);
    let reached = places.iter().filter(|(id, _)| named.contains(id));
    Some(reached.filter_map(|(_, place)| place[0].zip(place[1])).collect())
}

/// Ids of the functions that the entry points call, on whatever way, and every word of these. A literal that happens to equal an id makes that
/// count as named, which is safe.
fn reached(module: &Module) -> (HashSet<u32>, HashSet<u32>) {
    let entry = |i: &Instruction| (i.op == ENTRY_POINT).then(|| i.operands.get(1).copied()).flatten();
    let mut open: Vec<u32> = module.globals.iter().filter_map(entry).collect();
    let places: HashMap<u32, usize> =
        module.functions.iter().enumerate().filter_map(|(at, function)| Some((function.id()?, at))).collect();
    let (mut seen, mut named) = (HashSet::new(), HashSet::new());
    while let Some(id) = open.pop() {
        let Some(&place) = places.get(&id).filter(|_| seen.insert(id)) else { continue };
        for instruction in module.functions[place].blocks.iter().flat_map(|block| &block.body) {
            if instruction.op == op::FUNCTION_CALL {
                open.extend(instruction.operands.get(2));
            }
            named.extend(&instruction.operands);
        }
    }
    (seen, named)
}

/// Leaves out the functions that nobody calls.
pub fn drop_uncalled(module: &mut Module) {
    let (called, _) = reached(module);
    module.functions.retain(|function| function.id().is_some_and(|id| called.contains(&id)));
}

/// Takes sample masks that nothing writes any more out of the interface: SwiftShader takes one that is declared for the coverage, whatever is
/// in it.
pub fn drop_sample_masks(module: &mut Module) {
    let (_, named) = reached(module);
    let is_mask = |i: &Instruction| match i.operands[..] {
        [id, BUILT_IN, SAMPLE_MASK, ..] if i.op == op::DECORATE && !named.contains(&id) => Some(id),
        _ => None,
    };
    let Some(mask) = module.globals.iter().find_map(is_mask) else { return };
    module.globals.retain(|i| i.annotated() != Some(mask) && !(i.op == op::VARIABLE && i.operands[1] == mask));
    for entry in module.globals.iter_mut().filter(|i| i.op == ENTRY_POINT) {
        // The name comes third; ids of the interface follow its last word, which ends with a zero byte.
        let name = entry.operands.iter().skip(2).position(|word| word >> 24 == 0).map_or(0, |at| at + 3);
        let interface = entry.operands.split_off(name);
        entry.operands.extend(interface.into_iter().filter(|&id| id != mask));
    }
}
