//! The program as a user calls it: exit status, sentences, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn lampyris(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lampyris")).args(arguments).output().expect("the program starts")
}

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lampyris-test-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    folder
}

fn refused(arguments: &[&str], status: i32, words: &str) {
    let output = lampyris(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
    assert!(stderr.contains(words), "{arguments:?}: {stderr}");
}

#[test]
fn a_wrong_command_line_is_status_2() {
    refused(&["render", "--size", "0x0"], 2, "at least one pixel");
    refused(&["render", "--size", "huge"], 2, "WxH");
    refused(&["render", "--no-such-flag"], 2, "--no-such-flag");
    refused(&["render", "-o", "x.jpg"], 2, ".png or .exr");
    refused(&["render", "builtin:nowhere"], 2, "nowhere");
    refused(&["render", "-o", "a.png", "--json", "a.png"], 2, "one file");
    refused(&["render", "--layers", "-o", "a.png"], 2, "a PNG has none");
    refused(&["diff", "a.exr", "b.exr", "--max", "nan"], 2, "NaN");
    refused(&["render", "--technique", "reference", "--validate"], 2, "uses none");
    refused(&["render", "--fov", "0", "--look-from", "0,0,0", "--look-at", "0,0,1"], 2, "between 0 and 180");
    refused(&["render", "--fov", "50"], 2, "--look-from");
    refused(&["diff", "a.exr", "b.exr", "-o", "heat.exr"], 2, ".png");
    refused(&["plan", "--limits", "minimum", "--light-range", "2", "--light-cutoff", "1"], 2, "give one");
    refused(&["plan", "--limits", "minimum", "--ambient=-1,0,0"], 2, "non-negative");
}

#[test]
fn work_that_fails_is_status_1() {
    refused(&["render", "/nonexistent/scene.glb", "-o", "/tmp/x.png"], 1, "/nonexistent/scene.glb");
    refused(&["render", "builtin:furnace", "-o", "/nonexistent/x.png"], 1, "not a folder");
    refused(&["plan", "--limits", "minimum", "--size", "100000x100000"], 1, "100000x100000");
}

#[test]
fn plans_need_no_driver() {
    let output = Command::new(env!("CARGO_BIN_EXE_lampyris"))
        .args(["plan", "builtin:cornell", "--limits", "minimum", "--json", "-"])
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(value["schema"], 1);
    assert_eq!(value["plan"]["technique"], "forward");
    assert!(value["barriers"].as_array().is_some_and(|b| !b.is_empty()));
}

#[test]
fn no_driver_is_one_sentence() {
    let output = Command::new(env!("CARGO_BIN_EXE_lampyris"))
        .args(["devices"])
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no Vulkan driver was found"));
}

#[test]
fn reference_pictures_repeat_bit_for_bit_from_their_file() {
    let folder = scratch("from");
    let (first, second) = (folder.join("a.exr"), folder.join("b.exr"));
    let text = |p: &Path| p.to_str().expect("UTF-8").to_string();
    let made =
        lampyris(&["render", "builtin:cornell", "--technique", "reference", "--size", "24x16", "-o", &text(&first)]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let repeated = lampyris(&["render", "--from", &text(&first), "-o", &text(&second)]);
    assert!(repeated.status.success(), "{}", String::from_utf8_lossy(&repeated.stderr));
    assert!(lampyris(&["diff", &text(&first), &text(&second), "--max", "0"]).status.success());
    let left: Vec<_> = std::fs::read_dir(&folder).expect("the folder").flatten().map(|e| e.file_name()).collect();
    assert_eq!(left.len(), 2, "nothing else is left behind: {left:?}");
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn scenes_are_written_and_read_back() {
    let folder = scratch("scene");
    let file = folder.join("corridor.glb");
    let path = file.to_str().expect("UTF-8");
    assert!(lampyris(&["scene", "corridor", "-o", path]).status.success());
    let planned = lampyris(&["plan", path, "--limits", "minimum", "--json", "-"]);
    let value: serde_json::Value = serde_json::from_slice(&planned.stdout).expect("JSON");
    let own = lampyris(&["plan", "builtin:corridor", "--limits", "minimum", "--json", "-"]);
    let own: serde_json::Value = serde_json::from_slice(&own.stdout).expect("JSON");
    for key in ["triangles", "instances", "materials", "lights"] {
        assert_eq!(value["scene"][key], own["scene"][key], "{key}");
    }
    std::fs::remove_dir_all(folder).expect("cleaned up");
}
