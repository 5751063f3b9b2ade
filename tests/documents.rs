//! The documents say what is there: paths, tables, commands, keys and the barrier written by hand are compared with the program.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ash::vk;
use clap::Parser;
use lampyris::cli::Cli;
use lampyris::gpu::memory::aspect_of;
use lampyris::graph::hazard::{self, Barrier};
use lampyris::graph::{Access, Resource, checker, describe, log};
use lampyris::passes::{self, DEPTH_FORMAT, Frame};
use lampyris::plan::{Limits, Plan, Request, Technique};
use lampyris::scene::builtin;
use serde_json::Value;

const DOCUMENTS: [&str; 5] = ["README.md", "CHANGELOG.md", "docs/ARCHITECTURE.md", "docs/SYNC.md", "docs/ACCURACY.md"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn document(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Every line with the info string of the fenced block that it stands in, `None` outside of one; fences left out.
pub fn lines(text: &str) -> Vec<(Option<&str>, &str)> {
    let mut open = None;
    let mut found = Vec::new();
    for line in text.lines() {
        match (line.trim_start().strip_prefix("```"), open) {
            (Some(_), Some(_)) => open = None,
            (Some(info), None) => open = Some(info),
            (None, _) => found.push((open, line)),
        }
    }
    found
}

/// Spans in backticks outside of fenced blocks.
fn spans(text: &str) -> Vec<&str> {
    lines(text).into_iter().filter(|l| l.0.is_none()).flat_map(|l| l.1.split('`').skip(1).step_by(2)).collect()
}

/// Rows of the table under `heading` whose first cell begins with a span in backticks.
pub fn table<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let after = text.lines().skip_while(|l| *l != heading).skip(1);
    after.take_while(|l| !l.starts_with('#')).filter(|l| l.starts_with("| `")).collect()
}

/// The first span of each row of a table.
pub fn first_column<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let found: Vec<_> = table(text, heading).into_iter().filter_map(|row| row.split('`').nth(1)).collect();
    assert!(!found.is_empty(), "there is no table under {heading}");
    found
}

fn looks_like_a_path(span: &str) -> bool {
    const ENDINGS: [&str; 10] = [".rs", ".md", ".glsl", ".vert", ".frag", ".comp", ".txt", ".toml", ".sh", ".png"];
    let plain = span.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
    plain && (span.contains('/') || ENDINGS.iter().any(|e| span.ends_with(e)))
}

fn missing_paths<'a>(text: &'a str, root: &Path) -> Vec<&'a str> {
    spans(text).into_iter().filter(|s| looks_like_a_path(s) && !root.join(s).exists()).collect()
}

#[test]
fn paths_exist() {
    for name in ["docs/ARCHITECTURE.md", "docs/SYNC.md", "docs/ACCURACY.md"] {
        let text = document(name);
        assert!(spans(&text).iter().any(|s| looks_like_a_path(s)), "{name} names no path");
        assert_eq!(missing_paths(&text, root()), [""; 0], "{name}");
    }
}

#[test]
fn a_path_that_does_not_exist_is_found() {
    let text = "`src/lib.rs`, `src/no_such.rs`, `no_such.md`, `src/`, `a / b`, `f32`\n```text\n`no`\n```\n`no/such`";
    assert_eq!(missing_paths(text, root()), ["src/no_such.rs", "no_such.md", "no/such"]);
}

#[test]
fn links_lead_somewhere() {
    for name in DOCUMENTS {
        let text = document(name);
        let folder = root().join(name).parent().map(Path::to_path_buf).unwrap_or_default();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            if !file.is_empty() && !file.contains("://") {
                assert!(folder.join(file).exists(), "{name} links to {target}");
            }
        }
    }
}

#[test]
fn the_folder_map_is_complete() {
    let text = document("docs/ARCHITECTURE.md");
    let named = first_column(&text, "## Folder map");
    for entry in std::fs::read_dir(root().join("src")).expect("src").flatten() {
        let name = entry.file_name().into_string().expect("UTF-8");
        let path = if entry.path().is_dir() { format!("src/{name}/") } else { format!("src/{name}") };
        assert!(named.contains(&path.as_str()), "the folder map lacks {path}");
    }
}

fn access_row(access: Access) -> String {
    let code = |names: String| names.split('|').map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let (stages, flags) = (code(describe::stages(access.stages())), code(describe::accesses(access.flags())));
    let layout = match access.layout() {
        vk::ImageLayout::UNDEFINED => "none".to_string(),
        layout => format!("`{layout:?}`"),
    };
    format!("| `{}` | {stages} | {flags} | {layout} |", access.name())
}

