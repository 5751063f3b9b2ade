//! Wrong files and wrong places, as a user meets them: the exit status, one sentence, and nothing left behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use lampyris::scene::{builtin, write};
use serde_json::json;

use crate::fuzz::corpus::{Binary, TRIANGLE, glb};

/// A folder for inputs and an empty one for outputs, both removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lampyris-bad-input-{}-{name}", std::process::id()));
        std::fs::create_dir_all(folder.join("out")).expect("a scratch folder");
        Self(folder)
    }

    fn put(&self, file: &str, bytes: &[u8]) -> String {
        let path = self.0.join(file);
        std::fs::write(&path, bytes).expect("a scratch file");
        path.to_str().expect("UTF-8").into()
    }

    fn output(&self, file: &str) -> String {
        self.0.join("out").join(file).to_str().expect("UTF-8").into()
    }

    /// Names in the output folder, hidden ones too.
    fn left(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join("out")).expect("the output folder").flatten();
        entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn lampyris(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lampyris"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// A small picture that needs no driver.
fn traced<'a>(scene: &'a str, output: &'a str) -> [&'a str; 8] {
    ["render", scene, "--technique", "reference", "--size", "64x48", "-o", output]
}

/// Panics unless `output` is a refusal with that status in one line that has all `words`.
fn refused(output: &Output, status: i32, words: &[&str]) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{stderr}");
    assert!(stderr.starts_with("lampyris: ") && stderr.lines().count() == 1, "not one sentence: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{word:?} is not in: {stderr}");
    }
}

/// Renders the file by rays; it must be refused by name and leave nothing.
fn file_refused(scratch: &Scratch, path: &str, words: &[&str]) {
    let output = lampyris(&traced(path, &scratch.output("a.png"))).output().expect("the program starts");
    refused(&output, 1, &[path]);
    refused(&output, 1, words);
    assert_eq!(scratch.left(), [""; 0]);
}

/// Renders the file by rays; it must be drawn with the note.
fn drawn(scratch: &Scratch, path: &str, note: &str) -> image::RgbaImage {
    let picture = scratch.output("a.png");
    let output = lampyris(&traced(path, &picture)).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains(note), "{}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(scratch.left(), ["a.png"]);
    image::open(picture).expect("a picture").into_rgba8()
}

/// A GLB file of one triangle, with indices where given.
fn triangle(positions: &[f32; 9], indices: Option<[u8; 3]>) -> Vec<u8> {
    let mut b = Binary::default();
    let position = b.floats("VEC3", 3, positions);
    let mut primitive = json!({ "attributes": { "POSITION": position } });
    if let Some(indices) = indices {
        primitive["indices"] = json!(b.data(5121, "SCALAR", 3, &indices));
    }
    let document = b.document(json!({ "nodes": [{ "mesh": 0 }], "meshes": [{ "primitives": [primitive] }] }));
    glb(&document, &b.bytes)
}

#[test]
fn buffers_that_are_not_there() {
    let scratch = Scratch::new("buffers");
    let document = json!({ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 36, "uri": "gone.bin" }] });
    let path = scratch.put("gone.gltf", document.to_string().as_bytes());
    file_refused(&scratch, &path, &["buffers[0].uri", "gone.bin"]);
    let whole = write::glb(&builtin::load("cornell").expect("a built-in scene")).expect("a GLB file");
    let path = scratch.put("short.glb", &whole[..whole.len() / 2]);
    let (said, there) = (whole.len().to_string(), (whole.len() / 2).to_string());
    file_refused(&scratch, &path, &["header", &said, &there]);
}

#[test]
fn positions_and_indices_that_are_wrong() {
    let scratch = Scratch::new("meshes");
    let mut positions = TRIANGLE;
    positions[7] = f32::NAN;
    let path = scratch.put("nan.glb", &triangle(&positions, None));
    file_refused(&scratch, &path, &["meshes[0].primitives[0].attributes.POSITION", "accessors[0]", "element 2"]);
    let path = scratch.put("index.glb", &triangle(&TRIANGLE, Some([0, 1, 7])));
    file_refused(&scratch, &path, &["meshes[0].primitives[0].indices", "accessors[1]", "index 2 is 7"]);
}

#[test]
fn scenes_of_nothing_are_drawn() {
    let scratch = Scratch::new("nothing");
    let flat = scratch.put("flat.glb", &triangle(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0], None));
    let empty = scratch.put("empty.gltf", br#"{"asset":{"version":"2.0"}}"#);
    for (path, note) in [(&flat, "1 triangle of zero area"), (&empty, "no camera")] {
        let picture = drawn(&scratch, path, note);
        assert_eq!(picture.dimensions(), (64, 48));
        let background = *picture.get_pixel(0, 0);
        assert!(picture.pixels().all(|p| *p == background), "{path} is not background alone");
    }
    let seen = scratch.put("seen.glb", &triangle(&TRIANGLE, None));
    let picture = drawn(&scratch, &seen, "no camera");
    let background = *picture.get_pixel(0, 0);
    assert!(picture.pixels().any(|p| *p != background), "a triangle that is there is not seen");
}

