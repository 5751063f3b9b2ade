//! Radix sort: u32 keys with u32 values, stable, from the lowest digit of 4 bits to the highest (D. Knuth, "The Art of Computer
//! Programming", volume 3, section 5.2.5; by blocks as N. Satish, M. Harris and M. Garland, "Designing Efficient Sorting
//! Algorithms for Manycore GPUs", IPDPS 2009). For each digit `radix_count` counts the digits of each block of `RADIX_BLOCK` keys,
//! a scan turns counts into places, and `radix_scatter` moves keys with values. Between digits they lie side by side in one
//! buffer, so that a shader binds four buffers at most; the last digit moves keys and values apart, in a node each.
//!
//! Reads: keys, values, and their number where only the device knows it. Writes: sorted keys and sorted values. Group shape: 32
//! threads, a block each, walked through in order, which is what makes the sort stable on any device. Limits: 65,535 groups are
//! 536 million keys, and more are refused when the frame is prepared; a number of keys past the capacity counts as the
//! capacity, so the caller sees to room for all. CPU twin: `reference/radix_sort.rs`.

use bytemuck::bytes_of;

use super::scan::Scan;
use crate::graph::access::{ComputeStorageRead, ComputeStorageWrite};
use crate::graph::program::Program;
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::shaders::prim::{radix_count, radix_scatter};
use crate::shared::{MOVED_KEYS, MOVED_PAIRS, MOVED_VALUES, RADIX_BITS, RADIX_BLOCK, RADIX_DIGITS, RadixPush};

/// Adds a sort of the first `count` keys by their low `bits` bits (32 at most); sorted keys and values. Without bits there is
/// nothing to do, and the input comes back.
pub fn add(
    graph: &mut Graph,
    name: &str,
    keys: BufferHandle,
    values: BufferHandle,
    count: u32,
    bits: u32,
) -> (BufferHandle, BufferHandle) {
    add_digits(graph, name, Source { keys, values, pairs: false }, Size { capacity: count, count: None }, bits)
}

/// As [`add`] for a number of keys that only the device knows: the word of `count`, at most `capacity`. What the results hold
/// behind it is not defined.
pub fn add_counted(
    graph: &mut Graph,
    name: &str,
    keys: BufferHandle,
    values: BufferHandle,
    capacity: u32,
    count: BufferHandle,
    bits: u32,
) -> (BufferHandle, BufferHandle) {
    add_digits(graph, name, Source { keys, values, pairs: false }, Size { capacity, count: Some(count) }, bits)
}

/// Where keys and values lie before a digit.
#[derive(Debug, Clone, Copy)]
struct Source {
    keys: BufferHandle,
    values: BufferHandle,
    /// Both are one buffer of (key, value).
    pairs: bool,
}

/// How many keys there are, or room for how many and the buffer that says.
#[derive(Debug, Clone, Copy)]
struct Size {
    capacity: u32,
    count: Option<BufferHandle>,
}

fn add_digits(graph: &mut Graph, name: &str, input: Source, size: Size, bits: u32) -> (BufferHandle, BufferHandle) {
    let bits = bits.min(u32::BITS);
    let Some(last) = bits.div_ceil(RADIX_BITS).checked_sub(1) else { return (input.keys, input.values) };
    let bytes = |words: u32| u64::from(words) * 4;
    let block_count = size.capacity.div_ceil(RADIX_BLOCK).max(1);
    let digit_counts = RADIX_DIGITS * block_count;
    let counts = graph.word_buffer(&format!("{name}_digit_counts"), bytes(digit_counts), Lifetime::Transient);
    let scan = Scan::declare(graph, &format!("{name}_digit"), digit_counts);
    let pairs: Vec<_> = (0..last.min(2))
        .map(|i| graph.word_buffer(&format!("{name}_pairs_{i}"), 2 * bytes(size.capacity), Lifetime::Transient))
        .collect();
    let results = ["keys", "values"]
        .map(|what| graph.word_buffer(&format!("{name}_sorted_{what}"), bytes(size.capacity), Lifetime::Transient));
    let mut source = input;
    for digit in 0..=last {
        let shift = digit * RADIX_BITS;
        let mask = (1u32 << (bits - shift).min(RADIX_BITS)) - 1;
        let step = Step {
            name: format!("{name}_digit_{digit}"),
            source,
            push: RadixPush { capacity: size.capacity, block_count, shift, mask },
        };
        step.count(graph, size.count, counts);
        let offsets = scan.add(graph, &step.name, counts);
        if digit < last {
            let target = pairs[digit as usize % 2];
            step.scatter(graph, "radix_scatter", offsets, (MOVED_PAIRS, target));
            source = Source { keys: target, values: target, pairs: true };
        } else {
            step.scatter(graph, "radix_scatter_keys", offsets, (MOVED_KEYS, results[0]));
            step.scatter(graph, "radix_scatter_values", offsets, (MOVED_VALUES, results[1]));
        }
    }
    (results[0], results[1])
}