#[test]
fn the_access_table_is_the_code() {
    let rows: Vec<String> = Access::ALL.iter().map(|&a| access_row(a)).collect();
    assert_eq!(table(&document("docs/SYNC.md"), "## The access table"), rows, "expected:\n{}", rows.join("\n"));
}

/// Every line of a `text` block of SYNC.md stands in a golden listing.
#[test]
fn quoted_listings_are_real() {
    let text = document("docs/SYNC.md");
    let listing = ["forward", "forward_shadows"].map(|name| document(&format!("tests/barriers/{name}.txt"))).concat();
    let quoted: Vec<_> = lines(&text).into_iter().filter(|l| l.0 == Some("text")).map(|l| l.1).collect();
    assert!(quoted.len() > 10, "only {} lines are quoted", quoted.len());
    for line in quoted {
        assert!(listing.lines().any(|l| l == line), "the listings lack: {line}");
    }
}

/// The barrier of the depth image between `depth_prepass` and `forward`; docs/SYNC.md shows this function as it stands here.
#[rustfmt::skip]
fn depth_between_prepass_and_forward(depth: vk::Image) -> vk::ImageMemoryBarrier2<'static> {
    use vk::{AccessFlags2 as A, ImageAspectFlags, ImageLayout as L, PipelineStageFlags2 as S};
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS)
        .src_access_mask(A::DEPTH_STENCIL_ATTACHMENT_WRITE)
        .dst_stage_mask(S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS)
        .dst_access_mask(A::DEPTH_STENCIL_ATTACHMENT_READ)
        .old_layout(L::DEPTH_ATTACHMENT_OPTIMAL)
        .new_layout(L::DEPTH_READ_ONLY_OPTIMAL)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(depth)
        .subresource_range(
            vk::ImageSubresourceRange::default()
                .aspect_mask(ImageAspectFlags::DEPTH)
                .level_count(1)
                .layer_count(1),
        )
}

