//! `bake` as a user calls it: equal bytes however it is computed, rows that are kept, and folders that are refused.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command_line::{lampyris, refused};
use crate::documents::{differences, document, first_column, lines};

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lampyris-bakes-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    folder
}

/// Every file of a folder.
fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    let read = |entry: std::fs::DirEntry| {
        (entry.file_name().into_string().expect("UTF-8"), std::fs::read(entry.path()).expect("a file"))
    };
    entries.map(read).collect()
}

fn bake(folder: &Path, more: &[&str]) -> String {
    let place = folder.to_str().expect("a plain path");
    let output = lampyris(&[&["bake", "builtin:cornell", "--patches", "60", "-o", place], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn shards_and_interrupted_bakes_come_to_the_same_bytes() {
    let folder = scratch("equal");
    let [whole, again, shards] = ["whole", "again", "shards"].map(|name| folder.join(name));
    let said = bake(&whole, &[]);
    assert!(said.contains("patches   ") && said.contains("bytes an element"), "{said}");
    let right = bytes(&whole);
    assert!(right.contains_key("manifest.json") && right.contains_key("blocks.npy"), "{:?}", right.keys());
    // Half the rows are there when it is called again.
    bake(&again, &["--shard", "1/2"]);
    assert!(!again.exists() && folder.join("again.rows").is_dir());
    bake(&again, &[]);
    assert!(!folder.join("again.rows").exists(), "rows are left");
    assert!(bytes(&again) == right);
    // A bake in the place of another.
    bake(&again, &["--bake-on", "cpu"]);
    assert!(bytes(&again) == right);
    // And by a device, under validation where there has to be one.
    if std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1") {
        let said = bake(&again, &["--bake-on", "device", "--validate"]);
        assert!(said.contains("decided by the CPU"), "{said}");
        assert!(bytes(&again) == right);
    } else {
        eprintln!("SKIPPED, a bake by a device");
    }
    let place = shards.display().to_string();
    let merge = ["bake", "builtin:cornell", "--patches", "60", "-o", &place, "--merge"];
    bake(&shards, &["--shard", "3/3"]);
    bake(&shards, &["--shard", "1/3"]);
    refused(&merge, 1, "are not there");
    // Rows of another bake are no help.
    refused(&["bake", "builtin:cornell", "--patches", "60", "--seed", "2", "-o", &place], 1, "is of the bake");
    bake(&shards, &["--shard", "2/3"]);
    bake(&shards, &["--merge"]);
    assert!(bytes(&shards) == right);
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn rows_that_are_damaged_are_refused() {
    let folder = scratch("damaged");
    let place = folder.join("a");
    bake(&place, &["--shard", "1/2"]);
    let rows = folder.join("a.rows");
    let (name, mut content) = bytes(&rows).into_iter().next().expect("a file of rows");
    *content.last_mut().expect("a byte") ^= 1;
    std::fs::write(rows.join(&name), content).expect("written");
    let place = place.display().to_string();
    refused(&["bake", "builtin:cornell", "--patches", "60", "-o", &place], 1, &format!("{name}: is damaged"));
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn a_wrong_bake_is_a_sentence() {
    let folder = scratch("wrong");
    let (place, other) = (folder.join("a"), folder.join("b"));
    bake(&place, &[]);
    let gi = format!("radiosity:{}", place.display());
    let picture = folder.join("p.png").display().to_string();
    let render =
        |scene: &'static str| ["render", scene, "--size", "16x8", "-o", &picture, "--gi", &gi].map(String::from);
    let words = |typed: &[String]| typed.iter().map(String::clone).collect::<Vec<_>>();
    let call = |typed: &[String], status, said: &str| {
        let typed = words(typed);
        refused(&typed.iter().map(String::as_str).collect::<Vec<_>>(), status, said);
    };
    // R19: of another scene, with both fingerprints; truncated; no bake.
    call(&render("builtin:furnace"), 1, "manifest.json: scene");
    let manifest = std::fs::read(place.join("manifest.json")).expect("a manifest");
    let blocks = std::fs::read(place.join("blocks.npy")).expect("blocks");
    std::fs::write(place.join("blocks.npy"), &blocks[..blocks.len() - 8]).expect("written");
    call(&render("builtin:cornell"), 1, "blocks.npy");
    std::fs::write(place.join("blocks.npy"), &blocks).expect("written");
    std::fs::write(place.join("manifest.json"), &manifest[..manifest.len() / 2]).expect("written");
    call(&render("builtin:cornell"), 1, "manifest.json");
    std::fs::create_dir_all(&other).expect("a folder");
    std::fs::write(other.join("mine.txt"), "not a bake").expect("written");
    let name = other.display().to_string();
    refused(&["bake", "builtin:cornell", "-o", &name], 1, "no bake that could be replaced");
    refused(&["bake", "builtin:cornell", "-o", &name, "--shard", "3/2"], 2, "I from 1 to N");
    refused(&["bake", "builtin:cornell", "-o", &name, "--patch-size", "0"], 2, "positive number of metres");
    refused(&["bake", "builtin:cornell", "-o", &name, "--patches", "5", "--patch-size", "1"], 2, "cannot be used");
    refused(
        &["bake", "builtin:cornell", "-o", &name, "--bake-on", "cpu", "--driver", "x"],
        2,
        "--driver and --validate",
    );
    let fresh = folder.join("fresh").display().to_string();
    refused(&["bake", "builtin:cornell", "-o", &fresh, "--patches", "9", "--driver", "nosuch"], 1, "nosuch");
    // R11: columns are counted in 16 bits.
    refused(&["bake", "builtin:cornell", "-o", &name, "--patches", "70000"], 2, "70000");
    refused(&["bake", "builtin:cornell", "-o", &fresh, "--patch-size", "0.05"], 1, "at most 32768");
    assert_eq!(std::fs::read(other.join("mine.txt")).expect("still there"), b"not a bake");
    assert!(!Path::new(&picture).exists());
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn json_of_bake_is_documented() {
    let folder = scratch("json");
    let said = bake(&folder.join("a"), &["--json", "-"]);
    let value: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(differences(&first_column(&document("README.md"), "### JSON of `bake`"), &value), [""; 0]);
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

/// The line of the document that spreads a bake over processes, on a small bake.
#[test]
fn shards_by_gnu_parallel_run_as_documented() {
    let required = std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1");
    let there = Command::new("parallel").arg("--version").output().is_ok_and(|output| output.status.success());
    if !there && !required {
        eprintln!("SKIPPED, no GNU parallel");
        return;
    }
    let text = document("docs/RADIOSITY.md");
    let line = lines(&text).into_iter().find(|(kind, line)| *kind == Some("sh") && line.starts_with("parallel "));
    let line = line.expect("a line that calls parallel").1;
    let folder = scratch("parallel");
    bake(&folder.join("whole"), &[]);
    let place = folder.join("spread");
    let typed = line
        .replace("builtin:atrium", "builtin:cornell")
        .replace("--patches 4000", "--patches 60")
        .replace("atrium.bake", &place.display().to_string())
        .replace("lampyris ", &format!("{} ", env!("CARGO_BIN_EXE_lampyris")));
    let output = Command::new("sh").args(["-c", &typed]).output().expect("a shell");
    assert!(output.status.success(), "{typed}: {}", String::from_utf8_lossy(&output.stderr));
    bake(&place, &["--merge"]);
    assert!(bytes(&place) == bytes(&folder.join("whole")));
    std::fs::remove_dir_all(folder).expect("cleaned up");
}
