//! Proves from the log of recorded commands that every two overlapping accesses with a write between them are ordered, that
//! what was written is available and visible where it is read, and that images are in the layout that commands name.
//!
//! The model is the Vulkan specification's, chapter "Synchronization and Cache Control" (execution and memory dependencies, availability
//! and visibility), for one queue: a barrier's first scope is everything before it in submission order in its source stages,
//! or chained to by an earlier barrier. Stages are taken as they are named: the order of logical stages is not used, so the proof
//! asks for no less than the specification does.

use std::collections::BTreeMap;
use std::fmt;

use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use super::access::WRITES;
use super::log::{Accessed, Event, MemoryBarrier};
use super::{Graph, Lifetime, Resource};

/// Something the log does not order.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// Resource's name.
    pub resource: String,
    /// What is missing.
    pub problem: Problem,
    /// The earlier access, where there is one.
    pub first: Option<String>,
    /// The later access.
    pub second: String,
}

/// Kinds of violation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// Nothing makes the second wait for the first.
    NotOrdered,
    /// Ordered, but the first's writes are not made available.
    NotAvailable,
    /// Available, but not made visible to the second.
    NotVisible,
    /// The image is in another layout.
    WrongLayout(ImageLayout, ImageLayout),
    /// Read, but never written or since discarded.
    Undefined,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first = self.first.as_deref().unwrap_or("nothing");
        match self.problem {
            Problem::NotOrdered => write!(f, "{}: {} does not wait for {first}", self.resource, self.second),
            Problem::NotAvailable => write!(f, "{}: {first} is not made available to {}", self.resource, self.second),
            Problem::NotVisible => write!(f, "{}: {first} is not visible to {}", self.resource, self.second),
            Problem::Undefined => write!(f, "{}: {} reads what nothing has written", self.resource, self.second),
            Problem::WrongLayout(is, wants) => {
                write!(f, "{}: is in layout {is:?} where {} names {wants:?}", self.resource, self.second)
            }
        }
    }
}

/// A past access, with how far barriers have carried it.
#[derive(Debug, Clone)]
struct Past {
    label: String,
    stages: PipelineStageFlags2,
    writes: AccessFlags2,
    /// Stages that wait for it.
    reached: PipelineStageFlags2,
    available: bool,
    /// (stages, accesses) to which its writes are visible.
    visible: Vec<(PipelineStageFlags2, AccessFlags2)>,
    /// A later read has seen its writes.
    seen: bool,
}

impl Past {
    fn in_first_scope(&self, src: PipelineStageFlags2) -> bool {
        (!self.stages.is_empty() && src.contains(self.stages)) || self.reached.intersects(src)
    }

    /// Reads need the writes visible to them. A write over them needs that too, unless a read has seen them in between: then it
    /// only has to wait for that read (specification, 7.1, write after read).
    fn visible_to(&self, stages: PipelineStageFlags2, reads: AccessFlags2, writes: AccessFlags2) -> bool {
        let wanted = if reads.is_empty() { writes } else { reads };
        let visible = self.visible.iter().any(|(s, a)| s.contains(stages) && a.contains(wanted));
        visible || (reads.is_empty() && self.seen)
    }

    /// The host has waited for it before anything that comes now was submitted.
    fn has_ended(&self) -> bool {
        self.reached == PipelineStageFlags2::from_raw(u64::MAX)
    }

    fn ordered_before(&self, stages: PipelineStageFlags2) -> bool {
        self.reached.contains(stages)
    }
}

#[derive(Debug, Clone, Default)]
struct Cell {
    past: Vec<Past>,
    layout: ImageLayout,
    /// Something was written since the contents were last discarded.
    defined: bool,
}

/// Checks a log that starts with nothing before it; an empty list is the proof.
pub fn check(graph: &Graph, log: &[Event]) -> Vec<Violation> {
    check_from(graph, log, &mut Progress::default())
}

/// How far a log has been checked: what its next part has to be ordered after.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    cells: BTreeMap<Resource, Cell>,
}

/// Checks the next part of a log and moves `progress` to its end.
pub fn check_from(graph: &Graph, log: &[Event], progress: &mut Progress) -> Vec<Violation> {
    let mut checker = Checker { graph, cells: std::mem::take(&mut progress.cells), found: Vec::new() };
    for event in log {
        match event {
            Event::Barrier(barriers) => checker.barrier(barriers),
            Event::Access(access) => checker.access(access),
            Event::HostWait => checker.host_wait(),
        }
    }
    progress.cells = checker.cells;
    checker.found
}

struct Checker<'a> {
    graph: &'a Graph,
    cells: BTreeMap<Resource, Cell>,
    found: Vec<Violation>,
}

