//! Sight: whether anything stands between the ends of segments, as far as 32 bits can tell.
//!
//! Reads: the hierarchy of a scene's triangles in the order of a walk, triangles, segments. Writes: a word a segment (`SIGHT_MISSED`, `SIGHT_MET`,
//! `SIGHT_UNSURE`), which is copied to the host. Group shape: 64 threads, one a segment. Limits: the storage buffers that a device binds at once.
//! CPU twin: `is_blocked_past` of `reference/render/bounced.rs`, which also decides what is not sure.

use bytemuck::bytes_of;

use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::{BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::shaders::radiosity::sight;
use crate::shared::SightPush;

/// The graph and what is filled before it runs.
pub struct SightFrame {
    /// One pass and the copy of what it found.
    pub graph: Graph,
    /// Two times four words a node.
    pub nodes: BufferHandle,
    /// Three a triangle.
    pub triangles: BufferHandle,
    /// Two a segment.
    pub segments: BufferHandle,
    /// A word a segment, on the host's side.
    pub found: BufferHandle,
}

/// The graph for up to `most` segments through so many nodes and triangles.
pub fn frame(push: SightPush, triangles: u64, most: u32) -> SightFrame {
    let mut graph = Graph::new();
    let texels = |graph: &mut Graph, name: &str, count: u64| graph.buffer(name, count.max(1) * 16, Lifetime::Static);
    let nodes = texels(&mut graph, "sight_nodes", 2 * u64::from(push.nodes));
    let triangles = texels(&mut graph, "sight_triangles", 3 * triangles);
    let segments = texels(&mut graph, "sight_segments", 2 * u64::from(most));
    let bytes = u64::from(most) * 4;
    let seen = graph.word_buffer("sight_seen", bytes, Lifetime::Transient);
    let found = graph.word_buffer("sight_seen (host)", bytes, Lifetime::ReadBack);
    let set = sight::Bindings {
        nodes: ComputeStorageRead(nodes),
        triangles: ComputeStorageRead(triangles),
        segments: ComputeStorageRead(segments),
        seen: ComputeStorageWrite(seen),
    };
    let work = Work::Dispatch {
        pipeline: ComputePipeline { program: &sight::PROGRAM, constants: Vec::new() },
        bindings: set.list(),
        push: bytes_of(&push).to_vec(),
        groups: Groups::Fixed([most.div_ceil(64), 1, 1]),
    };
    graph.add("sight", work);
    graph.add("read_seen", Work::CopyBuffer { from: seen, to: found });
    graph.host_read(&[found]);
    graph.end_frame();
    SightFrame { graph, nodes, triangles, segments, found }
}
