//! Leaves out waits that other barriers bring along: a write after a read needs an execution dependency and no access masks,
//! and execution dependencies reach over all resources.
//!
//! The rule is the execution dependency chain of the specification (chapter "Synchronization and Cache Control", "Execution
//! and Memory Dependencies"), as the checker applies it: a barrier waits for an access before it where its first scope has
//! all of the access's stages, or has one of the stages that a barrier in between has made wait already; then its second
//! scope waits too. The write needs all of its own stages to wait for each read since the last write. What was written
//! before those reads needs no look: each read waits for it, so a chain from the read is a chain from the write as well.
//!
//! Waits are tried in order. Only those left out whose chain went over the one just tried are looked at again. A look goes
//! once over the nodes between a read and the write, which are fewer than two frames.

use ash::vk::PipelineStageFlags2;

use super::hazard::Barrier;

/// When something happens, and in which stages. Time counts nodes over two frames and what follows them; a derived barrier
/// stands in the second frame or behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub stages: PipelineStageFlags2,
    pub at: usize,
}

/// A barrier and the moments of what it waits for.
#[derive(Debug)]
pub(super) struct Derived {
    pub barrier: Barrier,
    pub after: Vec<Moment>,
}

/// The barriers that are needed, in their order. `nodes` counts all nodes, `frame_len` those that repeat.
pub(super) fn prune(frame_len: usize, nodes: usize, derived: Vec<Derived>) -> Vec<Barrier> {
    let mut edges = Edges::new(frame_len, nodes, &derived);
    let stays: Vec<bool> = (0..derived.len())
        .map(|index| !only_waits(&derived[index].barrier) || !edges.leave_out(&derived, index))
        .collect();
    derived.into_iter().zip(stays).filter(|(_, stays)| *stays).map(|(d, _)| d.barrier).collect()
}

fn only_waits(b: &Barrier) -> bool {
    b.src_access.is_empty() && b.dst_access.is_empty() && b.layouts.0 == b.layouts.1
}

/// The barriers of one command with the same stages: as execution dependencies they are one.
#[derive(Debug)]
struct Edge {
    src: PipelineStageFlags2,
    dst: PipelineStageFlags2,
    /// A barrier that stays is among them.
    fixed: bool,
    /// Waits that have not been tried yet.
    open: usize,
    /// Waits left out whose chain may go through here, by barrier.
    carries: Vec<usize>,
}

impl Edge {
    fn is_there(&self) -> bool {
        self.fixed || self.open > 0
    }

    fn orders_as_much_as(&self, other: &Self) -> bool {
        self.is_there() && self.src.contains(other.src) && self.dst.contains(other.dst)
    }
}

/// Execution dependencies of the graph.
struct Edges {
    list: Vec<Edge>,
    /// Indices into `list`, by node.
    by_node: Vec<Vec<usize>>,
    /// Index into `list`, by barrier.
    of_barrier: Vec<usize>,
    frame_len: usize,
}

impl Edges {
    fn new(frame_len: usize, nodes: usize, derived: &[Derived]) -> Self {
        let mut edges = Self { list: Vec::new(), by_node: vec![Vec::new(); nodes], of_barrier: Vec::new(), frame_len };
        for Derived { barrier: b, .. } in derived {
            let here = &mut edges.by_node[b.before];
            let same = |e: &usize| (edges.list[*e].src, edges.list[*e].dst) == (b.src_stages, b.dst_stages);
            let index = here.iter().copied().find(same).unwrap_or_else(|| {
                here.push(edges.list.len());
                let (src, dst) = (b.src_stages, b.dst_stages);
                edges.list.push(Edge { src, dst, fixed: false, open: 0, carries: Vec::new() });
                edges.list.len() - 1
            });
            if only_waits(b) {
                edges.list[index].open += 1;
            } else {
                edges.list[index].fixed = true;
            }
            edges.of_barrier.push(index);
        }
        edges
    }