impl Checker<'_> {
    fn cell(&mut self, resource: Resource) -> &mut Cell {
        let graph = self.graph;
        self.cells.entry(resource).or_insert_with(|| {
            let (lifetime, image) = match resource {
                Resource::Image(i) => (graph.image_info(i).lifetime, true),
                Resource::Buffer(b) => (graph.buffer_info(b).lifetime, false),
            };
            let filled = matches!(lifetime, Lifetime::Static | Lifetime::Kept);
            let layout = if filled && image { ImageLayout::SHADER_READ_ONLY_OPTIMAL } else { ImageLayout::UNDEFINED };
            Cell { past: Vec::new(), layout, defined: filled }
        })
    }

    /// A wait on the timeline orders everything before it and makes it available, but visible to nothing on the device
    /// (specification, "Semaphore Signaling"; the implicit dependency of a submission covers writes of the host alone).
    fn host_wait(&mut self) {
        for past in self.cells.values_mut().flat_map(|cell| &mut cell.past) {
            past.reached = PipelineStageFlags2::from_raw(u64::MAX);
            past.available = true;
        }
    }

    fn report(&mut self, resource: Resource, problem: Problem, first: Option<String>, second: String) {
        let resource = self.graph.name_of(resource).to_string();
        self.found.push(Violation { resource, problem, first, second });
    }

    /// All memory barriers of one command take effect together: scopes are read before anything is changed.
    fn barrier(&mut self, barriers: &[MemoryBarrier]) {
        for barrier in barriers {
            self.cell(barrier.resource);
        }
        let mut reached: Vec<(Resource, usize, PipelineStageFlags2)> = Vec::new();
        for (resource, cell) in &self.cells {
            for (index, past) in cell.past.iter().enumerate() {
                for b in barriers.iter().filter(|b| past.in_first_scope(b.src_stages)) {
                    reached.push((*resource, index, b.dst_stages));
                }
            }
        }
        for barrier in barriers {
            self.memory(barrier);
        }
        for (resource, index, stages) in reached {
            self.cell(resource).past[index].reached |= stages;
        }
        for barrier in barriers.iter().filter(|b| matches!(b.resource, Resource::Image(_))) {
            self.transition(barrier);
        }
    }

    fn memory(&mut self, barrier: &MemoryBarrier) {
        for past in &mut self.cell(barrier.resource).past {
            if !past.in_first_scope(barrier.src_stages) {
                continue;
            }
            past.available |= barrier.src_stages.contains(past.stages) && barrier.src_access.contains(past.writes);
            if past.available {
                past.visible.push((barrier.dst_stages, barrier.dst_access));
            }
        }
    }

    /// A layout change writes the image: everything before has to be ordered and available; what it leaves is visible to the
    /// barrier's second scope.
    fn transition(&mut self, barrier: &MemoryBarrier) {
        let (old, new) = barrier.layouts;
        let discards = old == ImageLayout::UNDEFINED;
        if old == new {
            return;
        }
        let second = format!("the change of layout to {new:?}");
        let cell = self.cell(barrier.resource);
        let current = cell.layout;
        cell.layout = new;
        cell.defined &= !discards;
        let past = std::mem::take(&mut cell.past);
        cell.past.push(Past {
            label: second.clone(),
            stages: PipelineStageFlags2::NONE,
            writes: AccessFlags2::NONE,
            reached: barrier.dst_stages,
            available: true,
            visible: vec![(barrier.dst_stages, barrier.dst_access)],
            seen: false,
        });
        if !discards && current != old {
            self.report(barrier.resource, Problem::WrongLayout(current, old), None, second.clone());
        }
        for p in past {
            if !p.has_ended() && !p.in_first_scope(barrier.src_stages) {
                self.report(barrier.resource, Problem::NotOrdered, Some(p.label), second.clone());
            } else if !p.writes.is_empty() && !p.available {
                self.report(barrier.resource, Problem::NotAvailable, Some(p.label), second.clone());
            }
        }
    }

    fn access(&mut self, access: &Accessed) {
        let label = format!("{}.{}", access.node, access.what);
        let writes = access.flags & WRITES;
        let reads = access.flags & !WRITES;
        let is_image = matches!(access.resource, Resource::Image(_));
        let cell = self.cell(access.resource);
        let mut problems = Vec::new();
        if is_image && cell.layout != access.layout {
            problems.push((Problem::WrongLayout(cell.layout, access.layout), None));
        }
        if writes.is_empty() && !cell.defined {
            problems.push((Problem::Undefined, None));
        }
        cell.defined |= !writes.is_empty();
        for past in &mut cell.past {
            // Writes, and layout changes, which carry no stage of their own.
            let past_writes = !past.writes.is_empty() || past.stages.is_empty();
            if !past_writes && writes.is_empty() {
                continue;
            }
            let problem = if !past.ordered_before(access.stages) {
                Problem::NotOrdered
            } else if past_writes && !past.available {
                Problem::NotAvailable
            } else if past_writes && !past.visible_to(access.stages, reads, writes) {
                Problem::NotVisible
            } else {
                past.seen |= !reads.is_empty();
                continue;
            };
            problems.push((problem, Some(past.label.clone())));
        }
        let past = Past {
            label: label.clone(),
            stages: access.stages,
            writes,
            reached: PipelineStageFlags2::NONE,
            available: false,
            visible: Vec::new(),
            seen: false,
        };
        if !writes.is_empty() {
            // What came before is ordered (or reported): later accesses that are ordered after this one are ordered after it.
            cell.past.clear();
        }
        cell.past.push(past);
        for (problem, first) in problems {
            self.report(access.resource, problem, first, label.clone());
        }
    }
}
