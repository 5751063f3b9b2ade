//! Octahedral probe: decodes codes of normals on the device, for a check.
//!
//! Writes: a buffer of its own, three floats a code. Groups of 64 threads, a thread a code, a row of groups a row of codes. Limits: the
//! rows that it is asked for. CPU twin: `reference/octahedral.rs`.

use super::{Frame, SceneHandles, dispatch};
use crate::graph::access::ComputeStorageWrite;
use crate::graph::{Graph, Lifetime, Work};
use crate::plan::Plan;
use crate::shaders::prim::octahedral_probe;

/// Codes that are decoded: all of the first axis, and of the second every `row_step`th.
#[derive(Debug, Clone, Copy)]
pub struct Codes {
    /// Of a code.
    pub bits: u32,
    /// The first row.
    pub first_row: u32,
    /// From row to row.
    pub row_step: u32,
}

impl Codes {
    /// Rows of codes.
    pub fn rows(&self) -> u32 {
        ((1u32 << self.bits) - self.first_row).div_ceil(self.row_step)
    }

    /// Both codes of number `index`.
    pub fn code(&self, index: u32) -> [u32; 2] {
        [index & ((1 << self.bits) - 1), self.first_row + (index >> self.bits) * self.row_step]
    }
}

/// A frame that leaves the normals, as the layer `normals`.
pub fn frame(plan: &Plan, codes: &Codes) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let bytes = u64::from(codes.rows()) * (12 << codes.bits);
    let normals = graph.buffer("normals", bytes, Lifetime::Transient);
    let result = graph.buffer("normals (host)", bytes, Lifetime::ReadBack);
    let set = octahedral_probe::Bindings { normals: ComputeStorageWrite(normals) };
    let spec = octahedral_probe::Spec { BITS: codes.bits, FIRST_ROW: codes.first_row, ROW_STEP: codes.row_step };
    let groups = [(1 << codes.bits) / 64, codes.rows(), 1];
    graph.add("octahedral_probe", dispatch(&octahedral_probe::PROGRAM, spec.values(), set.list(), groups));
    graph.end_frame();
    graph.add("read_normals", Work::CopyBuffer { from: normals, to: result });
    graph.host_read(&[result]);
    Frame { graph, scene, results: vec![("normals", result)] }
}