#[test]
fn files_that_are_no_scene() {
    let scratch = Scratch::new("no-scene");
    let required = r#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_unheard_of"]}"#;
    let path = scratch.put("required.gltf", required.as_bytes());
    file_refused(&scratch, &path, &["extensionsRequired[0]", "EXT_unheard_of", "not supported"]);
    let path = scratch.put("text.gltf", b"no JSON at all\n");
    file_refused(&scratch, &path, &["line 1 column 2", "JSON"]);
    let path = scratch.put("empty.glb", b"");
    file_refused(&scratch, &path, &["empty"]);
    let folder = scratch.0.join("out").to_str().expect("UTF-8").to_string();
    file_refused(&scratch, &folder, &["is not a file"]);
}

#[test]
fn names_from_files_stay_in_the_line() {
    let scratch = Scratch::new("names");
    let text = r#"{"asset":{"version":"2.0"},"extensionsRequired":["one\ntwo\u001b[31mthree"]}"#;
    let path = scratch.put("names.gltf", text.as_bytes());
    let output = lampyris(&["plan", &path, "--limits", "minimum"]).output().expect("the program starts");
    refused(&output, 1, &["one", "two", "three"]);
    assert!(!output.stderr.contains(&0x1B), "an escape sequence reaches the terminal");
}

#[test]
fn pictures_that_are_damaged() {
    let scratch = Scratch::new("pictures");
    for file in ["whole.png", "whole.exr"] {
        let whole = scratch.0.join(file).to_str().expect("UTF-8").to_string();
        assert!(lampyris(&traced("builtin:furnace", &whole)).output().expect("the program starts").status.success());
        let bytes = std::fs::read(&whole).expect("a picture");
        let damaged = scratch.put(&format!("half-{file}"), &bytes[..bytes.len() / 2]);
        let output = lampyris(&["diff", &whole, &damaged]).output().expect("the program starts");
        refused(&output, 1, &[&damaged, "damaged"]);
    }
    let other = scratch.put("other.png", b"not a picture");
    refused(&lampyris(&["diff", &other, &other]).output().expect("the program starts"), 1, &["other.png"]);
    let picture = scratch.output("a.png");
    let again: [&str; 5] = ["render", "--from", &other, "-o", &picture];
    refused(&lampyris(&again).output().expect("the program starts"), 1, &["other.png", "how it was made"]);
    assert_eq!(scratch.left(), [""; 0]);
}

#[test]
fn command_lines_that_are_wrong_get_one_line() {
    for (arguments, words) in [
        (vec!["render", "--size", "0x0"], "at least one pixel"),
        (vec!["render", "--sise", "8x8"], "--sise"),
        (vec!["render", "--look-from", "0,0,0"], "--look-at"),
        (vec!["render", "--tonemap", "sepia"], "neutral"),
        (vec!["paint"], "paint"),
        (vec!["plan", "builtin:nowhere", "--limits", "minimum"], "nowhere"),
    ] {
        let output = lampyris(&arguments).output().expect("the program starts");
        refused(&output, 2, &[words]);
        assert!(output.stdout.is_empty());
    }
    let huge = lampyris(&["plan", "--limits", "minimum", "--size", "100000x100000"]).output();
    refused(&huge.expect("the program starts"), 1, &["100000x100000"]);
}

