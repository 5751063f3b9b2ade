//! Derives the barriers between nodes from their declared accesses: as few as there are hazards, each with its reason.
//!
//! One resource at a time: the last write and the reads since. A read after a write needs the write made visible to its stage
//! and access, once; a write after reads needs only to wait; a layout change is a write by the barrier itself.
//! The frame repeats, so what the last node leaves is what the first node finds: derived twice, the second time with the
//! first's end state.

use std::collections::BTreeMap;

use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use super::{Access, Declared, Graph, Lifetime, Resource, checker, log};

/// Why a barrier is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Hazard {
    /// Read after write.
    Raw,
    /// Write after read.
    War,
    /// Write after write.
    Waw,
    /// The image has to change its layout and nothing was written before.
    Layout,
}

impl Hazard {
    /// Three or six letters for listings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "RAW",
            Self::War => "WAR",
            Self::Waw => "WAW",
            Self::Layout => "LAYOUT",
        }
    }
}

/// The earlier side of a barrier.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Producer {
    /// Node name.
    pub node: String,
    /// What it did.
    pub access: Access,
    /// It did so in the frame before.
    pub previous_frame: bool,
}

/// One barrier, recorded before its consumer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Barrier {
    /// What is protected.
    pub resource: Resource,
    /// Index of the node before which it is recorded.
    pub before: usize,
    /// Every access that is waited for; empty where only a layout is set up.
    pub producers: Vec<Producer>,
    /// What the node is about to do.
    pub consumer: Access,
    /// Why.
    pub hazard: Hazard,
    /// First scope.
    pub src_stages: PipelineStageFlags2,
    /// Writes made available.
    pub src_access: AccessFlags2,
    /// Second scope.
    pub dst_stages: PipelineStageFlags2,
    /// Accesses that see them.
    pub dst_access: AccessFlags2,
    /// Image layouts before and after; equal for buffers.
    pub layouts: (ImageLayout, ImageLayout),
}

#[derive(Debug, Clone, Default)]
struct State {
    /// Last write: node, access; a layout change counts as a write by the node after it.
    write: Option<Producer>,
    /// True where `write` is a layout change made for a reader, which has nothing to make available.
    transition: bool,
    reads: Vec<Producer>,
    /// Stage and access pairs to which the last write is visible.
    visible: Vec<(PipelineStageFlags2, AccessFlags2)>,
    layout: ImageLayout,
}

impl State {
    fn sees(&self, access: Access) -> bool {
        self.visible.iter().any(|(s, a)| s.contains(access.stages()) && a.contains(access.read_flags()))
    }
}

/// Barriers of the whole graph, by node.
pub fn derive(graph: &Graph) -> Vec<Barrier> {
    let mut states = BTreeMap::new();
    walk(graph, 0..graph.frame_len(), &mut states);
    for state in states.values_mut() {
        for producer in state.write.iter_mut().chain(&mut state.reads) {
            producer.previous_frame = true;
        }
    }
    let mut barriers = walk(graph, 0..graph.frame_len(), &mut states);
    barriers.extend(walk(graph, graph.frame_len()..graph.nodes.len(), &mut states));
    prune(graph, barriers)
}

/// Leaves out waits that another barrier brings along: a write after a read without masks only orders execution, and any barrier
/// from the reader's stage to the writer's orders all resources alike. The checker judges each such barrier.
fn prune(graph: &Graph, mut barriers: Vec<Barrier>) -> Vec<Barrier> {
    let mut index = 0;
    while index < barriers.len() {
        let b = &barriers[index];
        let only_waits = b.src_access.is_empty() && b.dst_access.is_empty() && b.layouts.0 == b.layouts.1;
        if only_waits {
            let removed = barriers.remove(index);
            if checker::check(graph, &log::declared(graph, &barriers, FRAMES_TO_STEADY_STATE)).is_empty() {
                continue;
            }
            barriers.insert(index, removed);
        }
        index += 1;
    }
    barriers
}

/// Frames after which nothing new can follow: the first has nothing before it, the second finds what a frame leaves.
const FRAMES_TO_STEADY_STATE: usize = 3;

fn walk(graph: &Graph, nodes: std::ops::Range<usize>, states: &mut BTreeMap<Resource, State>) -> Vec<Barrier> {
    let mut barriers = Vec::new();
    for index in nodes {
        let node = &graph.nodes[index];
        for declared in merge(&node.accesses) {
            let state = states.entry(declared.resource).or_insert_with(|| initial(graph, declared.resource));
            let producer = Producer { node: node.name.clone(), access: declared.access, previous_frame: false };
            barriers.extend(step(state, &declared, producer, index));
        }
    }
    barriers
}

