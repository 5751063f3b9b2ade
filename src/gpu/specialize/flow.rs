//! Branches with a known condition, and blocks that nothing reaches. SPIR-V specification, section 2.11 (structured control flow).

use std::collections::{HashMap, HashSet};

use super::module::{Block, Function, Instruction, op};

/// Replaces branches whose condition is known; whether there were any. Blocks stay, [`prune`] removes them.
///
/// Left alone are a branch that is a loop's header, which has to name the loop's blocks, and one that would lose its way
/// back to an earlier block, since a loop without a back edge is invalid.
pub fn resolve(function: &mut Function, known: &HashMap<u32, u32>) -> bool {
    let places: HashMap<u32, usize> = function.blocks.iter().enumerate().map(|(at, b)| (b.label, at)).collect();
    let mut changed = false;
    for (at, block) in function.blocks.iter_mut().enumerate() {
        if block.merge.as_ref().is_some_and(|m| m.op == op::LOOP_MERGE) {
            continue;
        }
        let operands = &mut block.terminator.operands;
        let Some(&bits) = operands.first().and_then(|id| known.get(id)) else { continue };
        match block.terminator.op {
            op::BRANCH_CONDITIONAL => {
                let (taken, dropped) = if bits == 0 { (operands[2], operands[1]) } else { (operands[1], operands[2]) };
                if places.get(&dropped).is_none_or(|&place| place <= at) {
                    continue;
                }
                block.terminator = Instruction::new(op::BRANCH, vec![taken]);
                block.merge = None;
                changed = true;
            }
            // A switch stays, with a default alone: branches inside may leave it by its merge block, which only a construct has.
            op::SWITCH if operands.len() > 2 => {
                let case = operands[2..].chunks_exact(2).find(|case| case[0] == bits);
                let taken = case.map_or(operands[1], |case| case[1]);
                operands.truncate(1);
                operands.push(taken);
                changed = true;
            }
            _ => {}
        }
    }
    changed
}

/// Labels that control can reach; `None` where a branch goes to a block that is not there.
fn reached(blocks: &[Block]) -> Option<HashSet<u32>> {
    let by_label: HashMap<u32, &Block> = blocks.iter().map(|b| (b.label, b)).collect();
    let mut reached = HashSet::new();
    let mut next: Vec<u32> = blocks.first().map(|b| b.label).into_iter().collect();
    while let Some(label) = next.pop() {
        if reached.insert(label) {
            next.extend(by_label.get(&label)?.terminator.targets());
        }
    }
    Some(reached)
}

/// Removes the blocks that nothing reaches, and phi operands that came from them. Of those that a remaining header names, a
/// continue target becomes a branch back to the header, a merge block the end of the invocation.
///
/// `None` for what is not understood: a phi would lack the value that came from such a continue target.
pub fn prune(function: &mut Function) -> Option<()> {
    let reached = reached(&function.blocks)?;
    let mut merges = HashSet::new();
    let mut header_of = HashMap::new();
    for block in function.blocks.iter().filter(|b| reached.contains(&b.label)) {
        let Some(merge) = &block.merge else { continue };
        merges.insert(merge.operands[0]);
        if merge.op == op::LOOP_MERGE {
            let continue_target = merge.operands[1];
            if !reached.contains(&continue_target) && block.body.iter().any(|i| i.op == op::PHI) {
                return None;
            }
            header_of.insert(continue_target, block.label);
        }
    }
    function.blocks.retain_mut(|block| {
        if reached.contains(&block.label) {
            return true;
        }
        block.body.clear();
        block.merge = None;
        if let Some(&header) = header_of.get(&block.label) {
            block.terminator = Instruction::new(op::BRANCH, vec![header]);
            true
        } else {
            block.terminator = Instruction::new(op::UNREACHABLE, Vec::new());
            merges.contains(&block.label)
        }
    });
    drop_phi_operands(function);
    Some(())
}

/// Keeps the (value, predecessor) pairs whose predecessor still branches here.
fn drop_phi_operands(function: &mut Function) {
    let edges_of = |b: &Block| b.terminator.targets().into_iter().map(|to| (b.label, to)).collect::<Vec<_>>();
    let edges: HashSet<(u32, u32)> = function.blocks.iter().flat_map(edges_of).collect();
    for block in &mut function.blocks {
        let label = block.label;
        for phi in block.body.iter_mut().filter(|i| i.op == op::PHI) {
            let (result, incoming) = phi.operands.split_at(2);
            let kept = incoming.chunks_exact(2).filter(|pair| edges.contains(&(pair[1], label))).flatten();
            phi.operands = result.iter().chain(kept).copied().collect();
        }
    }
}
