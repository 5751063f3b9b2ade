//! Sorting of many lists, each ascending and in place: runs of up to `LIST_SORT_RUN` entries on a heap, then rounds of merging (D. Knuth,
//! "The Art of Computer Programming", volume 3, sections 5.2.3 and 5.2.4). A round merges pairs of runs into a scratch space and pairs
//! of those back; lists that are one run already stay where they are.
//!
//! Reads: offsets, and the number of lists where only the device knows it. Reads and writes: the lists. Group shape: 64 threads, a thread
//! a list and run (or pair of runs). Limits: the plan knows the longest list, and refuses what loops do not reach; what is longer than it
//! said stays unsorted. CPU twin: `reference/list_sort.rs`.

use bytemuck::bytes_of;

use super::group_count::{self, Counted, rows};
use super::tile_cull::Lists;
use crate::graph::access::{ComputeStorageRead, ComputeStorageReadWrite, ComputeStorageWrite};
use crate::graph::program::Program;
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::plan::list_sort::ListSort;
use crate::shaders::bvh::{list_merge, list_sort};
use crate::shared::{LIST_SORT_RUN, ListSortPush};

/// Adds the sort of `lists`, which lie where `offsets` says.
pub fn add(graph: &mut Graph, name: &str, sort: &ListSort, offsets: BufferHandle, lists: BufferHandle) {
    add_rounds(graph, name, sort, Lists { lights: lists, offsets }, None);
}

/// As [`add`] for as many lists as `counted` says.
pub fn add_counted(graph: &mut Graph, name: &str, sort: &ListSort, lists: Lists, counted: &Counted) {
    add_rounds(graph, name, sort, lists, Some(counted));
}

fn add_rounds(graph: &mut Graph, name: &str, sort: &ListSort, lists: Lists, counted: Option<&Counted>) {
    let Lists { lights: lists, offsets } = lists;
    // Not read where the number of lists is known; something has to be bound.
    let total = counted.map_or(offsets, |c| c.total);
    let runs = sort.longest.div_ceil(LIST_SORT_RUN);
    let groups = groups_of(graph, &format!("{name}_list_sort"), sort, counted, runs);
    let set = list_sort::Bindings {
        list_offsets: ComputeStorageRead(offsets),
        lists: ComputeStorageReadWrite(lists),
        total: ComputeStorageRead(total),
    };
    let constants = list_sort::Spec { COUNTED: counted.is_some() }.values();
    let work = dispatch((&list_sort::PROGRAM, constants), sort, set.list(), (LIST_SORT_RUN, 0), groups);
    graph.add(&format!("{name}_list_sort"), work);
    if sort.rounds() == 0 {
        return;
    }
    let scratch = graph.word_buffer(&format!("{name}_merged"), sort.bytes(), Lifetime::Transient);
    for round in 0..sort.rounds() {
        let sorted = u32::try_from(ListSort::width(round)).unwrap_or(u32::MAX);
        for (back, width) in [(false, sorted), (true, sorted.saturating_mul(2))] {
            let (from, to) = if back { (scratch, lists) } else { (lists, scratch) };
            let set = list_merge::Bindings {
                list_offsets: ComputeStorageRead(offsets),
                runs: ComputeStorageRead(from),
                merged: ComputeStorageWrite(to),
                total: ComputeStorageRead(total),
            };
            let way = if back { "back" } else { "out" };
            let name = format!("{name}_list_merge_{round}_{way}");
            let pairs = sort.longest.div_ceil(width.saturating_mul(2));
            let groups = groups_of(graph, &name, sort, counted, pairs);
            let constants = list_merge::Spec { COUNTED: counted.is_some() }.values();
            let work = dispatch((&list_merge::PROGRAM, constants), sort, set.list(), (width, sorted), groups);
            graph.add(&name, work);
        }
    }
}

/// Groups of a thread a list, `of_list` times.
fn groups_of(graph: &mut Graph, name: &str, sort: &ListSort, counted: Option<&Counted>, of_list: u32) -> Groups {
    let of_list = of_list.max(1);
    match counted {
        Some(counted) if counted.layers == of_list => counted.groups,
        Some(counted) => group_count::add(graph, name, counted.total, sort.list_count, of_list).groups,
        None => {
            let [x, y, _] = rows(sort.list_count);
            Groups::Fixed([x, y, of_list])
        }
    }
}

fn dispatch(
    (program, constants): (&'static Program, Vec<(u32, u32)>),
    sort: &ListSort,
    bindings: Vec<Binding>,
    (width, sorted): (u32, u32),
    groups: Groups,
) -> Work {
    let push = ListSortPush { list_count: sort.list_count, stride: sort.stride, width, sorted };
    let pipeline = ComputePipeline { program, constants };
    Work::Dispatch { pipeline, bindings, push: bytes_of(&push).to_vec(), groups }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};

    fn nodes(longest: u32) -> Vec<String> {
        let mut graph = Graph::new();
        let sort = ListSort { list_count: 10, stride: 1, entry_count: 30_000, longest };
        let offsets = graph.word_buffer("offsets", 11 * 4, Lifetime::Static);
        let lists = graph.word_buffer("lists", 30_000 * 4, Lifetime::Transient);
        graph.add("fill_lists", Work::Fill { buffer: lists, word: 3 });
        let before = graph.buffers.len();
        add(&mut graph, "cluster", &sort, offsets, lists);
        let bytes: u64 = graph.buffers[before..].iter().map(|b| b.bytes).sum();
        assert_eq!(bytes, sort.bytes());
        assert!(graph.problems().is_empty());
        let barriers = hazard::derive(&graph);
        assert!(checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
        graph.nodes[1..].iter().map(|n| n.name.trim_start_matches("cluster_list_").to_string()).collect()
    }

    #[test]
    fn only_long_lists_are_merged_and_end_where_they_were() {
        assert_eq!(nodes(2048), ["sort"]);
        assert_eq!(nodes(8192), ["sort", "merge_0_out", "merge_0_back"]);
        assert_eq!(nodes(8193), ["sort", "merge_0_out", "merge_0_back", "merge_1_out", "merge_1_back"]);
    }

    #[test]
    fn push_constants_are_the_shared_struct() {
        for program in [&list_sort::PROGRAM, &list_merge::PROGRAM] {
            assert_eq!(program.push_bytes as usize, size_of::<ListSortPush>(), "{}", program.name);
        }
    }
}
