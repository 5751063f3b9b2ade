//! Lists that are sorted on the device against the sort of the standard library: none, short, long, and longer than one thread sorts.

use super::Row;
use crate::error::Result;
use crate::graph::access::ComputeStorageWrite;
use crate::graph::{BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::passes::tile_cull::Lists;
use crate::passes::{self, Frame, SceneHandles};
use crate::plan::list_sort::ListSort;
use crate::plan::{Plan, Request};
use crate::reference;
use crate::renderer::Renderer;
use crate::scene::builtin;
use crate::shaders::prim::make_keys;
use crate::shared::{KEYS_DESCENDING, KEYS_EQUAL, KEYS_HASHED};

/// Lists whose lengths and entries the device makes for itself.
struct Case {
    name: &'static str,
    list_count: u32,
    stride: u32,
    /// One of `KEYS_*`, and the bits of it that are kept: the length of each stretch of a list.
    lengths: (u32, u32),
    /// The same for the entries.
    entries: (u32, u32),
}

/// Lengths of equal keys are their low bits: 9,637 of 14 bits, 42,405 of 16.
const CASES: [Case; 6] = [
    Case {
        name: "empty lists",
        list_count: 70,
        stride: 1,
        lengths: (KEYS_HASHED, 0),
        entries: (KEYS_HASHED, u32::MAX),
    },
    Case { name: "short lists", list_count: 3000, stride: 1, lengths: (KEYS_HASHED, 63), entries: (KEYS_HASHED, 0xff) },
    Case {
        name: "lists in 3 stretches",
        list_count: 500,
        stride: 3,
        lengths: (KEYS_HASHED, 255),
        entries: (KEYS_HASHED, u32::MAX),
    },
    Case {
        name: "long lists",
        list_count: 130,
        stride: 1,
        lengths: (KEYS_HASHED, 0xfff),
        entries: (KEYS_DESCENDING, u32::MAX),
    },
    Case {
        name: "lists of 9,637",
        list_count: 5,
        stride: 1,
        lengths: (KEYS_EQUAL, 0x3fff),
        entries: (KEYS_HASHED, u32::MAX),
    },
    Case {
        name: "lists of 42,405",
        list_count: 2,
        stride: 1,
        lengths: (KEYS_EQUAL, 0xffff),
        entries: (KEYS_HASHED, 0xffff),
    },
];

fn keys((kind, mask): (u32, u32), count: u32) -> Vec<u32> {
    (0..count).map(|index| reference::radix_sort::key(kind, index) & mask).collect()
}

/// Adds the node that makes them.
fn make(graph: &mut Graph, name: &str, (kind, mask): (u32, u32), count: u32) -> BufferHandle {
    let [keys, values] = [name.to_string(), format!("{name}_indices")]
        .map(|name| graph.word_buffer(&name, u64::from(count) * 4, Lifetime::Transient));
    let set = make_keys::Bindings { keys: ComputeStorageWrite(keys), values: ComputeStorageWrite(values) };
    let spec = make_keys::Spec { KIND: kind, MASK: mask };
    let pipeline = ComputePipeline { program: &make_keys::PROGRAM, constants: spec.values() };
    let groups = [count.div_ceil(make_keys::PROGRAM.local_size[0]).max(1), 1, 1];
    graph.add(
        &format!("make_{name}"),
        Work::Dispatch { pipeline, bindings: set.list(), push: Vec::new(), groups: Groups::Fixed(groups) },
    );
    keys
}

/// Words out of place, and what the checker finds, where the device knows how many lists there are or a buffer says.
fn sorted(renderer: &Renderer, case: &Case, counted: bool) -> Result<(usize, usize)> {
    let scene = builtin::load("furnace")?;
    let plan = Plan::new(&scene, &Request { width: 8, height: 8, ..crate::checks::forward() }, &renderer.limits())?;
    let stretches = case.list_count * case.stride;
    let offsets = reference::scan::run(&keys(case.lengths, stretches));
    let ends: Vec<usize> = offsets.iter().step_by(case.stride as usize).map(|&o| o as usize).collect();
    let entry_count = offsets[stretches as usize];
    let longest = ends.windows(2).map(|w| (w[1] - w[0]) as u32).max().unwrap_or(0);
    let sort = ListSort { list_count: case.list_count, stride: case.stride, entry_count: entry_count.into(), longest };
    sort.check(&renderer.limits())?;
    let mut graph = Graph::new();
    let handles = SceneHandles::declare(&mut graph, &plan);
    let lengths = make(&mut graph, "lengths", case.lengths, stretches);
    let lists = make(&mut graph, "lists", case.entries, entry_count);
    let device_offsets = passes::scan::add(&mut graph, "lists", lengths, stretches);
    if counted {
        let total = graph.word_buffer("total", 4, Lifetime::Transient);
        graph.add("fill_total", Work::Fill { buffer: total, word: case.list_count });
        let counted = passes::group_count::add(&mut graph, "check", total, case.list_count, 1);
        let lists = Lists { lights: lists, offsets: device_offsets };
        passes::list_sort::add_counted(&mut graph, "check", &sort, lists, &counted);
    } else {
        passes::list_sort::add(&mut graph, "check", &sort, device_offsets, lists);
    }
    graph.end_frame();
    let results = passes::read_back::add_all(&mut graph, &[], &[("lists", lists)]);
    let mut prepared = renderer.prepare_frame(&scene, &plan, Frame { graph, scene: handles, results })?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    let found = picture.layer("lists").unwrap_or(&[]);
    let mut wanted = keys(case.entries, entry_count);
    for list in ends.windows(2) {
        wanted[list[0]..list[1]].sort_unstable();
    }
    let elsewhere = wanted.iter().enumerate().filter(|(i, word)| found.get(*i).map(|x| x.to_bits()) != Some(**word));
    Ok((elsewhere.count(), violations.len()))
}

/// Lists of every length that the sort treats in a way of its own.
///
/// # Errors
/// No memory, or a lost device.
pub fn list_sort(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut violations = 0;
    for case in &CASES {
        for (how, counted) in [("", false), (", counted", true)] {
            let (elsewhere, found) = sorted(renderer, case, counted)?;
            violations += found;
            rows.push(Row::none(format!("C7 sort of {}{how}", case.name), elsewhere, "words elsewhere"));
        }
    }
    rows.push(Row::none("barriers of the list sort proved", violations, "violations"));
    Ok(rows)
}