#[test]
fn outputs_that_cannot_be_written() {
    let scratch = Scratch::new("outputs");
    let (folder, file) = (scratch.output("folder.png"), scratch.output("file"));
    std::fs::create_dir(&folder).expect("a folder");
    std::fs::write(&file, b"kept").expect("a file");
    let (picture, scene, report) = (format!("{file}/a.png"), format!("{file}/a.glb"), format!("{file}/a.json"));
    let calls: [(&[&str], &str); 4] = [
        (&traced("builtin:furnace", &folder), &folder),
        (&traced("builtin:furnace", &picture), &picture),
        (&["scene", "furnace", "-o", &scene], &scene),
        (&["plan", "builtin:furnace", "--limits", "minimum", "--json", &report], &report),
    ];
    for (arguments, named) in calls {
        let output = lampyris(arguments).output().expect("the program starts");
        refused(&output, 1, &[named, "could not be written"]);
    }
    let mut left = scratch.left();
    left.sort();
    assert_eq!(left, ["file", "folder.png"]);
    assert_eq!(std::fs::read(&file).expect("the file"), b"kept");
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_file() {
    let scratch = Scratch::new("full");
    let [picture, linear, scene, report] = ["a.png", "a.exr", "a.glb", "a.json"].map(|f| scratch.output(f));
    let calls: [(&[&str], &str); 4] = [
        (&traced("builtin:cornell", &picture), &picture),
        (&traced("builtin:cornell", &linear), &linear),
        (&["scene", "corridor", "-o", &scene], &scene),
        (&["plan", "--limits", "minimum", "--json", &report], &report),
    ];
    for (arguments, named) in calls {
        // No file may grow past one block of 512 or 1024 bytes; the signal that would end the program is ignored, so that
        // writing fails as it does on a full disk.
        let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
        let mut command = Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_lampyris")]).args(arguments);
        refused(&command.output().expect("a shell"), 1, &[named, "could not be written"]);
        assert_eq!(scratch.left(), [""; 0]);
    }
}

#[cfg(unix)]
#[test]
fn file_names_need_not_be_unicode() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let scratch = Scratch::new("unicode");
    let path = scratch.0.join("out").join(OsStr::from_bytes(b"a\xFF.png"));
    let arguments = ["render", "builtin:furnace", "--technique", "reference", "--size", "8x6", "--json", "-", "-o"];
    let output = lampyris(&arguments).arg(&path).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(path.is_file());
    assert_eq!(scratch.left().len(), 1);
}

/// With `manifest` as the only driver.
fn with_driver(arguments: &[&str], manifest: &Path) -> Output {
    let mut command = lampyris(arguments);
    command.env("VK_DRIVER_FILES", manifest).env("VK_ICD_FILENAMES", manifest).env_remove("VK_ADD_DRIVER_FILES");
    command.output().expect("the program starts")
}

#[test]
fn no_driver_is_said_by_every_command_that_needs_one() {
    let scratch = Scratch::new("no-driver");
    let nowhere = Path::new("/nonexistent/driver.json");
    let picture = scratch.output("a.png");
    let calls: [&[&str]; 5] = [
        &["devices"],
        &["check"],
        &["bench", "ceiling", "--quick"],
        &["plan", "builtin:furnace"],
        &["render", "builtin:furnace", "-o", &picture],
    ];
    for arguments in calls {
        refused(&with_driver(arguments, nowhere), 1, &["no Vulkan driver was found"]);
    }
    assert_eq!(scratch.left(), [""; 0]);
}

#[test]
fn a_driver_below_the_baseline_is_told_what_it_lacks() {
    let mock = Path::new(env!("CARGO_MANIFEST_DIR")).join("third-party/vulkan/mock_icd.json");
    if !mock.is_file() {
        let is_required = std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1");
        assert!(!is_required, "LAMPYRIS_REQUIRE_GPU=1, but there is no {}", mock.display());
        eprintln!("SKIPPED, no mock driver: ./setup.sh brings {}", mock.display());
        return;
    }
    let scratch = Scratch::new("below");
    let listed = with_driver(&["devices"], &mock);
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
    assert!(String::from_utf8_lossy(&listed.stdout).contains("baseline: NOT met, it lacks"));
    let picture = scratch.output("a.png");
    let calls: [&[&str]; 3] =
        [&["render", "builtin:furnace", "-o", &picture], &["plan", "builtin:furnace"], &["check"]];
    for arguments in calls {
        let lacking = ["below the baseline", "dynamicRendering", "timelineSemaphore", "scalarBlockLayout"];
        refused(&with_driver(arguments, &mock), 1, &lacking);
    }
    assert_eq!(scratch.left(), [""; 0]);
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let calls: [&[&str]; 4] = [
        &["plan", "--limits", "minimum"],
        &["plan", "--limits", "minimum", "--barriers"],
        &["plan", "--limits", "minimum", "--json", "-"],
        &["scene"],
    ];
    for arguments in calls {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let child = lampyris(arguments).stdout(writer).stderr(Stdio::piped()).spawn().expect("the program starts");
        let output = child.wait_with_output().expect("the program ends");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && stderr.is_empty(), "{arguments:?}: {}: {stderr}", output.status);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_leaves_no_file() {
    let scratch = Scratch::new("interrupt");
    let picture = scratch.output("a.png");
    // Shells start background jobs with the signal ignored, and that is inherited; `env` undoes it and becomes the program.
    let mut command = Command::new("env");
    command.args(["--default-signal=INT", env!("CARGO_BIN_EXE_lampyris"), "render", "builtin:atrium", "-o", &picture]);
    // So many lights take minutes.
    command.args(["--technique", "reference", "--lights", "1000000", "--light-range", "inf"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(child.try_wait().expect("a status").is_none(), "it ended before it could be interrupted");
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("a signal");
    assert!(sent.success());
    let status = child.wait().expect("a status");
    assert!(!status.success(), "{status}");
    assert_eq!(scratch.left(), [""; 0]);
}
