//! Layout probe: proves on the device that shared structs lie where Rust puts them (`build.rs` proves it of the SPIR-V alone).
//!
//! `write_index` fills a buffer with its word indices, `layout_probe` reads it as the structs of `src/shared.rs` and writes every
//! member in order. Reads and writes: buffers of its own. Limits: none. CPU twin: the sequence 0, 1, 2, ...

use super::{Frame, SceneHandles};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::{ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::plan::Plan;
use crate::shaders::prim::{layout_probe, write_index};
use crate::shared;

/// Two of each struct.
pub const WORDS: usize =
    2 * (size_of::<shared::Frame>() + size_of::<shared::InstanceData>() + size_of::<shared::MaterialData>()) / 4;

/// A frame that leaves the members, as the layer `members`.
pub fn frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let bytes = WORDS as u64 * 4;
    let words = graph.buffer("words", bytes, Lifetime::Transient);
    let members = graph.buffer("members", bytes, Lifetime::Transient);
    let result = graph.buffer("members (host)", bytes, Lifetime::ReadBack);
    let write = write_index::Bindings { words: ComputeStorageWrite(words) };
    let groups = (WORDS as u32).div_ceil(write_index::PROGRAM.local_size[0]);
    graph.add("write_index", dispatch(&write_index::PROGRAM, write.list(), groups));
    let probe = layout_probe::Bindings { structs: ComputeStorageRead(words), members: ComputeStorageWrite(members) };
    graph.add("layout_probe", dispatch(&layout_probe::PROGRAM, probe.list(), 1));
    graph.end_frame();
    graph.add("read_members", Work::CopyBuffer { from: members, to: result });
    graph.host_read(&[result]);
    Frame { graph, scene, results: vec![("members", result)] }
}

fn dispatch(
    program: &'static crate::graph::program::Program,
    bindings: Vec<crate::graph::Binding>,
    groups: u32,
) -> Work {
    let pipeline = ComputePipeline { program, constants: Vec::new() };
    Work::Dispatch { pipeline, bindings, push: Vec::new(), groups: Groups::Fixed([groups, 1, 1]) }
}
