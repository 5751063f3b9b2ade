//! Derives the barriers between nodes from their declared accesses: as few as there are hazards, each with its reason.
//!
//! One resource at a time: the last write and the reads since. A read after a write needs the write made visible to its stage
//! and access, once; a write after reads needs only to wait; a layout change is a write by the barrier itself.
//! The frame repeats, so what the last node leaves is what the first node finds: derived twice, the second time with the
//! first's end state. `prune.rs` then leaves out waits that other barriers bring along.

use std::collections::{BTreeMap, HashMap};

use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use super::prune::{Derived, Moment, prune};
use super::{Access, Declared, Graph, Lifetime, Resource};

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

/// An access of a node.
#[derive(Debug, Clone, Copy)]
struct Touch {
    node: usize,
    /// First node of the same name: listings name it once.
    named: usize,
    access: Access,
    previous_frame: bool,
}

impl Touch {
    fn producer(self, graph: &Graph) -> Producer {
        let Self { node, access, previous_frame, .. } = self;
        Producer { node: graph.nodes[node].name.clone(), access, previous_frame }
    }

    fn moment(self, graph: &Graph) -> Moment {
        let frame_start = if self.previous_frame { 0 } else { graph.frame_len() };
        Moment { stages: self.access.stages(), at: frame_start + self.node }
    }

    fn reads_like(self, other: Self) -> bool {
        (self.named, self.access, self.previous_frame) == (other.named, other.access, other.previous_frame)
    }
}

#[derive(Debug, Clone, Default)]
struct State {
    /// Last write; a layout change counts as a write by the node after it.
    write: Option<Touch>,
    /// True where `write` is a layout change made for a reader, which has nothing to make available.
    transition: bool,
    reads: Vec<Touch>,
    /// Stage and access pairs to which the last write is visible.
    visible: Vec<(PipelineStageFlags2, AccessFlags2)>,
    layout: ImageLayout,
}

impl State {
    fn sees(&self, access: Access) -> bool {
        self.visible.iter().any(|(s, a)| s.contains(access.stages()) && a.contains(access.read_flags()))
    }

    /// Nothing in this frame has used it.
    fn untouched(&self) -> bool {
        self.write.iter().chain(&self.reads).all(|t| t.previous_frame)
    }

    /// Of reads that listings do not tell apart the last is kept: what waits for it waits for all of them.
    fn add_read(&mut self, touch: Touch) {
        match self.reads.iter_mut().find(|r| r.reads_like(touch)) {
            Some(read) => *read = touch,
            None => self.reads.push(touch),
        }
    }
}

/// What an access has to wait for, and what has to be done about it.
struct Needed {
    after: Vec<Touch>,
    hazard: Hazard,
    src_stages: PipelineStageFlags2,
    src_access: AccessFlags2,
    dst_access: AccessFlags2,
    layouts: (ImageLayout, ImageLayout),
}

impl Needed {
    fn derived(self, graph: &Graph, declared: &Declared, before: usize) -> Derived {
        let barrier = Barrier {
            resource: declared.resource,
            before,
            producers: self.after.iter().map(|t| t.producer(graph)).collect(),
            consumer: declared.access,
            hazard: self.hazard,
            src_stages: self.src_stages,
            src_access: self.src_access,
            dst_stages: declared.access.stages(),
            dst_access: self.dst_access,
            layouts: self.layouts,
        };
        Derived { barrier, after: self.after.iter().map(|t| t.moment(graph)).collect() }
    }
}

/// Barriers of the whole graph, in the order of its nodes: as few as there can be.
pub fn derive(graph: &Graph) -> Vec<Barrier> {
    let (once, repeated) = derive_with_moments(graph);
    // What runs once has no frame before it: its moments are its nodes.
    let alone = |mut derived: Derived| {
        derived.after.iter_mut().for_each(|moment| moment.at -= graph.frame_len());
        derived
    };
    let once = prune(0, graph.once_nodes, once.into_iter().map(alone).collect());
    let repeated = prune(graph.frame_len(), graph.nodes.len(), repeated);
    once.into_iter().chain(repeated).collect()
}

/// A barrier for each hazard by itself, in the order of nodes: those of [`derive()`], and the waits that it leaves out because
/// others bring them along.
pub fn derive_each(graph: &Graph) -> Vec<Barrier> {
    let (once, repeated) = derive_with_moments(graph);
    once.into_iter().chain(repeated).map(|d| d.barrier).collect()
}

