//! Damaged files through loader, picture decoding and plan: each ends in a scene or in a sentence, in bounded time and memory,
//! and never in a panic. Some that load are drawn too. docs/FUZZING.md says how to make and repeat long runs.

pub mod allocator;
pub mod corpus;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use lampyris::graph::hazard;
use lampyris::passes;
use lampyris::plan::{Limits, Plan, Request};
use lampyris::scene::gltf;

use self::corpus::Original;
use crate::support;

/// The most that an input may take.
const TIME_LIMIT: Duration = Duration::from_secs(2);
/// An input that takes as long as this is held to hang.
const HANG: Duration = Duration::from_secs(120);
/// The most heap bytes that an input may take are this and so many a byte read.
const MEMORY_BASE: usize = 64 << 20;
const MEMORY_PER_BYTE: usize = 20;
/// Failures that are told one by one.
const MOST_TOLD: usize = 20;
/// The frame and its barriers are made for one input in so many.
const FRAME_EVERY: u64 = 16;
/// What errors have to begin with.
const NAME: &str = "damaged.glb";

fn setting(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a whole number")))
}

fn seed() -> u64 {
    setting("LAMPYRIS_FUZZ_SEED").unwrap_or(1)
}

/// What one call did.
struct Trial {
    /// True where the input was planned, false where it was refused; else what went wrong.
    outcome: Result<bool, String>,
    time: Duration,
    peak_bytes: usize,
}

impl Trial {
    fn of(call: impl Fn() -> Result<bool, String>) -> Self {
        let once = || {
            let start = Instant::now();
            let (caught, peak_bytes) = allocator::peak_of(|| catch_unwind(AssertUnwindSafe(&call)));
            let time = start.elapsed();
            Self { outcome: caught.unwrap_or_else(|_| Err("it panics".into())), time, peak_bytes }
        };
        let mut trial = once();
        // A busy machine is no defect: slow is what is slow three times.
        for _ in 0..2 {
            if trial.time > TIME_LIMIT {
                trial.time = trial.time.min(once().time);
            }
        }
        trial
    }

    /// Bytes held over bytes allowed, for so many bytes of files.
    fn memory_ratio(&self, file_bytes: usize) -> f64 {
        (self.peak_bytes + file_bytes) as f64 / (MEMORY_BASE + MEMORY_PER_BYTE * file_bytes) as f64
    }

    fn complaint(&self, file_bytes: usize) -> Option<String> {
        if let Err(what) = &self.outcome {
            return Some(what.clone());
        }
        if self.time > TIME_LIMIT {
            return Some(format!("it takes {:.2} s", self.time.as_secs_f64()));
        }
        (self.memory_ratio(file_bytes) > 1.0).then(|| {
            let mib = self.peak_bytes as f64 / f64::from(1 << 20);
            format!("it holds {mib:.1} MiB of heap for {file_bytes} bytes of files")
        })
    }
}

fn drive(bytes: &[u8], original: &Original, with_frame: bool) -> Result<bool, String> {
    let scene = match gltf::load_slice(bytes, original.base.as_deref(), NAME) {
        Ok(scene) => scene,
        Err(e) if e.to_string().starts_with(&format!("{NAME}: ")) => return Ok(false),
        Err(e) => return Err(format!("its error does not name the file: {e}")),
    };
    let request = Request { width: 64, height: 48, ..Request::default() };
    let Ok(plan) = Plan::new(&scene, &request, &Limits::MINIMUM) else { return Ok(false) };
    if with_frame {
        let frame = passes::frame(&plan);
        if hazard::derive(&frame.graph).is_empty() {
            return Err("its frame has no barrier, although the radiance is read back".into());
        }
    }
    Ok(true)
}

#[derive(Default)]
struct Totals {
    planned: u64,
    refused: u64,
    slowest: (Duration, u64),
    largest: (f64, u64),
    failed: u64,
    told: Vec<String>,
}

/// A run of inputs, and where its workers are.
struct Run<'a> {
    corpus: &'a [Original],
    seed: u64,
    end: u64,
    next: AtomicU64,
    totals: Mutex<Totals>,
    busy: Vec<Mutex<Option<(u64, Instant)>>>,
}

impl<'a> Run<'a> {
    fn new(corpus: &'a [Original], seed: u64, indices: std::ops::Range<u64>, threads: usize) -> Self {
        let busy = (0..threads).map(|_| Mutex::default()).collect();
        let (next, end) = (AtomicU64::new(indices.start), indices.end);
        Self { corpus, seed, end, next, totals: Mutex::default(), busy }
    }

    fn work(&self, worker: usize) {
        loop {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            if index >= self.end {
                return;
            }
            *self.busy[worker].lock().expect("no worker panics") = Some((index, Instant::now()));
            let (original, bytes) = corpus::damaged(self.corpus, self.seed, index);
            let file_bytes = bytes.len() + original.companion_bytes;
            let trial = Trial::of(|| drive(&bytes, original, index.is_multiple_of(FRAME_EVERY)));
            *self.busy[worker].lock().expect("no worker panics") = None;
            self.count(index, original, file_bytes, &trial);
        }
    }

    fn count(&self, index: u64, original: &Original, file_bytes: usize, trial: &Trial) {
        let mut totals = self.totals.lock().expect("no worker panics");
        match trial.outcome {
            Ok(true) => totals.planned += 1,
            Ok(false) => totals.refused += 1,
            Err(_) => {}
        }
        if trial.time > totals.slowest.0 {
            totals.slowest = (trial.time, index);
        }
        let ratio = trial.memory_ratio(file_bytes);
        if ratio > totals.largest.0 {
            totals.largest = (ratio, index);
        }
        if let Some(complaint) = trial.complaint(file_bytes) {
            totals.failed += 1;
            if totals.told.len() < MOST_TOLD {
                totals.told.push(format!("seed {} index {index} ({}): {complaint}", self.seed, original.name));
            }
        }
    }

