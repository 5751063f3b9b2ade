//! Controls: what would catch a fault is shown to catch one.

use lampyris::graph::{Graph, Lifetime, Work, checker, log::Event};
use lampyris::passes::{Frame, SceneHandles};
use lampyris::plan::{Plan, Request, Technique};
use lampyris::scene::builtin;

use crate::support;

/// A fill and a copy of what it wrote; the layer of Debian 12 does not follow attachments of dynamic rendering, but it does follow
/// these.
fn fill_then_copy(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let filled = graph.buffer("filled", 256, Lifetime::Transient);
    let copied = graph.buffer("copied", 256, Lifetime::ReadBack);
    graph.add("fill", Work::Fill { buffer: filled, word: 7 });
    graph.add("copy", Work::CopyBuffer { from: filled, to: copied });
    graph.host_read(&[copied]);
    Frame { graph, scene, results: Vec::new() }
}

#[test]
fn a_missing_barrier_is_reported_by_the_layer() {
    let Some(gpu) = support::gpu() else { return };
    let scene = builtin::load("furnace").expect("a built-in scene");
    let request = Request { width: 8, height: 8, technique: Technique::Forward, ..Request::default() };
    let plan = Plan::new(&scene, &request, &gpu.limits()).expect("a plan");
    let mut prepared = gpu.prepare_frame(&scene, &plan, fill_then_copy(&plan)).expect("a frame");
    prepared.draw(1).expect("a frame");
    let before = gpu.take_messages();
    assert!(before.is_empty(), "{before:#?}");
    assert!(prepared.check().is_empty(), "{:#?}", prepared.check());
    prepared.forget_barrier("copy", "filled");
    prepared.draw(1).expect("a frame");
    let messages = gpu.take_messages();
    // The layers of 2023 and of 2026 spell it differently.
    let is_hazard = |m: &String| m.contains("READ_AFTER_WRITE") || m.contains("READ-AFTER-WRITE");
    let hazard = messages.iter().any(is_hazard);
    assert!(hazard, "the layer is silent about a missing barrier, so nothing else here proves anything: {messages:#?}");
    assert!(!prepared.check().is_empty(), "our own checker is silent about a missing barrier");
}

#[test]
fn the_checker_reads_what_was_recorded() {
    let Some(gpu) = support::gpu() else { return };
    let scene = builtin::load("cornell").expect("a built-in scene");
    let request = Request { width: 32, height: 32, technique: Technique::Forward, ..Request::default() };
    let plan = Plan::new(&scene, &request, &gpu.limits()).expect("a plan");
    let mut prepared = gpu.prepare(&scene, &plan).expect("a frame");
    prepared.draw(3).expect("frames");
    assert!(prepared.check().is_empty(), "{:#?}", prepared.check());
    let graph = prepared.graph().0;
    let barriers = prepared.log().iter().filter(|e| matches!(e, Event::Barrier(_))).count();
    assert!(barriers >= 6, "two nodes with barriers in three frames, found {barriers}");
    let without: Vec<_> = prepared.log().iter().filter(|e| !matches!(e, Event::Barrier(_))).cloned().collect();
    assert!(!checker::check(graph, &without).is_empty());
}

#[test]
fn validation_without_the_layer_is_refused() {
    // The layer is looked for where the loader looks; a name that is nowhere stands for a machine without it.
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_lampyris"))
        .args(["render", "builtin:furnace", "--size", "8x8", "--validate", "-o", "/tmp/never-written.png"])
        .env("VK_LAYER_PATH", "/nonexistent")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("VK_LAYER_KHRONOS_validation"));
}

#[test]
fn a_missing_barrier_to_the_host_is_found() {
    let Some(gpu) = support::gpu() else { return };
    let scene = builtin::load("furnace").expect("a built-in scene");
    let request = Request { width: 8, height: 8, technique: Technique::Forward, ..Request::default() };
    let plan = Plan::new(&scene, &request, &gpu.limits()).expect("a plan");
    let mut prepared = gpu.prepare(&scene, &plan).expect("a frame");
    prepared.draw(1).expect("a frame");
    prepared.forget_barrier("host_read", "radiance (host)");
    prepared.read_back().expect("a picture");
    let found = prepared.check();
    assert!(found.iter().any(|v| v.second.starts_with("host_read")), "{found:#?}");
}