/// Those of what runs once before the first frame, and those of the frame and of what follows it.
fn derive_with_moments(graph: &Graph) -> (Vec<Derived>, Vec<Derived>) {
    let mut first = HashMap::new();
    let named: Vec<usize> =
        graph.nodes.iter().enumerate().map(|(index, n)| *first.entry(n.name.as_str()).or_insert(index)).collect();
    let mut states = BTreeMap::new();
    let once = walk(graph, &named, 0..graph.once_nodes, &mut states);
    walk(graph, &named, graph.frame_range(), &mut states);
    for state in states.values_mut() {
        for touch in state.write.iter_mut().chain(&mut state.reads) {
            touch.previous_frame = true;
        }
    }
    let mut derived = walk(graph, &named, graph.frame_range(), &mut states);
    derived.extend(walk(graph, &named, graph.frame_len()..graph.nodes.len(), &mut states));
    (once, derived)
}

fn walk(
    graph: &Graph,
    named: &[usize],
    nodes: std::ops::Range<usize>,
    states: &mut BTreeMap<Resource, State>,
) -> Vec<Derived> {
    let mut derived = Vec::new();
    for index in nodes {
        for declared in merge(&graph.nodes[index].accesses) {
            let state = states.entry(declared.resource).or_insert_with(|| initial(graph, declared.resource));
            let touch = Touch { node: index, named: named[index], access: declared.access, previous_frame: false };
            derived.extend(step(state, declared, touch).map(|needed| needed.derived(graph, declared, index)));
        }
    }
    derived
}

/// One declaration a resource and access; a node may bind the same thing twice.
fn merge(accesses: &[Declared]) -> Vec<&Declared> {
    let mut merged: Vec<&Declared> = Vec::new();
    for declared in accesses {
        if !merged.iter().any(|m| m.resource == declared.resource && m.access == declared.access) {
            merged.push(declared);
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

/// Moves one resource over one access; what it has to wait for, if anything.
fn step(state: &mut State, declared: &Declared, touch: Touch) -> Option<Needed> {
    let access = declared.access;
    let is_image = matches!(declared.resource, Resource::Image(_));
    let wanted = if is_image { access.layout() } else { state.layout };
    // Discarding needs a layout change only where the first frame finds no layout at all; later in a frame it needs none.
    let relayout = is_image && (wanted != state.layout || (declared.fresh && state.untouched()));
    let needed = if access.writes() || relayout {
        ordered_write(state, declared, wanted, relayout)
    } else {
        visible_read(state, access)
    };
    if access.writes() {
        *state = State { write: Some(touch), layout: wanted, ..State::default() };
    } else if relayout {
        let visible = vec![(access.stages(), access.flags())];
        *state = State { write: Some(touch), transition: true, reads: vec![touch], visible, layout: wanted };
    } else {
        if needed.is_some() {
            state.visible.push((access.stages(), access.flags()));
        }
        state.add_read(touch);
    }
    needed
}

/// A write, or a layout change: waits for the reads since the last write, or for that write.
fn ordered_write(state: &State, declared: &Declared, wanted: ImageLayout, relayout: bool) -> Option<Needed> {
    let access = declared.access;
    let (after, hazard) = match (state.write, state.reads.is_empty()) {
        (_, false) => (state.reads.clone(), if access.writes() { Hazard::War } else { Hazard::Layout }),
        (Some(write), true) => (vec![write], if access.writes() { Hazard::Waw } else { Hazard::Raw }),
        (None, true) if relayout => (Vec::new(), Hazard::Layout),
        (None, true) => return None,
    };
    let src_stages = after.iter().fold(PipelineStageFlags2::NONE, |s, t| s | t.access.stages());
    // After reads the write has been made available already: an execution dependency is enough.
    let after_write = state.reads.is_empty();
    let src_access = if after_write {
        after.iter().fold(AccessFlags2::NONE, |a, t| a | t.access.write_flags())
    } else {
        AccessFlags2::NONE
    };
    // Write after read carries no masks, unless the barrier itself writes (layout) or the access reads as well and has
    // not seen the last write.
    let unseen = state.write.is_some() && !access.read_flags().is_empty() && !state.sees(access);
    let dst_access = if after_write || relayout || unseen { access.flags() } else { AccessFlags2::NONE };
    let old = if declared.fresh && relayout { ImageLayout::UNDEFINED } else { state.layout };
    Some(Needed { after, hazard, src_stages, src_access, dst_access, layouts: (old, wanted) })
}

/// A read in the layout that is there: needs the last write visible, which an earlier read may have seen to.
fn visible_read(state: &State, access: Access) -> Option<Needed> {
    let write = state.write?;
    if state.sees(access) {
        return None;
    }
    // A layout change made for another reader has that reader's stage in its second scope: chain from there.
    let src_access = if state.transition { AccessFlags2::NONE } else { write.access.write_flags() };
    Some(Needed {
        after: vec![write],
        hazard: Hazard::Raw,
        src_stages: write.access.stages(),
        src_access,
        dst_access: access.flags(),
        layouts: (state.layout, state.layout),
    })
}