fn forward_frame() -> (Frame, Vec<Barrier>) {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let request = Request { technique: Technique::Forward, ..Request::default() };
    let frame = passes::frame(&Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan"));
    let barriers = hazard::derive(&frame.graph);
    (frame, barriers)
}

/// Index of the derived barrier that the document writes by hand.
fn depth_barrier(frame: &Frame, barriers: &[Barrier]) -> usize {
    let graph = &frame.graph;
    let wanted = |b: &Barrier| graph.nodes[b.before].name == "forward" && graph.name_of(b.resource) == "depth";
    barriers.iter().position(wanted).expect("forward waits for depth")
}

#[test]
fn the_barrier_written_by_hand_is_the_derived_one() {
    let source = include_str!("documents.rs");
    let start = source.find("fn depth_between_prepass_and_forward(").expect("the function");
    let end = start + source[start..].find("\n}\n").expect("its end") + 3;
    let shown = document("docs/SYNC.md");
    assert!(shown.contains(&format!("```rust\n{}```", &source[start..end])), "docs/SYNC.md shows another barrier");

    let (frame, barriers) = forward_frame();
    let derived = &barriers[depth_barrier(&frame, &barriers)];
    let by_hand = depth_between_prepass_and_forward(vk::Image::null());
    assert_eq!((by_hand.src_stage_mask, by_hand.src_access_mask), (derived.src_stages, derived.src_access));
    assert_eq!((by_hand.dst_stage_mask, by_hand.dst_access_mask), (derived.dst_stages, derived.dst_access));
    assert_eq!((by_hand.old_layout, by_hand.new_layout), derived.layouts);
    assert_eq!(by_hand.src_queue_family_index, by_hand.dst_queue_family_index, "no queue hands over to another");
    let Resource::Image(image) = derived.resource else { panic!("depth is an image") };
    let range = by_hand.subresource_range;
    assert_eq!((range.base_mip_level, range.level_count), (0, frame.graph.image_info(image).levels));
    assert_eq!((range.base_array_layer, range.layer_count), (0, 1));
    assert_eq!(range.aspect_mask, aspect_of(DEPTH_FORMAT));
}

/// What the checker says first about one frame whose depth barrier was broken, by the way it was broken.
#[test]
fn broken_barriers_are_found_as_the_document_says() {
    let text = document("docs/SYNC.md");
    let (frame, barriers) = forward_frame();
    let index = depth_barrier(&frame, &barriers);
    let said = |broken: &[Barrier], count: usize| {
        let found = checker::check(&frame.graph, &log::declared(&frame.graph, broken, 1));
        found.iter().take(count).map(|v| format!("`{v}`")).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(said(&barriers, usize::MAX), "", "the whole frame is proved");
    let mut fewer = barriers.clone();
    fewer.remove(index);
    let mut rows = vec![("the barrier left out", said(&fewer, 2))];
    type Break = fn(&mut Barrier);
    let breaks: [(&str, Break); 3] = [
        ("only `EARLY_FRAGMENT_TESTS` in the first scope", |b| {
            b.src_stages = vk::PipelineStageFlags2::EARLY_FRAGMENT_TESTS;
        }),
        ("no access mask on the left", |b| b.src_access = vk::AccessFlags2::NONE),
        ("no access mask on the right", |b| b.dst_access = vk::AccessFlags2::NONE),
    ];
    for (what, change) in breaks {
        let mut broken = barriers.clone();
        change(&mut broken[index]);
        rows.push((what, said(&broken, 1)));
    }
    for (what, sentence) in rows {
        let row = format!("| {what} | {sentence} |");
        assert!(text.lines().any(|l| l == row), "docs/SYNC.md lacks {row}");
    }
}

fn lampyris(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lampyris")).args(arguments).output().expect("the program starts")
}

#[test]
fn the_command_table_is_the_program() {
    let text = document("README.md");
    let named: BTreeSet<String> =
        first_column(&text, "## Commands").into_iter().map(|c| c.trim_start_matches("lampyris ").to_string()).collect();
    let help = String::from_utf8(lampyris(&["--help"]).stdout).expect("UTF-8");
    let after = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    let word = |line: &str| Some(line.strip_prefix("  ")?.split(' ').next()?.to_string());
    let there: BTreeSet<String> = after.filter_map(word).filter(|w| !w.is_empty() && w != "help").collect();
    assert_eq!(named, there);
}

/// Calls of the program with arguments, in spans and in `sh` blocks, without what a shell reads itself.
fn calls(text: &str) -> Vec<Vec<&str>> {
    let in_blocks = lines(text).into_iter().filter(|l| l.0 == Some("sh")).map(|l| l.1);
    let mut found = Vec::new();
    for line in spans(text).into_iter().chain(in_blocks) {
        for part in line.split(" # ").next().unwrap_or_default().split("&&") {
            let program = part.split(" | ").next().unwrap_or_default();
            let words: Vec<_> = program.split_whitespace().skip_while(|w| *w != "lampyris").collect();
            // Two words name a command; what it wants besides is not said there.
            if words.len() > 2 {
                found.push(words);
            }
        }
    }
    found
}

#[test]
fn calls_in_the_documents_are_understood() {
    let texts = DOCUMENTS.map(document);
    let all: Vec<_> = texts.iter().flat_map(|text| calls(text)).collect();
    assert!(all.len() > 10, "only {} calls were found", all.len());
    for call in all {
        let parsed = Cli::try_parse_from(call.iter().copied());
        assert!(parsed.is_ok(), "{}: {}", call.join(" "), parsed.err().map(|e| e.to_string()).unwrap_or_default());
    }
}

#[test]
fn a_call_that_is_wrong_is_found() {
    let text = "`lampyris` and\n```sh\nX=1 lampyris plan --no-such # why\n```";
    assert_eq!(calls(text), [["lampyris", "plan", "--no-such"]]);
    assert!(Cli::try_parse_from(calls(text)[0].iter().copied()).is_err());
}

/// Dotted path of every leaf; an empty list or object is a leaf too.
fn leaves(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, inner) in map {
                leaves(inner, &if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, found);
            }
        }
        Value::Array(list) if !list.is_empty() => {
            list.iter().for_each(|inner| leaves(inner, &format!("{path}[]"), found));
        }
        _ => {
            found.insert(path.to_string());
        }
    }
}

