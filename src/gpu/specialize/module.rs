//! A SPIR-V module taken apart, and put together again. Opcodes and layout: SPIR-V specification, sections 2.3, 2.4 and 3.

use std::collections::HashSet;

const MAGIC: u32 = 0x0723_0203;
const HEADER_WORDS: usize = 5;

/// Opcodes by their names without `Op`.
pub mod op {
    #![allow(missing_docs)]
    pub const NAME: u32 = 5;
    pub const MEMBER_NAME: u32 = 6;
    pub const LINE: u32 = 8;
    pub const EXT_INST_IMPORT: u32 = 11;
    pub const MEMORY_MODEL: u32 = 14;
    pub const CAPABILITY: u32 = 17;
    pub const TYPE_VOID: u32 = 19;
    pub const TYPE_BOOL: u32 = 20;
    pub const TYPE_INT: u32 = 21;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_FORWARD_POINTER: u32 = 39;
    pub const CONSTANT_TRUE: u32 = 41;
    pub const CONSTANT_FALSE: u32 = 42;
    pub const CONSTANT: u32 = 43;
    pub const CONSTANT_COMPOSITE: u32 = 44;
    pub const CONSTANT_NULL: u32 = 46;
    pub const SPEC_CONSTANT_TRUE: u32 = 48;
    pub const SPEC_CONSTANT_FALSE: u32 = 49;
    pub const SPEC_CONSTANT: u32 = 50;
    pub const SPEC_CONSTANT_COMPOSITE: u32 = 51;
    pub const SPEC_CONSTANT_OP: u32 = 52;
    pub const FUNCTION: u32 = 54;
    pub const FUNCTION_END: u32 = 56;
    pub const FUNCTION_CALL: u32 = 57;
    pub const VARIABLE: u32 = 59;
    pub const LOAD: u32 = 61;
    pub const STORE: u32 = 62;
    pub const DECORATE: u32 = 71;
    pub const MEMBER_DECORATE: u32 = 72;
    pub const COMPOSITE_EXTRACT: u32 = 81;
    pub const COPY_OBJECT: u32 = 83;
    pub const BITCAST: u32 = 124;
    pub const S_NEGATE: u32 = 126;
    pub const I_ADD: u32 = 128;
    pub const I_SUB: u32 = 130;
    pub const I_MUL: u32 = 132;
    pub const LOGICAL_EQUAL: u32 = 164;
    pub const LOGICAL_NOT_EQUAL: u32 = 165;
    pub const LOGICAL_OR: u32 = 166;
    pub const LOGICAL_AND: u32 = 167;
    pub const LOGICAL_NOT: u32 = 168;
    pub const SELECT: u32 = 169;
    pub const I_EQUAL: u32 = 170;
    pub const I_NOT_EQUAL: u32 = 171;
    pub const U_GREATER_THAN: u32 = 172;
    pub const S_GREATER_THAN: u32 = 173;
    pub const U_GREATER_THAN_EQUAL: u32 = 174;
    pub const S_GREATER_THAN_EQUAL: u32 = 175;
    pub const U_LESS_THAN: u32 = 176;
    pub const S_LESS_THAN: u32 = 177;
    pub const U_LESS_THAN_EQUAL: u32 = 178;
    pub const S_LESS_THAN_EQUAL: u32 = 179;
    pub const SHIFT_RIGHT_LOGICAL: u32 = 194;
    pub const SHIFT_RIGHT_ARITHMETIC: u32 = 195;
    pub const SHIFT_LEFT_LOGICAL: u32 = 196;
    pub const BITWISE_OR: u32 = 197;
    pub const BITWISE_XOR: u32 = 198;
    pub const BITWISE_AND: u32 = 199;
    pub const NOT: u32 = 200;
    pub const PHI: u32 = 245;
    pub const LOOP_MERGE: u32 = 246;
    pub const SELECTION_MERGE: u32 = 247;
    pub const LABEL: u32 = 248;
    pub const BRANCH: u32 = 249;
    pub const BRANCH_CONDITIONAL: u32 = 250;
    pub const SWITCH: u32 = 251;
    pub const RETURN_VALUE: u32 = 254;
    pub const UNREACHABLE: u32 = 255;
    pub const NO_LINE: u32 = 317;
    pub const MODULE_PROCESSED: u32 = 330;
    pub const DECORATE_ID: u32 = 332;
    pub const TERMINATE_INVOCATION: u32 = 4416;
    pub const DECORATE_STRING: u32 = 5632;
    pub const MEMBER_DECORATE_STRING: u32 = 5633;
}

