//! Scan: exclusive prefix sums of u32, in levels (the tree of G. Blelloch, "Prefix Sums and Their Applications",
//! CMU-CS-90-190, 1990, with 64 children a node). Upwards `scan_sum` adds up each run of `SCAN_RUN` items until one run holds
//! a level; downwards `scan_spread` walks through every run again and writes what precedes each item. No thread waits for another.
//!
//! Reads: the items, and their number where only the device knows it. Writes: their offsets, one more than there are items; the
//! last is the total. Group shape: 32 threads, a run each. Limits: totals below 2^32, which the caller sees to (past that they
//! wrap); 65,535 groups are 134 million items, and more are refused when the frame is prepared, or by the plan where the device
//! counts them. CPU twin: `reference/scan.rs`.

use bytemuck::bytes_of;

use super::group_count::Counted;
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::shaders::prim::{scan_spread, scan_sum};
use crate::shared::{SCAN_RUN, ScanPush};

/// Buffers of a scan; scans of as many items can take turns with them.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Items of each level; the first level is the input, the last fits in one run.
    lengths: Vec<u32>,
    /// Items of the levels above the input.
    sums: Vec<BufferHandle>,
    /// Prefix sums of each level.
    offsets: Vec<BufferHandle>,
}

fn level_lengths(count: u32) -> Vec<u32> {
    let above = |&length: &u32| (length > SCAN_RUN).then(|| length.div_ceil(SCAN_RUN));
    std::iter::successors(Some(count), above).collect()
}

fn bytes(words: u32) -> u64 {
    u64::from(words) * 4
}

impl Scan {
    /// Declares what scans of `count` items write: `{name}_offsets`, and a pair of buffers for each level above.
    pub fn declare(graph: &mut Graph, name: &str, count: u32) -> Self {
        let lengths = level_lengths(count);
        let mut scan = Self { lengths, sums: Vec::new(), offsets: Vec::new() };
        for (level, &length) in scan.lengths.iter().enumerate() {
            let of_level = if level == 0 { String::new() } else { format!("_{level}") };
            if level > 0 {
                scan.sums.push(graph.word_buffer(
                    &format!("{name}_sums{of_level}"),
                    bytes(length),
                    Lifetime::Transient,
                ));
            }
            let offsets = format!("{name}_offsets{of_level}");
            scan.offsets.push(graph.word_buffer(&offsets, bytes(length) + 4, Lifetime::Transient));
        }
        scan
    }

    /// Adds the nodes that scan `counts`; gives the buffer of offsets, which the next scan with these buffers overwrites.
    pub fn add(&self, graph: &mut Graph, name: &str, counts: BufferHandle) -> BufferHandle {
        self.add_levels(graph, name, counts, None)
    }

    fn add_levels(
        &self,
        graph: &mut Graph,
        name: &str,
        counts: BufferHandle,
        counted: Option<&Counted>,
    ) -> BufferHandle {
        let items = |level: usize| if level == 0 { counts } else { self.sums[level - 1] };
        // Not read where the number is known; something has to be bound.
        let total = |level: usize| counted.map_or(items(level), |c| c.total);
        for (level, &sums) in self.sums.iter().enumerate() {
            let set = scan_sum::Bindings {
                items: ComputeStorageRead(items(level)),
                sums: ComputeStorageWrite(sums),
                total: ComputeStorageRead(total(level)),
            };
            let spec = scan_sum::Spec { COUNTED: counted.is_some() };
            let pipeline = ComputePipeline { program: &scan_sum::PROGRAM, constants: spec.values() };
            graph.add(&format!("{name}_scan_sum_{level}"), self.dispatch(level, pipeline, set.list(), counted));
        }
        for level in (0..self.lengths.len()).rev() {
            let parents = self.offsets.get(level + 1).copied();
            let set = scan_spread::Bindings {
                items: ComputeStorageRead(items(level)),
                // The top level reads no parents; something has to be bound.
                parent_offsets: ComputeStorageRead(parents.unwrap_or(items(level))),
                offsets: ComputeStorageWrite(self.offsets[level]),
                total: ComputeStorageRead(total(level)),
            };
            let spec = scan_spread::Spec { HAS_PARENTS: parents.is_some(), COUNTED: counted.is_some() };
            let pipeline = ComputePipeline { program: &scan_spread::PROGRAM, constants: spec.values() };
            graph.add(&format!("{name}_scan_spread_{level}"), self.dispatch(level, pipeline, set.list(), counted));
        }
        self.offsets[0]
    }

    /// Levels above the first are short whatever there is room for.
    fn dispatch(
        &self,
        level: usize,
        pipeline: ComputePipeline,
        bindings: Vec<Binding>,
        counted: Option<&Counted>,
    ) -> Work {
        let length = self.lengths[level];
        let groups = match counted {
            Some(counted) if level == 0 => counted.scan_groups,
            _ => Groups::Fixed([length.div_ceil(group_items()).max(1), 1, 1]),
        };
        let each = counted.map_or(1, |c| c.layers);
        let push = ScanPush { item_count: length, each, span: SCAN_RUN.pow(level as u32) };
        Work::Dispatch { pipeline, bindings, push: bytes_of(&push).to_vec(), groups }
    }
}

/// Items of a workgroup.
pub(super) fn group_items() -> u32 {
    SCAN_RUN * scan_sum::PROGRAM.local_size[0]
}

/// Adds a scan of the first `count` words of `counts`; the buffer of `count + 1` offsets.
pub fn add(graph: &mut Graph, name: &str, counts: BufferHandle, count: u32) -> BufferHandle {
    Scan::declare(graph, name, count).add(graph, name, counts)
}

/// As [`add`] for as many words as `counted` says, a word a thread; `capacity` words at most. What the offsets hold behind their total is
/// not defined.
pub fn add_counted(
    graph: &mut Graph,
    name: &str,
    counts: BufferHandle,
    capacity: u32,
    counted: &Counted,
) -> BufferHandle {
    Scan::declare(graph, name, capacity).add_levels(graph, name, counts, Some(counted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};

    #[test]
    fn levels_end_with_one_run() {
        assert_eq!(level_lengths(0), [0]);
        assert_eq!(level_lengths(64), [64]);
        assert_eq!(level_lengths(65), [65, 2]);
        assert_eq!(level_lengths(4097), [4097, 65, 2]);
        assert_eq!(level_lengths(u32::MAX).len(), 6);
    }

    #[test]
    fn every_level_is_ordered_after_the_one_it_reads() {
        let mut graph = Graph::new();
        let counts = graph.word_buffer("counts", 4097 * 4, Lifetime::Static);
        let offsets = add(&mut graph, "tile", counts, 4097);
        assert_eq!(graph.buffer_info(offsets).name, "tile_offsets");
        assert_eq!(graph.buffer_info(offsets).bytes, 4098 * 4);
        let names: Vec<_> = graph.nodes.iter().map(|n| n.name.as_str()).collect();
        let wanted =
            ["tile_scan_sum_0", "tile_scan_sum_1", "tile_scan_spread_2", "tile_scan_spread_1", "tile_scan_spread_0"];
        assert_eq!(names, wanted);
        assert!(graph.problems().is_empty());
        let mut barriers = hazard::derive(&graph);
        assert!(checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
        let spread = barriers.iter().position(|b| b.before == 4 && b.hazard == hazard::Hazard::Raw);
        barriers.remove(spread.expect("the last node waits for its parents"));
        assert!(!checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
    }
}