/// `path` is `outer` or lies in it.
fn is_in(path: &str, outer: &str) -> bool {
    path.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// Keys that are there and not documented, and keys that are documented and not there. A documented key stands for all that
/// lies in it; an empty list or object or a null stands for all that could.
pub fn differences(documented: &[&str], value: &Value) -> Vec<String> {
    let mut there = BTreeSet::new();
    leaves(value, "", &mut there);
    let unknown = there.iter().filter(|p| !documented.iter().any(|d| is_in(p, d) || is_in(d, p)));
    let absent = documented.iter().filter(|d| !there.iter().any(|p| is_in(p, d) || is_in(d, p)));
    unknown.map(|p| format!("not documented: {p}")).chain(absent.map(|d| format!("not there: {d}"))).collect()
}

fn json(arguments: &[&str]) -> Value {
    let output = lampyris(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{arguments:?}: {e}"))
}

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lampyris-documents-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    folder
}

const NONE: [String; 0] = [];

#[test]
fn json_of_plan_is_documented() {
    let text = document("README.md");
    let (own, of_render) = (first_column(&text, "### JSON of `plan`"), first_column(&text, "### JSON of `render`"));
    let shared = |key: &&str| is_in(key, "scene") || is_in(key, "plan");
    let keys: Vec<&str> =
        own.into_iter().filter(|k| !shared(k)).chain(of_render.into_iter().filter(|k| shared(k))).collect();
    let value = json(&["plan", "builtin:cornell", "--limits", "minimum", "--json", "-"]);
    assert_eq!(differences(&keys, &value), NONE);
}

#[test]
fn json_of_render_and_diff_is_documented() {
    let text = document("README.md");
    let folder = scratch("reference");
    let picture = folder.join("a.exr").display().to_string();
    let render = ["render", "builtin:cornell", "--technique", "reference", "--size", "16x8", "--json", "-", "-o"];
    let value = json(&[&render[..], &[picture.as_str()]].concat());
    assert_eq!(differences(&first_column(&text, "### JSON of `render`"), &value), NONE);
    let value = json(&["diff", picture.as_str(), picture.as_str(), "--json", "-"]);
    assert_eq!(differences(&first_column(&text, "### JSON of `diff`"), &value), NONE);
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn json_that_needs_a_device_is_documented() {
    let required = std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1");
    let planned = lampyris(&["plan", "builtin:furnace", "--size", "8x8"]);
    if !planned.status.success() && !required {
        eprintln!("SKIPPED, no device: {}", String::from_utf8_lossy(&planned.stderr));
        return;
    }
    let text = document("README.md");
    let documented = |command: &str| first_column(&text, &format!("### JSON of `{command}`"));
    let folder = scratch("device");
    let picture = folder.join("a.png").display().to_string();
    let value = json(&["render", "builtin:cornell", "--size", "16x8", "--json", "-", "-o", picture.as_str()]);
    assert_eq!(differences(&documented("render"), &value), NONE);
    std::fs::remove_dir_all(folder).expect("cleaned up");
    let of_device = documented("devices").into_iter().filter_map(|k| k.strip_prefix("devices[]."));
    let of_device: Vec<_> = of_device.filter(|k| !is_in(k, "missing") && !is_in(k, "features")).collect();
    assert_eq!(differences(&of_device, &value["device"]), NONE, "a device without its features");
    assert_eq!(differences(&documented("devices"), &json(&["devices", "--json", "-"])), NONE);
    let bench = ["bench", "ceiling", "--size", "16x8", "--lights", "1", "--quick", "--json", "-"];
    assert_eq!(differences(&documented("bench"), &json(&bench)), NONE);
    // One of many: what all find is looked at by the tests of pictures and hard cases.
    assert_eq!(differences(&documented("check"), &json(&["check", "--only", "radiosity_direct", "--json", "-"])), NONE);
}

#[test]
fn a_key_that_differs_is_found() {
    let value = serde_json::json!({ "a": { "b": 1, "c": [{ "d": 2 }] }, "e": [] });
    assert_eq!(differences(&["a.b", "a.c[].d", "e[].f"], &value), NONE);
    assert_eq!(differences(&["a", "e"], &value), NONE);
    assert_eq!(differences(&["a.b", "a.x", "e"], &value), ["not documented: a.c[].d", "not there: a.x"]);
}

#[test]
fn environment_variables_are_documented() {
    let text = document("README.md");
    let documented = first_column(&text, "## Environment");
    let is_name = |c: char| c.is_ascii_uppercase() || c == '_';
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("tests")).expect("tests").flatten().filter(|e| e.path().is_file()) {
        let source = std::fs::read_to_string(entry.path()).expect("a source file");
        for name in source.split("(\"").skip(1).filter_map(|rest| rest.split('"').next()) {
            if name.strip_prefix("LAMPYRIS_").is_some_and(|rest| !rest.is_empty() && rest.chars().all(is_name)) {
                count += 1;
                assert!(documented.contains(&name), "the README lacks {name}");
            }
        }
    }
    assert!(count >= 2, "only {count} variables were found");
}
