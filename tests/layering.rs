//! scene -> plan -> graph -> record -> submit -> measure, one way only: no `use` points back.

use std::fs;
use std::path::Path;

/// Folder or file under `src/`, and what it must not use.
const RULES: &[(&str, &[&str])] = &[
    (
        "math",
        &[
            "scene",
            "plan",
            "graph",
            "passes",
            "record",
            "submit",
            "measure",
            "reference",
            "gpu",
            "renderer",
            "commands",
            "cli",
        ],
    ),
    (
        "scene",
        &["plan", "graph", "passes", "record", "submit", "measure", "reference", "gpu", "renderer", "commands", "cli"],
    ),
    ("plan", &["graph", "passes", "record", "submit", "measure", "reference", "gpu", "renderer", "commands", "cli"]),
    (
        "graph",
        &["scene", "plan", "passes", "record", "submit", "measure", "reference", "gpu", "renderer", "commands", "cli"],
    ),
    ("passes", &["record", "submit", "measure", "reference", "gpu", "renderer", "commands", "cli"]),
    ("gpu", &["scene", "plan", "passes", "record", "submit", "measure", "reference", "renderer", "commands", "cli"]),
    ("record", &["scene", "plan", "passes", "measure", "reference", "renderer", "commands", "cli"]),
    ("submit", &["scene", "plan", "passes", "graph", "record", "measure", "reference", "renderer", "commands", "cli"]),
    (
        "measure",
        &["scene", "plan", "graph", "passes", "record", "submit", "reference", "gpu", "renderer", "commands", "cli"],
    ),
    ("reference", &["plan", "graph", "passes", "record", "submit", "measure", "gpu", "renderer", "commands", "cli"]),
    ("radiosity", &["plan", "graph", "passes", "record", "submit", "measure", "gpu", "renderer", "commands", "cli"]),
    ("renderer", &["commands", "cli", "checks"]),
    ("lists", &["commands", "cli", "checks"]),
    ("gbuffer", &["commands", "cli", "checks"]),
    ("checks", &["commands", "cli"]),
];

fn rust_files(path: &Path, found: &mut Vec<std::path::PathBuf>) {
    if path.is_file() {
        found.push(path.to_path_buf());
    }
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() || path.extension().is_some_and(|e| e == "rs") {
            rust_files(&path, found);
        }
    }
}

/// Modules of this crate that a source names in paths.
fn uses(source: &str) -> Vec<String> {
    let code = source.lines().filter(|l| !l.trim_start().starts_with("//"));
    assert!(!source.contains("crate::{"), "a grouped use of the crate hides its arrows");
    let mut found = Vec::new();
    for line in code {
        for part in line.split("crate::").skip(1) {
            let name: String = part.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            found.push(name);
        }
    }
    found
}

fn violations(root: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for (stage, forbidden) in RULES {
        let mut files = Vec::new();
        rust_files(&root.join(stage), &mut files);
        rust_files(&root.join(format!("{stage}.rs")), &mut files);
        assert!(!files.is_empty(), "the rule for {stage} names nothing");
        for file in files {
            let source = fs::read_to_string(&file).expect("a source file");
            for used in uses(&source) {
                if forbidden.contains(&used.as_str()) {
                    found.push(format!("{} uses {used}", file.display()));
                }
            }
        }
    }
    found
}

#[test]
fn no_arrow_points_back() {
    let found = violations(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn an_arrow_that_points_back_is_found() {
    assert_eq!(uses("use crate::plan::Plan;\n// crate::gpu\nlet x = crate::measure::read;"), ["plan", "measure"]);
}

#[test]
fn unsafe_stays_in_its_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    for file in files {
        let relative = file.strip_prefix(&root).expect("under src").display().to_string();
        let allowed = ["gpu/", "record.rs", "record/", "submit.rs"].iter().any(|p| relative.starts_with(p));
        let source = fs::read_to_string(&file).expect("a source file");
        let code = || source.lines().filter(|l| !l.trim_start().starts_with("//"));
        let has = code().any(|l| l.contains("unsafe {") || l.contains("unsafe fn") || l.contains("allow(unsafe_code)"));
        assert!(allowed || !has, "{relative} has unsafe code");
        let commands = ["cmd_pipeline_barrier", "cmd_write_timestamp", "cmd_begin_debug_utils_label"];
        let barriers = relative.starts_with("record");
        assert!(
            barriers || !code().any(|l| commands.iter().any(|c| l.contains(c))),
            "{relative} records barriers, labels or timestamps"
        );
    }
}