    /// Takes a wait out if everything stays ordered without it; else it counts as needed from here on.
    fn leave_out(&mut self, derived: &[Derived], index: usize) -> bool {
        let edge = self.of_barrier[index];
        self.list[edge].open -= 1;
        let here = &self.by_node[derived[index].barrier.before];
        let stand_ins = here.iter().copied().filter(|&e| self.list[e].orders_as_much_as(&self.list[edge]));
        if let Some(stand_in) = stand_ins.max_by_key(|&e| self.list[e].fixed) {
            let mut carried = std::mem::take(&mut self.list[edge].carries);
            carried.push(index);
            self.list[stand_in].carries.append(&mut carried);
            return true;
        }
        let mut carried = std::mem::take(&mut self.list[edge].carries);
        carried.push(index);
        carried.sort_unstable();
        carried.dedup();
        let chains: Option<Vec<_>> = carried.iter().map(|&wait| self.chain(&derived[wait])).collect();
        let Some(chains) = chains else {
            self.list[edge].fixed = true;
            return false;
        };
        for (wait, chain) in carried.into_iter().zip(chains) {
            chain.into_iter().for_each(|e| self.list[e].carries.push(wait));
        }
        true
    }

    /// The edges, apart from those that stay anyhow, over which the write waits for every read; `None` where it does not.
    fn chain(&self, wait: &Derived) -> Option<Vec<usize>> {
        let (end, wanted) = (self.frame_len + wait.barrier.before, wait.barrier.dst_stages);
        let mut used = Vec::new();
        for read in &wait.after {
            let mut reached = PipelineStageFlags2::NONE;
            for at in read.at + 1..=end {
                let node = if at < self.frame_len { at } else { at - self.frame_len };
                // The barriers of one command do not chain with each other.
                let mut further = reached;
                for &index in &self.by_node[node] {
                    let edge = &self.list[index];
                    let follows = edge.src.contains(read.stages) || edge.src.intersects(reached);
                    if edge.is_there() && follows && !further.contains(edge.dst) {
                        further |= edge.dst;
                        used.extend((!edge.fixed).then_some(index));
                    }
                }
                reached = further;
                if reached.contains(wanted) {
                    break;
                }
            }
            if !reached.contains(wanted) {
                return None;
            }
        }
        Some(used)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Access, BufferHandle, Declared, Graph, Lifetime, Node, Resource, Work, hazard};

    fn node(graph: &mut Graph, touches: &[(BufferHandle, Access)]) {
        let touch = |&(buffer, access): &(BufferHandle, Access)| Declared {
            name: "touch".into(),
            resource: Resource::Buffer(buffer),
            access,
            fresh: false,
        };
        let accesses = touches.iter().map(touch).collect();
        let name = format!("node {}", graph.nodes.len());
        graph.nodes.push(Node { name, accesses, work: Work::Host });
    }

    /// Two buffers that are written, then read, in turn: the wait for one brings that for the other along.
    #[test]
    fn a_wait_that_another_brings_along_is_left_out() {
        let mut graph = Graph::new();
        let [a, b] = ["a", "b"].map(|name| graph.buffer(name, 64, Lifetime::Transient));
        node(&mut graph, &[(a, Access::ComputeStorageWrite), (b, Access::ComputeStorageWrite)]);
        node(&mut graph, &[(a, Access::FragmentStorageRead), (b, Access::FragmentStorageRead)]);
        let waits = |list: &[hazard::Barrier]| list.iter().filter(|b| super::only_waits(b)).count();
        assert_eq!(waits(&hazard::derive_each(&graph)), 2);
        assert_eq!(waits(&hazard::derive(&graph)), 1);
    }

    /// The copy's wait is for another stage: nothing between reader and writer stands in for it.
    #[test]
    fn a_wait_for_a_stage_of_its_own_stays() {
        let mut graph = Graph::new();
        let [a, b] = ["a", "b"].map(|name| graph.buffer(name, 64, Lifetime::Transient));
        node(&mut graph, &[(a, Access::TransferWrite), (b, Access::ComputeStorageWrite)]);
        node(&mut graph, &[(a, Access::FragmentStorageRead), (b, Access::FragmentStorageRead)]);
        let waits = hazard::derive(&graph).iter().filter(|b| super::only_waits(b)).count();
        assert_eq!(waits, 2);
    }
}
