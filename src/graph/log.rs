//! What was recorded, in order: the checker's only input besides the resources' names.

use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use super::hazard::Barrier;
use super::{Graph, Resource};

/// One thing that happens on the queue, in submission order.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A pipeline barrier with all its memory barriers.
    Barrier(Vec<MemoryBarrier>),
    /// An access by a command.
    Access(Accessed),
    /// The host waited until everything before had ended; nothing before can conflict with anything after.
    HostWait,
}

/// One memory barrier of a `vkCmdPipelineBarrier2`.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryBarrier {
    /// What it covers.
    pub resource: Resource,
    /// First scope.
    pub src_stages: PipelineStageFlags2,
    /// First access scope.
    pub src_access: AccessFlags2,
    /// Second scope.
    pub dst_stages: PipelineStageFlags2,
    /// Second access scope.
    pub dst_access: AccessFlags2,
    /// For images; equal where nothing changes.
    pub layouts: (ImageLayout, ImageLayout),
}

/// An access as the command performs it.
#[derive(Debug, Clone, PartialEq)]
pub struct Accessed {
    /// Node that recorded it.
    pub node: String,
    /// Binding, attachment or argument.
    pub what: String,
    /// What is touched.
    pub resource: Resource,
    /// Every stage it may happen in.
    pub stages: PipelineStageFlags2,
    /// Reads and writes.
    pub flags: AccessFlags2,
    /// Layout the command was given, `UNDEFINED` for buffers.
    pub layout: ImageLayout,
}

impl From<&Barrier> for MemoryBarrier {
    fn from(b: &Barrier) -> Self {
        Self {
            resource: b.resource,
            src_stages: b.src_stages,
            src_access: b.src_access,
            dst_stages: b.dst_stages,
            dst_access: b.dst_access,
            layouts: b.layouts,
        }
    }
}

/// The log that `frames` frames, with what runs before and after them, would leave if every declaration were true. Used to plan and to test;
/// proofs of real frames read what `record.rs` logged.
pub fn declared(graph: &Graph, barriers: &[Barrier], frames: usize) -> Vec<Event> {
    let mut log = Vec::new();
    declared_nodes(graph, barriers, 0..graph.once_nodes, &mut log);
    for _ in 0..frames {
        declared_nodes(graph, barriers, graph.frame_range(), &mut log);
    }
    declared_nodes(graph, barriers, graph.frame_len()..graph.nodes.len(), &mut log);
    log
}

fn declared_nodes(graph: &Graph, barriers: &[Barrier], nodes: std::ops::Range<usize>, log: &mut Vec<Event>) {
    for index in nodes {
        let before: Vec<_> = barriers.iter().filter(|b| b.before == index).map(MemoryBarrier::from).collect();
        if !before.is_empty() {
            log.push(Event::Barrier(before));
        }
        let node = &graph.nodes[index];
        log.extend(node.accesses.iter().map(|d| {
            let is_image = matches!(d.resource, Resource::Image(_));
            Event::Access(Accessed {
                node: node.name.clone(),
                what: d.name.clone(),
                resource: d.resource,
                stages: d.access.stages(),
                flags: d.access.flags(),
                layout: if is_image { d.access.layout() } else { ImageLayout::UNDEFINED },
            })
        }));
    }
}