/// Operands that are read without asking whether they are there.
fn fewest_operands(code: u32) -> usize {
    match code {
        op::DECORATE | op::TYPE_INT | op::TYPE_FLOAT | op::STORE | op::PHI => 2,
        op::CONSTANT_TRUE | op::CONSTANT_FALSE | op::CONSTANT_COMPOSITE | op::CONSTANT_NULL => 2,
        op::SPEC_CONSTANT_TRUE | op::SPEC_CONSTANT_FALSE | op::SPEC_CONSTANT_COMPOSITE => 2,
        op::SELECTION_MERGE | op::SWITCH => 2,
        op::CONSTANT | op::SPEC_CONSTANT | op::SPEC_CONSTANT_OP => 3,
        op::VARIABLE | op::LOAD | op::FUNCTION_CALL | op::LOOP_MERGE | op::BRANCH_CONDITIONAL => 3,
        op::TYPE_VOID..=op::TYPE_FORWARD_POINTER | op::LABEL | op::BRANCH | op::RETURN_VALUE => 1,
        _ => 0,
    }
}

/// Instructions before the functions whose results and operands are understood.
fn is_known_global(code: u32) -> bool {
    matches!(
        code,
        0..=op::EXT_INST_IMPORT
            | op::MEMORY_MODEL..=op::CAPABILITY
            | op::TYPE_VOID..=op::TYPE_FORWARD_POINTER
            | op::CONSTANT_TRUE..=op::CONSTANT_NULL
            | op::SPEC_CONSTANT_TRUE..=op::SPEC_CONSTANT_OP
            | op::VARIABLE
            | op::DECORATE
            | op::MEMBER_DECORATE
            | op::NO_LINE
            | op::MODULE_PROCESSED..=op::DECORATE_ID
            | op::DECORATE_STRING
            | op::MEMBER_DECORATE_STRING
    )
}

/// One instruction.
#[derive(Debug, Clone, PartialEq)]
pub struct Instruction {
    /// One of [`op`], or one that is only carried along.
    pub op: u32,
    /// The words after the first.
    pub operands: Vec<u32>,
}

impl Instruction {
    /// From its parts.
    pub fn new(op: u32, operands: Vec<u32>) -> Self {
        Self { op, operands }
    }

    /// (type, id) of its result: inside a function an instruction has one where its first operand is a type.
    pub fn result(&self, types: &HashSet<u32>) -> Option<(u32, u32)> {
        match self.operands[..] {
            [kind, id, ..] if types.contains(&kind) => Some((kind, id)),
            _ => None,
        }
    }

    /// The id that it names or decorates.
    pub fn annotated(&self) -> Option<u32> {
        match self.op {
            op::NAME
            | op::MEMBER_NAME
            | op::DECORATE
            | op::MEMBER_DECORATE
            | op::DECORATE_ID
            | op::DECORATE_STRING
            | op::MEMBER_DECORATE_STRING => self.operands.first().copied(),
            _ => None,
        }
    }

    /// Labels it can go to; none where it ends the function.
    pub fn targets(&self) -> Vec<u32> {
        match (self.op, &self.operands[..]) {
            (op::BRANCH, &[target, ..]) => vec![target],
            (op::BRANCH_CONDITIONAL, &[_, yes, no, ..]) => vec![yes, no],
            (op::SWITCH, [_, default, cases @ ..]) => {
                [*default].into_iter().chain(cases.chunks_exact(2).map(|case| case[1])).collect()
            }
            _ => Vec::new(),
        }
    }

    fn write(&self, words: &mut Vec<u32>) {
        words.push(((self.operands.len() as u32 + 1) << 16) | self.op);
        words.extend(&self.operands);
    }
}

/// A basic block.
#[derive(Debug)]
pub struct Block {
    /// Its id.
    pub label: u32,
    /// All but the last one or two instructions.
    pub body: Vec<Instruction>,
    /// `OpSelectionMerge` or `OpLoopMerge`.
    pub merge: Option<Instruction>,
    /// The last instruction.
    pub terminator: Instruction,
}

/// A function.
#[derive(Debug)]
pub struct Function {
    /// `OpFunction` and the parameters.
    pub head: Vec<Instruction>,
    /// The entry is the first.
    pub blocks: Vec<Block>,
}