    /// Ends the process where an input hangs, since nothing else can end it.
    fn watch(&self) {
        for busy in &self.busy {
            if let Some((index, since)) = *busy.lock().expect("no worker panics")
                && since.elapsed() > HANG
            {
                eprintln!("seed {} index {index}: it hangs", self.seed);
                std::process::exit(1);
            }
        }
    }

    fn finish(self) -> Totals {
        thread::scope(|scope| {
            let run = &self;
            let workers: Vec<_> = (0..run.busy.len()).map(|worker| scope.spawn(move || run.work(worker))).collect();
            while workers.iter().any(|w| !w.is_finished()) {
                thread::sleep(Duration::from_millis(20));
                run.watch();
            }
        });
        self.totals.into_inner().expect("no worker panics")
    }
}

#[test]
fn damaged_files_end_in_a_scene_or_a_sentence() {
    let corpus = corpus::all();
    let asked = setting("LAMPYRIS_FUZZ");
    let indices = match setting("LAMPYRIS_FUZZ_INDEX") {
        Some(index) => index..index + 1,
        None => 0..asked.unwrap_or(1500),
    };
    // A plain test run has other tests beside this one.
    let threads = if asked.is_some() { thread::available_parallelism().map_or(1, |n| n.get()) } else { 1 };
    let (seed, count, start) = (seed(), indices.end - indices.start, Instant::now());
    let totals = Run::new(&corpus, seed, indices, threads).finish();
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{count} inputs of seed {seed} from {} files: {} planned, {} refused; slowest {:.3} s (index {}), largest memory \
         {:.1} % of what is allowed (index {}); {:.0} inputs a second on {threads} threads",
        corpus.len(),
        totals.planned,
        totals.refused,
        totals.slowest.0.as_secs_f64(),
        totals.slowest.1,
        totals.largest.0 * 100.0,
        totals.largest.1,
        count as f64 / seconds,
    );
    assert!(totals.told.is_empty(), "{} inputs fail:\n{}", totals.failed, totals.told.join("\n"));
    if count >= 1000 {
        let is_balanced = totals.planned * 50 > count && totals.refused * 50 > count;
        assert!(is_balanced, "the damage is too weak or too strong: {} planned of {count}", totals.planned);
    }
}

#[test]
fn what_goes_wrong_with_an_input_is_noticed() {
    let complaint = |call: &dyn Fn() -> Result<bool, String>| Trial::of(call).complaint(1000);
    assert_eq!(complaint(&|| Ok(true)), None);
    assert_eq!(complaint(&|| Err("a wrong name".into())).as_deref(), Some("a wrong name"));
    assert_eq!(complaint(&|| panic!("on purpose, to see that it is caught")).as_deref(), Some("it panics"));
    let hold = |bytes: usize| Ok(std::hint::black_box(vec![1u8; bytes]).len() == bytes);
    assert_eq!(complaint(&|| hold(MEMORY_BASE)), None);
    assert!(complaint(&|| hold(MEMORY_BASE + 20_000)).is_some_and(|c| c.contains("64.0 MiB of heap for 1000 bytes")));
    let slow = Trial { outcome: Ok(true), time: TIME_LIMIT * 2, peak_bytes: 0 };
    assert_eq!(slow.complaint(1000).as_deref(), Some("it takes 4.00 s"));
}

#[test]
fn fuzzed_scenes_are_drawn() {
    let Some(gpu) = support::gpu() else { return };
    let (corpus, seed) = (corpus::all(), seed());
    let wanted = setting("LAMPYRIS_FUZZ_DRAWN").unwrap_or(12);
    let request = Request { width: 48, height: 32, ..Request::default() };
    let (mut drawn, mut not_finite, mut index) = (0, 0, 0);
    while drawn < wanted {
        assert!(
            index < 100 * wanted,
            "{drawn} of the first {index} damaged files can be drawn: the damage is too strong"
        );
        let (original, bytes) = corpus::damaged(&corpus, seed, index);
        let what = format!("seed {seed} index {index} ({})", original.name);
        index += 1;
        let Ok(scene) = gltf::load_slice(&bytes, original.base.as_deref(), NAME) else { continue };
        let Ok(plan) = Plan::new(&scene, &request, &gpu.limits()) else { continue };
        let mut prepared = gpu.prepare(&scene, &plan).unwrap_or_else(|e| panic!("{what}: {e}"));
        prepared.draw(1).unwrap_or_else(|e| panic!("{what}: {e}"));
        let picture = prepared.read_back().unwrap_or_else(|e| panic!("{what}: {e}"));
        let violations = prepared.check();
        assert!(violations.is_empty(), "{what}: {violations:#?}");
        drop(prepared);
        let messages = gpu.take_messages();
        assert!(messages.is_empty(), "{what}: {messages:#?}");
        assert_eq!((picture.width, picture.height), (48, 32), "{what}");
        let radiance = picture.layer("radiance").expect("radiance is read back");
        assert_eq!(radiance.len(), 48 * 32 * 4, "{what}");
        not_finite += u64::from(radiance.iter().any(|x| !x.is_finite()));
        drawn += 1;
    }
    println!(
        "{drawn} of the first {index} damaged files of seed {seed} drawn; {not_finite} pictures are not finite everywhere"
    );
}
