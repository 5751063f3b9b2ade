//! Scan and radix sort on the device against the scan's twin and the stable sort of the standard library (C7).

use super::Row;
use crate::error::Result;
use crate::graph::access::ComputeStorageWrite;
use crate::graph::{BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::passes::{self, Frame, SceneHandles};
use crate::plan::{Plan, Request};
use crate::reference;
use crate::renderer::Renderer;
use crate::scene::{Scene, builtin};
use crate::shaders::prim::make_keys;
use crate::shared::{KEYS_ASCENDING, KEYS_DESCENDING, KEYS_EQUAL, KEYS_EXTREME, KEYS_HASHED};

/// More than one block and more than two levels of scans: the largest count of C7.
const MANY: u32 = (1 << 20) + 1;

/// Keys that the device makes for itself, each with its index as value.
#[derive(Debug, Clone, Copy)]
struct Keys {
    /// One of `KEYS_*`.
    kind: u32,
    /// Bits that are kept.
    mask: u32,
}

impl Keys {
    const fn new(kind: u32, mask: u32) -> Self {
        Self { kind, mask }
    }

    /// What the device makes, made here.
    fn list(self, count: u32) -> Vec<u32> {
        (0..count).map(|i| reference::radix_sort::key(self.kind, i) & self.mask).collect()
    }

    /// Adds the node that makes them; keys and values.
    fn add(self, graph: &mut Graph, count: u32) -> (BufferHandle, BufferHandle) {
        let [keys, values] =
            ["keys", "values"].map(|what| graph.word_buffer(what, u64::from(count) * 4, Lifetime::Transient));
        let set = make_keys::Bindings { keys: ComputeStorageWrite(keys), values: ComputeStorageWrite(values) };
        let spec = make_keys::Spec { KIND: self.kind, MASK: self.mask };
        let pipeline = ComputePipeline { program: &make_keys::PROGRAM, constants: spec.values() };
        let groups = [count.div_ceil(make_keys::PROGRAM.local_size[0]).max(1), 1, 1];
        graph.add(
            "make_keys",
            Work::Dispatch { pipeline, bindings: set.list(), push: Vec::new(), groups: Groups::Fixed(groups) },
        );
        (keys, values)
    }
}

/// Where graphs without a picture run; counts what the checker finds in all of them.
struct Runner<'a> {
    renderer: &'a Renderer,
    scene: Scene,
    plan: Plan,
    violations: usize,
}

impl<'a> Runner<'a> {
    fn new(renderer: &'a Renderer) -> Result<Self> {
        let scene = builtin::load("furnace")?;
        let plan = Plan::new(&scene, &Request { width: 8, height: 8, ..crate::checks::forward() }, &renderer.limits())?;
        Ok(Self { renderer, scene, plan, violations: 0 })
    }

