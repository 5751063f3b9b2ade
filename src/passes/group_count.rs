//! Group count: workgroups for as many things as only the device knows there are, for indirect dispatches.
//!
//! Reads: how many there are. Writes: two buffers of three words. One thread. Limits: groups of `ROW_THREADS` threads lie in rows of 65,535
//! along x, and layers along z, of which the caller sees to 65,535 at most; a scan's groups lie along x alone, which is room for 134
//! million items, and the plan refuses more. CPU twin: `rows`.

use super::{dispatch, scan};
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::{BufferHandle, Graph, Groups, Lifetime};
use crate::shaders::prim::group_count;
use crate::shared::{MOST_GROUPS, ROW_THREADS};

/// Things of which a buffer says how many there are.
#[derive(Debug, Clone, Copy)]
pub struct Counted {
    /// One u32: how many.
    pub total: BufferHandle,
    /// Threads a thing.
    pub layers: u32,
    /// Workgroups of `ROW_THREADS` threads in rows, as `glsl/inc/cluster_thread.glsl` counts them; layers along z.
    pub groups: Groups,
    /// Workgroups of a scan over all threads.
    pub scan_groups: Groups,
}

/// Groups for `threads` in rows.
pub(super) fn rows(threads: u32) -> [u32; 3] {
    let groups = threads.div_ceil(ROW_THREADS).max(1);
    [groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]
}

/// Adds the node: `total` says how many there are, at most `capacity`.
pub fn add(graph: &mut Graph, name: &str, total: BufferHandle, capacity: u32, layers: u32) -> Counted {
    let mut arguments = |what: &str| graph.word_buffer(&format!("{name}_{what}"), 3 * 4, Lifetime::Transient);
    let (groups, scan_groups) = (arguments("groups"), arguments("scan_groups"));
    let set = group_count::Bindings {
        total: ComputeStorageRead(total),
        groups: ComputeStorageWrite(groups),
        scan_groups: ComputeStorageWrite(scan_groups),
    };
    let spec = group_count::Spec { LAYERS: layers, CAPACITY: capacity, SCAN_ITEMS: scan::group_items() };
    let work = dispatch(&group_count::PROGRAM, spec.values(), set.list(), [1, 1, 1]);
    graph.add(&format!("{name}_group_count"), work);
    Counted { total, layers, groups: Groups::Indirect(groups), scan_groups: Groups::Indirect(scan_groups) }
}

/// The same without a node where the plan knows that there are `count`; `total` says so too.
pub fn known(total: BufferHandle, count: u32, layers: u32) -> Counted {
    let [x, y, _] = rows(count);
    let items = u64::from(count) * u64::from(layers);
    let scan_groups = items.div_ceil(u64::from(scan::group_items())).clamp(1, u64::from(MOST_GROUPS)) as u32;
    let (groups, scan_groups) = (Groups::Fixed([x, y, layers]), Groups::Fixed([scan_groups, 1, 1]));
    Counted { total, layers, groups, scan_groups }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Access, checker, hazard, log};

    #[test]
    fn groups_lie_in_rows() {
        assert_eq!(rows(0), [1, 1, 1]);
        assert_eq!(rows(65), [2, 1, 1]);
        assert_eq!(rows(65_535 * 64), [65_535, 1, 1]);
        assert_eq!(rows(65_535 * 64 + 1), [65_535, 2, 1]);
    }

    #[test]
    fn what_the_plan_knows_needs_no_node() {
        let mut graph = Graph::new();
        let total = graph.word_buffer("total", 4, Lifetime::Static);
        let few = known(total, 100, 3);
        assert_eq!((few.groups, few.scan_groups), (Groups::Fixed([2, 1, 3]), Groups::Fixed([1, 1, 1])));
        assert_eq!(known(total, 0, 1).scan_groups, Groups::Fixed([1, 1, 1]));
        assert_eq!(known(total, 2049, 1).scan_groups, Groups::Fixed([2, 1, 1]));
    }

    /// Whoever dispatches by the arguments waits for them, and whoever writes them anew waits until they have been read.
    #[test]
    fn arguments_are_ordered() {
        let mut graph = Graph::new();
        let (total, counts) =
            (graph.word_buffer("total", 4, Lifetime::Static), graph.word_buffer("counts", 400, Lifetime::Static));
        let counted = add(&mut graph, "thing", total, 100, 1);
        scan::add_counted(&mut graph, "thing", counts, 100, &counted);
        assert_eq!(group_count::PROGRAM.slots.iter().filter(|s| s.kind.is_storage_buffer()).count(), 3);
        assert!(graph.problems().is_empty());
        let barriers = hazard::derive(&graph);
        assert!(checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
        let of_arguments = |b: &&hazard::Barrier| graph.name_of(b.resource) == "thing_scan_groups";
        let found: Vec<_> = barriers.iter().filter(of_arguments).collect();
        assert!(found.iter().any(|b| b.consumer == Access::IndirectRead && b.hazard == hazard::Hazard::Raw));
        for barrier in found {
            let fewer: Vec<_> = barriers.iter().filter(|b| *b != barrier).cloned().collect();
            assert!(!checker::check(&graph, &log::declared(&graph, &fewer, 3)).is_empty());
        }
    }
}