impl Function {
    /// Its id; `None` of one that is damaged.
    pub fn id(&self) -> Option<u32> {
        self.head.first().and_then(|function| function.operands.get(1).copied())
    }
}

/// A module.
#[derive(Debug)]
pub struct Module {
    header: Vec<u32>,
    /// Everything before the functions.
    pub globals: Vec<Instruction>,
    /// In their order.
    pub functions: Vec<Function>,
}

/// `None` where lengths do not add up.
fn instructions(mut words: &[u32]) -> Option<Vec<Instruction>> {
    let mut found = Vec::new();
    while let Some(&first) = words.first() {
        let operands = words.get(1..(first >> 16) as usize)?;
        let instruction = Instruction::new(first & 0xffff, operands.to_vec());
        if operands.len() < fewest_operands(instruction.op) {
            return None;
        }
        words = &words[operands.len() + 1..];
        found.push(instruction);
    }
    Some(found)
}

fn is_line(code: u32) -> bool {
    matches!(code, op::LINE | op::NO_LINE)
}

/// A block whose label has been taken already.
fn block(label: u32, rest: &mut impl Iterator<Item = Instruction>) -> Option<Block> {
    let mut body: Vec<Instruction> = Vec::new();
    loop {
        let instruction = rest.next()?;
        match instruction.op {
            op::BRANCH..=op::UNREACHABLE | op::TERMINATE_INVOCATION => {
                let is_merge = |i: &mut Instruction| matches!(i.op, op::SELECTION_MERGE | op::LOOP_MERGE);
                let merge = body.pop_if(is_merge);
                return Some(Block { label, body, merge, terminator: instruction });
            }
            op::LABEL | op::FUNCTION | op::FUNCTION_END => return None,
            _ => body.push(instruction),
        }
    }
}

/// A function whose first instruction has been taken already.
fn function(first: Instruction, rest: &mut impl Iterator<Item = Instruction>) -> Option<Function> {
    let mut function = Function { head: vec![first], blocks: Vec::new() };
    loop {
        let instruction = rest.next()?;
        match instruction.op {
            op::FUNCTION_END => return Some(function),
            op::LABEL => function.blocks.push(block(instruction.operands[0], rest)?),
            _ if function.blocks.is_empty() => function.head.push(instruction),
            code if is_line(code) => {}
            _ => return None,
        }
    }
}

impl Module {
    /// `None` for what is not a module, or not one that is understood.
    pub fn parse(words: &[u32]) -> Option<Self> {
        let header = words.get(..HEADER_WORDS).filter(|h| h[0] == MAGIC)?.to_vec();
        let instructions = instructions(&words[HEADER_WORDS..])?;
        let wide = instructions.iter().any(|i| i.op == op::TYPE_INT && i.operands[1] > 32);
        if wide && instructions.iter().any(|i| i.op == op::SWITCH) {
            return None; // the case literals of a 64-bit selector take two words each
        }
        let mut module = Self { header, globals: Vec::new(), functions: Vec::new() };
        let mut rest = instructions.into_iter();
        while let Some(instruction) = rest.next() {
            match instruction.op {
                op::FUNCTION => module.functions.push(function(instruction, &mut rest)?),
                code if module.functions.is_empty() && is_known_global(code) => module.globals.push(instruction),
                code if is_line(code) => {}
                _ => return None,
            }
        }
        Some(module)
    }

    /// Ids that functions define: their own, parameters, labels, results.
    pub fn defined_in_functions(&self, types: &HashSet<u32>) -> HashSet<u32> {
        let blocks = || self.functions.iter().flat_map(|f| &f.blocks);
        let heads = self.functions.iter().flat_map(|f| &f.head);
        let results = heads.chain(blocks().flat_map(|b| &b.body)).filter_map(|i| i.result(types));
        results.map(|(_, id)| id).chain(blocks().map(|b| b.label)).collect()
    }

    /// As a driver takes it.
    pub fn words(&self) -> Vec<u32> {
        let mut words = self.header.clone();
        self.globals.iter().for_each(|i| i.write(&mut words));
        for function in &self.functions {
            function.head.iter().for_each(|i| i.write(&mut words));
            for block in &function.blocks {
                Instruction::new(op::LABEL, vec![block.label]).write(&mut words);
                let rest = block.body.iter().chain(&block.merge).chain([&block.terminator]);
                rest.for_each(|i| i.write(&mut words));
            }
            Instruction::new(op::FUNCTION_END, Vec::new()).write(&mut words);
        }
        words
    }
}