    /// Draws two frames of what `build` adds; the words of the buffers that it names, after the second.
    fn run(&mut self, build: impl FnOnce(&mut Graph) -> Vec<(&'static str, BufferHandle)>) -> Result<Vec<Vec<u32>>> {
        let mut graph = Graph::new();
        let scene = SceneHandles::declare(&mut graph, &self.plan);
        let made = build(&mut graph);
        graph.end_frame();
        let mut results = Vec::with_capacity(made.len());
        for (name, buffer) in made {
            let bytes = graph.buffer_info(buffer).bytes;
            let host = graph.buffer(&format!("{name} (host)"), bytes, Lifetime::ReadBack);
            graph.add(&format!("read_{name}"), Work::CopyBuffer { from: buffer, to: host });
            results.push((name, host));
        }
        let hosts: Vec<_> = results.iter().map(|r| r.1).collect();
        graph.host_read(&hosts);
        let frame = Frame { graph, scene, results };
        let mut prepared = self.renderer.prepare_frame(&self.scene, &self.plan, frame)?;
        prepared.draw(2)?;
        let (picture, violations) = prepared.finish()?;
        self.violations += violations.len();
        // Layers are words whose bits went through f32 untouched: they were only copied.
        Ok(picture.layers.iter().map(|(_, values)| values.iter().map(|x| x.to_bits()).collect()).collect())
    }

    fn barriers(&self, of: &str) -> Row {
        Row::none(format!("barriers of {of} proved"), self.violations, "violations")
    }
}

/// Words of `wanted` that `found` has not in their places.
fn elsewhere(found: &[u32], wanted: &[u32]) -> usize {
    wanted.iter().enumerate().filter(|(i, word)| found.get(*i) != Some(*word)).count()
}

/// Words of sorted keys and values that lie elsewhere than the stable order by the keys' low bits puts them.
fn misplaced(results: &[Vec<u32>], keys: &[u32], bits: u32) -> usize {
    let mask = u32::MAX.checked_shr(u32::BITS - bits).unwrap_or(0);
    let mut pairs: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
    pairs.sort_by_key(|&(key, _)| key & mask);
    let (keys, indices): (Vec<u32>, Vec<u32>) = pairs.into_iter().unzip();
    match results {
        [sorted_keys, sorted_values] => elsewhere(sorted_keys, &keys) + elsewhere(sorted_values, &indices),
        _ => 2 * keys.len() + 1,
    }
}

/// A sort of `count` keys; words that lie elsewhere than the stable sort puts them.
fn sorted(runner: &mut Runner<'_>, keys: Keys, count: u32, bits: u32) -> Result<usize> {
    let results = runner.run(|graph| {
        let (keys, values) = keys.add(graph, count);
        let (keys, values) = passes::radix_sort::add(graph, "check", keys, values, count, bits);
        vec![("keys", keys), ("values", values)]
    })?;
    Ok(misplaced(&results, &keys.list(count), bits))
}

/// The same where a buffer says how many of `capacity` keys there are.
fn sorted_counted(runner: &mut Runner<'_>, keys: Keys, capacity: u32, count: u32) -> Result<usize> {
    let results = runner.run(|graph| {
        let (keys, values) = keys.add(graph, capacity);
        let key_count = graph.word_buffer("key_count", 4, Lifetime::Transient);
        graph.add("fill_key_count", Work::Fill { buffer: key_count, word: count });
        let (keys, values) = passes::radix_sort::add_counted(graph, "check", keys, values, capacity, key_count, 32);
        vec![("keys", keys), ("values", values)]
    })?;
    Ok(misplaced(&results, &keys.list(count.min(capacity)), 32))
}

/// A scan of `each` items for each of as many things as a buffer says, of `capacity` items at most; words elsewhere than its twin's.
fn scanned_counted(runner: &mut Runner<'_>, keys: Keys, capacity: u32, [count, each]: [u32; 2]) -> Result<usize> {
    let results = runner.run(|graph| {
        let (items, _) = keys.add(graph, capacity);
        let total = graph.word_buffer("total", 4, Lifetime::Transient);
        graph.add("fill_total", Work::Fill { buffer: total, word: count });
        let counted = passes::group_count::add(graph, "check", total, capacity / each, each);
        vec![("offsets", passes::scan::add_counted(graph, "check", items, capacity, &counted))]
    })?;
    let wanted = reference::scan::run(&keys.list((count * each).min(capacity)));
    Ok(results.first().map_or(wanted.len(), |found| elsewhere(found, &wanted)))
}

/// Row C7: none, one, around one block and very many keys; alike, all distinct, sorted, reversed, extreme, and by few bits.
///
/// # Errors
/// No memory, or a lost device.
pub fn sort(renderer: &Renderer) -> Result<Vec<Row>> {
    const ALL: u32 = u32::MAX;
    const DISTINCT: Keys = Keys::new(KEYS_HASHED, ALL);
    const EXTREME: Keys = Keys::new(KEYS_EXTREME, ALL);
    // Keys and the bits they are sorted by.
    const KINDS: [(Keys, u32); 7] = [
        (Keys::new(KEYS_EQUAL, ALL), 32),
        (DISTINCT, 32),
        (Keys::new(KEYS_ASCENDING, ALL), 32),
        (Keys::new(KEYS_DESCENDING, ALL), 32),
        (EXTREME, 32),
        (Keys::new(KEYS_HASHED, 15), 4),
        (DISTINCT, 10),
    ];
    let mut runner = Runner::new(renderer)?;
    let mut rows = Vec::new();
    let cases: [(u32, &[(Keys, u32)]); 6] = [
        (0, &[(DISTINCT, 32)]),
        (1, &[(DISTINCT, 32)]),
        (255, &KINDS),
        (256, &KINDS),
        (257, &KINDS),
        (MANY, &[(DISTINCT, 32), (EXTREME, 32)]),
    ];
    for (count, kinds) in cases {
        let mut wrong = 0;
        for &(keys, bits) in kinds {
            wrong += sorted(&mut runner, keys, count, bits)?;
        }
        rows.push(Row::none(format!("C7 sort of {count} keys, {} kinds", kinds.len()), wrong, "words elsewhere"));
    }
    let mut wrong = 0;
    // Reversed, so that a key beyond the count would come first; the last count is more than there is room for.
    for count in [0, 1, 256, 257, 600, 1000] {
        wrong += sorted_counted(&mut runner, Keys::new(KEYS_DESCENDING, ALL), 600, count)?;
    }
    rows.push(Row::none("C7 sort of as many keys as a buffer says", wrong, "words elsewhere"));
    rows.push(runner.barriers("the sort"));
    Ok(rows)
}

/// The scan against its twin: none, one, around a run, around a run of runs, and very many items.
///
/// # Errors
/// No memory, or a lost device.
pub fn scan(renderer: &Renderer) -> Result<Vec<Row>> {
    // Ones, and items below 2^12, of which 2^20 + 1 add up to less than 2^32.
    const ONES: Keys = Keys::new(KEYS_EQUAL, 1);
    const MIXED: Keys = Keys::new(KEYS_HASHED, 0xfff);
    let mut runner = Runner::new(renderer)?;
    let mut wrong = 0;
    let small = [0, 1, 63, 64, 65, 4095, 4096, 4097].into_iter().flat_map(|count| [(count, ONES), (count, MIXED)]);
    for (count, keys) in small.chain([(MANY, MIXED)]) {
        let results = runner.run(|graph| {
            let (items, _) = keys.add(graph, count);
            vec![("offsets", passes::scan::add(graph, "check", items, count))]
        })?;
        let wanted = reference::scan::run(&keys.list(count));
        wrong += results.first().map_or(wanted.len(), |found| elsewhere(found, &wanted));
    }
    let mut counted = 0;
    // Around a run and a group of runs; the last is more than there is room for.
    for count in [0, 1, 64, 65, 2048, 2049, 3000, 9000] {
        for each in [1, 3] {
            counted += scanned_counted(&mut runner, MIXED, 9000, [count, each])?;
        }
    }
    Ok(vec![
        Row::none("scan equals its twin", wrong, "words elsewhere"),
        Row::none("scan of as many items as a buffer says", counted, "words elsewhere"),
        runner.barriers("the scan"),
    ])
}