/// One declaration a resource and access; a node may bind the same thing twice.
fn merge(accesses: &[Declared]) -> Vec<Declared> {
    let mut merged: Vec<Declared> = Vec::new();
    for declared in accesses {
        if !merged.iter().any(|m| m.resource == declared.resource && m.access == declared.access) {
            merged.push(declared.clone());
        }
    }
    merged
}

fn initial(graph: &Graph, resource: Resource) -> State {
    let layout = match resource {
        Resource::Image(image) if graph.image_info(image).lifetime == Lifetime::Static => {
            ImageLayout::SHADER_READ_ONLY_OPTIMAL
        }
        _ => ImageLayout::UNDEFINED,
    };
    State { layout, ..State::default() }
}

/// Moves one resource over one access; the barrier it needs, if any.
fn step(state: &mut State, declared: &Declared, producer: Producer, before: usize) -> Option<Barrier> {
    let access = declared.access;
    let is_image = matches!(declared.resource, Resource::Image(_));
    let wanted = if is_image { access.layout() } else { state.layout };
    // Discarding needs a layout change only where the first frame finds no layout at all; later in a frame it needs none.
    let untouched = state.write.iter().chain(&state.reads).all(|p| p.previous_frame);
    let relayout = is_image && (wanted != state.layout || (declared.fresh && untouched));
    let barrier = if access.writes() || relayout {
        ordered_write(state, declared, before, wanted, relayout)
    } else {
        visible_read(state, declared, before)
    };
    if access.writes() {
        *state = State { write: Some(producer), layout: wanted, ..State::default() };
    } else if relayout {
        let visible = vec![(access.stages(), access.flags())];
        *state =
            State { write: Some(producer.clone()), transition: true, reads: vec![producer], visible, layout: wanted };
    } else {
        if barrier.is_some() {
            state.visible.push((access.stages(), access.flags()));
        }
        if !state.reads.contains(&producer) {
            state.reads.push(producer);
        }
    }
    barrier
}

/// A write, or a layout change: waits for the reads since the last write, or for that write.
fn ordered_write(
    state: &State,
    declared: &Declared,
    before: usize,
    wanted: ImageLayout,
    relayout: bool,
) -> Option<Barrier> {
    let access = declared.access;
    let (producers, hazard) = match (&state.write, state.reads.is_empty()) {
        (_, false) => (state.reads.clone(), if access.writes() { Hazard::War } else { Hazard::Layout }),
        (Some(write), true) => (vec![write.clone()], if access.writes() { Hazard::Waw } else { Hazard::Raw }),
        (None, true) if relayout => (Vec::new(), Hazard::Layout),
        (None, true) => return None,
    };
    let src_stages = producers.iter().fold(PipelineStageFlags2::NONE, |s, p| s | p.access.stages());
    // After reads the write has been made available already: an execution dependency is enough.
    let after_write = state.reads.is_empty();
    let src_access = if after_write {
        producers.iter().fold(AccessFlags2::NONE, |a, p| a | p.access.write_flags())
    } else {
        AccessFlags2::NONE
    };
    // Write after read carries no masks, unless the barrier itself writes (layout) or the access reads as well and has
    // not seen the last write.
    let unseen = state.write.is_some() && !access.read_flags().is_empty() && !state.sees(access);
    let dst_access = if after_write || relayout || unseen { access.flags() } else { AccessFlags2::NONE };
    let old = if declared.fresh && relayout { ImageLayout::UNDEFINED } else { state.layout };
    Some(Barrier {
        resource: declared.resource,
        before,
        producers,
        consumer: access,
        hazard,
        src_stages,
        src_access,
        dst_stages: access.stages(),
        dst_access,
        layouts: (old, wanted),
    })
}

/// A read in the layout that is there: needs the last write visible, which an earlier read may have seen to.
fn visible_read(state: &State, declared: &Declared, before: usize) -> Option<Barrier> {
    let access = declared.access;
    let write = state.write.as_ref()?;
    if state.sees(access) {
        return None;
    }
    // A layout change made for another reader has that reader's stage in its second scope: chain from there.
    let (src_stages, src_access) = if state.transition {
        (write.access.stages(), AccessFlags2::NONE)
    } else {
        (write.access.stages(), write.access.write_flags())
    };
    Some(Barrier {
        resource: declared.resource,
        before,
        producers: vec![write.clone()],
        consumer: access,
        hazard: Hazard::Raw,
        src_stages,
        src_access,
        dst_stages: access.stages(),
        dst_access: access.flags(),
        layouts: (state.layout, state.layout),
    })
}