/// One digit.
struct Step {
    name: String,
    source: Source,
    push: RadixPush,
}

impl Step {
    fn count(&self, graph: &mut Graph, key_count: Option<BufferHandle>, counts: BufferHandle) {
        let set = radix_count::Bindings {
            keys: ComputeStorageRead(self.source.keys),
            // Not read where the number is known; something has to be bound.
            key_count: ComputeStorageRead(key_count.unwrap_or(self.source.keys)),
            digit_counts: ComputeStorageWrite(counts),
        };
        let spec = radix_count::Spec { SOURCE_PAIRS: self.source.pairs, COUNT_IN_BUFFER: key_count.is_some() };
        let work = self.dispatch(&radix_count::PROGRAM, spec.values(), set.list());
        graph.add(&format!("{}_radix_count", self.name), work);
    }

    fn scatter(&self, graph: &mut Graph, what: &str, offsets: BufferHandle, (moved, target): (u32, BufferHandle)) {
        let set = radix_scatter::Bindings {
            keys: ComputeStorageRead(self.source.keys),
            values: ComputeStorageRead(self.source.values),
            digit_offsets: ComputeStorageRead(offsets),
            moved: ComputeStorageWrite(target),
        };
        let spec = radix_scatter::Spec { SOURCE_PAIRS: self.source.pairs, MOVED: moved };
        let work = self.dispatch(&radix_scatter::PROGRAM, spec.values(), set.list());
        graph.add(&format!("{}_{what}", self.name), work);
    }

    fn dispatch(&self, program: &'static Program, constants: Vec<(u32, u32)>, bindings: Vec<Binding>) -> Work {
        let groups = Groups::Fixed([self.push.block_count.div_ceil(program.local_size[0]), 1, 1]);
        let push = bytes_of(&self.push).to_vec();
        Work::Dispatch { pipeline: ComputePipeline { program, constants }, bindings, push, groups }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};

    fn words(graph: &mut Graph, name: &str, count: u64) -> BufferHandle {
        graph.word_buffer(name, count * 4, Lifetime::Static)
    }

    #[test]
    fn each_digit_counts_scans_and_scatters() {
        let mut graph = Graph::new();
        let (keys, values) = (words(&mut graph, "keys", 4096), words(&mut graph, "values", 4096));
        let (sorted_keys, sorted_values) = add(&mut graph, "tile", keys, values, 4096, 6);
        assert_eq!(graph.buffer_info(sorted_keys).name, "tile_sorted_keys");
        assert_eq!(graph.buffer_info(sorted_values).bytes, 4096 * 4);
        let names: Vec<_> = graph.nodes.iter().map(|n| n.name.trim_start_matches("tile_digit_")).collect();
        let digit = |digit: u32, scatters: &[&str]| -> Vec<String> {
            let mut steps = vec!["radix_count", "scan_sum_0", "scan_spread_1", "scan_spread_0"];
            steps.extend(scatters);
            steps.iter().map(|step| format!("{digit}_{step}")).collect()
        };
        let wanted = [digit(0, &["radix_scatter"]), digit(1, &["radix_scatter_keys", "radix_scatter_values"])].concat();
        assert_eq!(names, wanted);
    }

    #[test]
    fn any_number_of_digits_is_ordered() {
        for bits in [1, 4, 8, 12, 32, 40] {
            let mut graph = Graph::new();
            let (keys, values) = (words(&mut graph, "keys", 300), words(&mut graph, "values", 300));
            let count = words(&mut graph, "count", 1);
            add_counted(&mut graph, "sort", keys, values, 300, count, bits);
            assert!(graph.problems().is_empty(), "{bits} bits");
            let barriers = hazard::derive(&graph);
            assert!(checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty(), "{bits} bits");
        }
    }

    #[test]
    fn no_shader_binds_more_than_four_storage_buffers() {
        for program in [&radix_count::PROGRAM, &radix_scatter::PROGRAM] {
            assert!(program.slots.iter().filter(|s| s.kind.is_storage_buffer()).count() <= 4, "{}", program.name);
            assert_eq!(program.push_bytes as usize, size_of::<RadixPush>(), "{}", program.name);
        }
    }

    #[test]
    fn without_bits_the_input_comes_back() {
        let mut graph = Graph::new();
        let (keys, values) = (words(&mut graph, "keys", 9), words(&mut graph, "values", 9));
        assert_eq!(add(&mut graph, "sort", keys, values, 9, 0), (keys, values));
        assert!(graph.nodes.is_empty());
    }
}
