//! The program as a user calls it: exit status, sentences, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use clap::ValueEnum;
use lampyris::cli::{BenchName, DebugViewArg};
use lampyris::measure::{file, read};
use lampyris::plan::DebugView;
use lampyris::scene::write;

use crate::documents::{differences, document, first_column};
use crate::support::lights_beside_the_eye;

pub fn lampyris(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lampyris")).args(arguments).output().expect("the program starts")
}

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lampyris-test-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    folder
}

pub fn refused(arguments: &[&str], status: i32, words: &str) {
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
    refused(&["render", "--technique", "reference", "--counters"], 2, "uses none");
    refused(&["render", "--fov", "0", "--look-from", "0,0,0", "--look-at", "0,0,1"], 2, "between 0 and 180");
    refused(&["render", "--fov", "50"], 2, "--look-from");
    refused(&["plan", "--limits", "minimum", "--gi", "path"], 2, "--technique reference");
    refused(&["plan", "--limits", "minimum", "--spp", "4"], 2, "options of --gi path");
    refused(&["render", "--gi", "path", "--spp", "0"], 2, "0 is not in 1..=1000000");
    refused(&["diff", "a.exr", "b.exr", "-o", "heat.exr"], 2, ".png");
    refused(&["bench", "lights", "--lights", "0"], 2, "0 is not in 1..=16777216");
    refused(&["bench", "lights", "--path", "way.json"], 2, "this experiment has none");
    refused(&["check", "--only", "no_such"], 2, "--only no_such: no check has that in its name: layout, ");
    refused(&["plan", "--limits", "minimum", "--light-range", "2", "--light-cutoff", "1"], 2, "give one");
    refused(&["plan", "--limits", "minimum", "--ambient=-1,0,0"], 2, "non-negative");
}

#[test]
fn bounced_light_is_traced_apart_and_added() {
    let folder = scratch("gi");
    let picture = folder.join("a.exr").display().to_string();
    let traced =
        ["render", "builtin:cornell", "--technique", "reference", "--size", "24x16", "--gi", "path", "--spp", "8"];
    let output = lampyris(&[&traced[..], &["--layers", "--json", "-", "-o", &picture]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&value["gi"]["mode"], &value["gi"]["spp"], &value["gi"]["seed"]),
        (&"path".into(), &8.into(), &1.into())
    );
    assert!(value["gi"]["standard_error"].as_f64().is_some_and(|error| error > 0.0));
    let image = exr::prelude::read_first_flat_layer_from_file(&picture).expect("a picture");
    let of = |name: &str| -> Vec<f32> {
        let channel = image.layer_data.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
        channel.expect(name).sample_data.values_as_f32().collect()
    };
    let mut bounced = 0.0;
    for channel in ["R", "G", "B"] {
        let [whole, direct, indirect] = ["", "direct.", "indirect."].map(|layer| of(&format!("{layer}{channel}")));
        for ((w, d), i) in whole.iter().zip(&direct).zip(&indirect) {
            assert!((w - d - i).abs() <= 1e-5 * w.abs(), "{w} is not {d} and {i}");
            bounced += i;
        }
    }
    assert!(bounced > 0.0);
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn work_that_fails_is_status_1() {
    refused(&["render", "/nonexistent/scene.glb", "-o", "/tmp/x.png"], 1, "/nonexistent/scene.glb");
    refused(&["bench", "path", "--path", "/nonexistent/way.json"], 1, "/nonexistent/way.json: could not be read");
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

#[test]
fn views_of_what_a_plan_does_not_make_are_refused() {
    let refused = |options: &[&str], words: &str| {
        let plan = ["plan", "builtin:cornell", "--size", "64x64", "--limits", "minimum"];
        refused(&[&plan[..], options].concat(), 2, words);
    };
    for view in ["tile-min", "tile-max", "tile-lights", "tile-mask", "missed", "waste"] {
        refused(&["--technique", "forward", "--debug-view", view], "shows light lists, and forward makes none");
    }
    let tiled = ["--technique", "tiled-forward", "--debug-view"];
    for view in ["clusters", "cluster-lights", "slices"] {
        refused(&[&tiled[..], &[view]].concat(), "shows clusters, and tiled-forward makes none");
    }
    for view in ["gbuffer-albedo", "gbuffer-normal", "gbuffer-material", "gbuffer-emission"] {
        refused(&[&tiled[..], &[view]].concat(), "shows a G-buffer, and tiled-forward makes none");
    }
    for (view, options, words) in [
        ("tile-min", &["--prepass", "off"], "leave out"),
        ("tile-max", &["--depth-bounds", "off"], "leave out"),
        ("tile-mask", &["--depth-bounds", "minmax"], "minmax here"),
    ] {
        refused(&[&tiled[..], &[view], options].concat(), words);
    }
    for view in ["quads", "lights"] {
        let planned = lampyris(&["plan", "builtin:cornell", "--limits", "minimum", "--debug-view", view]);
        assert!(planned.status.success(), "{view}: {}", String::from_utf8_lossy(&planned.stderr));
    }
}

#[test]
fn the_table_of_debug_views_is_the_program() {
    let text = document("README.md");
    let planned: Vec<&str> = DebugView::ALL.iter().map(|view| view.0).collect();
    assert_eq!(first_column(&text, "### Seeing light lists")[1..], planned[..]);
    let typed = DebugViewArg::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let typed: Vec<String> = typed.map(|value| value.get_name().to_string()).collect();
    assert_eq!(typed, planned);
}

/// A folder with the scene `beside.glb`, or `None` where nothing can be drawn and need not be.
pub fn drawn_folder(name: &str) -> Option<PathBuf> {
    let planned = lampyris(&["plan", "builtin:furnace", "--size", "8x8"]);
    let required = std::env::var_os("LAMPYRIS_REQUIRE_GPU").is_some_and(|v| v == "1");
    if !planned.status.success() && !required {
        eprintln!("SKIPPED, no device: {}", String::from_utf8_lossy(&planned.stderr));
        return None;
    }
    let folder = scratch(name);
    let bytes = write::glb(&lights_beside_the_eye()).expect("a file");
    std::fs::write(folder.join("beside.glb"), bytes).expect("written");
    Some(folder)
}

/// Renders `beside.glb` from its middle at 96x96 to `view.png` or `view.exr`; what was printed.
fn draw_beside(folder: &Path, file: &str, options: &[&str]) -> String {
    draw_by("tiled-forward", folder, file, options)
}

fn draw_by(technique: &str, folder: &Path, file: &str, options: &[&str]) -> String {
    let text = |name: &str| folder.join(name).display().to_string();
    let (scene, picture) = (text("beside.glb"), text(file));
    let common = ["render", &scene, "--technique", technique, "--size", "96x96", "--frames", "1", "-o", &picture];
    let camera = ["--look-from", "0,0,0", "--look-at", "0,0,-1", "--fov", "90"];
    let output = lampyris(&[&common[..], &camera, options].concat());
    assert!(output.status.success(), "{options:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn rgba8(folder: &Path) -> image::RgbaImage {
    image::open(folder.join("view.png")).expect("a PNG").to_rgba8()
}

#[test]
fn missed_lights_are_green() {
    let Some(folder) = drawn_folder("missed") else { return };
    let green = |cull: &str| {
        draw_beside(&folder, "view.png", &["--cull", cull, "--debug-view", "missed"]);
        let picture = rgba8(&folder);
        assert!(picture.width() == 96 && picture.height() > 96 + 20, "a legend stands below the picture");
        // The legend has a green square of its own.
        picture.enumerate_pixels().filter(|(_, y, pixel)| *y < 96 && pixel.0 == [0, 255, 0, 255]).count()
    };
    assert!(green("bounds-textbook") > 500);
    assert_eq!(green("bounds"), 0);
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn every_view_is_drawn_with_a_legend() {
    let Some(folder) = drawn_folder("views") else { return };
    for (name, view) in DebugView::ALL {
        let deferred = if view.of_gbuffer() { "tiled-deferred" } else { "tiled-forward" };
        let technique = if view.of_clusters() { "clustered-forward" } else { deferred };
        let said = draw_by(technique, &folder, "view.png", &["--debug-view", name]);
        assert!(said.contains("\nlegend    "), "{name}: {said}");
        let picture = rgba8(&folder);
        assert_eq!(picture.width(), 96, "{name}");
        let dark = |pixel: &image::Rgba<u8>| pixel.0[..3].iter().all(|c| *c < 128);
        let words = picture.enumerate_pixels().filter(|(_, y, pixel)| *y >= 96 && dark(pixel)).count();
        assert!(words > 50, "{name}: {words} dark pixels in the legend");
    }
    draw_beside(&folder, "view.exr", &["--debug-view", "waste"]);
    let exr = read::load(&folder.join("view.exr")).expect("an EXR");
    assert_eq!((exr.width, exr.height), (96, 96), "an EXR has no legend");
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn clusters_are_as_many_colours() {
    let Some(folder) = drawn_folder("clusters") else { return };
    for prepass in ["on", "off"] {
        let said =
            draw_by("clustered-forward", &folder, "view.png", &["--debug-view", "clusters", "--prepass", prepass]);
        let count = said.lines().find_map(|line| line.strip_prefix("legend    ")?.strip_suffix(" in the picture"));
        let count: usize = count.and_then(|text| text.rsplit(' ').next()?.parse().ok()).expect("a number of clusters");
        let picture = rgba8(&folder);
        let drawn = picture.enumerate_pixels().filter(|pixel| pixel.1 < 96).map(|pixel| pixel.2.0);
        let colors = drawn.collect::<std::collections::BTreeSet<_>>().len();
        // 36 tiles; few colours stand for two clusters.
        assert!(count >= 36 && colors <= count && 10 * colors > 8 * count, "{prepass}: {colors} of {count}");
    }
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn counters_are_there_when_asked_for() {
    let Some(folder) = drawn_folder("counters") else { return };
    let counters = |options: &[&str]| {
        let said = draw_beside(&folder, "view.png", &[&["--json", "-"][..], options].concat());
        serde_json::from_str::<serde_json::Value>(&said).expect("JSON")["counters"].clone()
    };
    let counted = counters(&["--counters"]);
    assert!(counted["missed_pairs"] == 0 && counted["lists_overflowed"] == 0, "{counted}");
    for key in ["light_pairs", "exact_pairs", "light_evaluations", "longest_list"] {
        assert!(counted[key].as_u64().is_some_and(|n| n > 0), "{key}: {counted}");
    }
    for key in ["waste_cells", "waste_samples"] {
        assert!(counted[key].as_f64().is_some_and(|x| x >= 1.0), "{key}: {counted}");
    }
    let textbook = counters(&["--counters", "--cull", "bounds-textbook"]);
    assert!(textbook["missed_pairs"].as_u64().is_some_and(|n| n > 1000), "{textbook}");
    let not_asked = counters(&[]);
    assert!(not_asked["missed_pairs"].is_null() && not_asked["lists_overflowed"].is_null(), "{not_asked}");
    let said = draw_beside(&folder, "view.png", &["--counters"]);
    assert!(said.contains("\nlists     ") && said.contains(" 0 missed; waste "), "{said}");
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn grids_lists_and_the_gbuffer_are_printed_and_documented() {
    let text = document("README.md");
    let documented: Vec<_> =
        first_column(&text, "### JSON of `render`").into_iter().filter(|key| key.starts_with("plan.")).collect();
    for (technique, titles) in [
        ("forward", &[][..]),
        ("tiled-deferred", &["tiles", "bins", "lists", "gbuffer"][..]),
        ("clustered-forward", &["tiles", "bins", "slices", "clusters", "lists"][..]),
    ] {
        let plan = ["plan", "builtin:cornell", "--size", "96x64", "--limits", "minimum", "--technique", technique];
        let said = String::from_utf8(lampyris(&plan).stdout).expect("UTF-8");
        for title in ["tiles", "bins", "slices", "clusters", "lists", "gbuffer"] {
            let there = said.lines().any(|line| line.starts_with(&format!("{title:<10}")));
            assert_eq!(there, titles.contains(&title), "{technique}: {title}: {said}");
        }
        assert!(said.contains("\nwhy       asked for\n"), "{said}");
        let value: serde_json::Value =
            serde_json::from_slice(&lampyris(&[&plan[..], &["--json", "-"]].concat()).stdout).expect("JSON");
        assert_eq!(differences(&documented, &serde_json::json!({ "plan": value["plan"] })), [""; 0], "{technique}");
    }
}

#[test]
fn the_table_of_experiments_is_the_program() {
    let typed = BenchName::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let typed: Vec<String> = typed.map(|value| value.get_name().to_string()).collect();
    assert_eq!(first_column(&document("README.md"), "### Experiments"), typed);
}

#[test]
fn bad_camera_paths_are_one_sentence() {
    let folder = scratch("paths");
    let file = folder.join("way.json");
    let name = file.display().to_string();
    let key =
        |time: f64, x: &str| format!("{{\"time\": {time}, \"from\": [{x}, 0, 0], \"at\": [0, 0, -5], \"fov\": 60}}");
    let way = |keys: &[String]| format!("{{\"frames_per_second\": 10, \"keys\": [{}]}}", keys.join(", "));
    for (text, words) in [
        (String::new(), "is not JSON"),
        (way(&[key(0.0, "0")]), "keys has 1 of at least 2 elements"),
        (way(&[key(1.0, "0"), key(0.5, "0")]), "keys[1].time is 0.5, not after the 1"),
        (way(&[key(0.0, "0"), key(1.0, "\"far\"")]), "keys[1].from[0] is not a number"),
    ] {
        std::fs::write(&file, text).expect("written");
        refused(&["bench", "path", "--path", &name], 1, &format!("lampyris: {name}: {words}"));
    }
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

/// Fields of the machine form's rows that are not documented, and documented ones that no row has.
fn undocumented_fields(documented: &[&str], rows: &[&serde_json::Value]) -> Vec<String> {
    let field = |key: &str| key.trim_start_matches("rows[].").split(['.', '[']).next().unwrap_or_default().to_string();
    let documented: std::collections::BTreeSet<String> = documented.iter().map(|key| field(key)).collect();
    let rows = rows.iter().filter_map(|row| row.as_object());
    let there: std::collections::BTreeSet<String> = rows.flat_map(|row| row.keys().cloned()).collect();
    documented.symmetric_difference(&there).cloned().collect()
}

#[test]
fn every_experiment_gives_tables_rows_figures_and_a_page() {
    let Some(folder) = drawn_folder("bench") else { return };
    let place = |name: &str| folder.join(name).display().to_string();
    let (json, plots, report, way) = (place("all.json"), place("plots"), place("report"), place("way.json"));
    let keys = "{\"time\": 0, \"from\": [0, 2, 0], \"at\": [5, 2, 0], \"fov\": 60},
        {\"time\": 1, \"from\": [1, 2, 0], \"at\": [5, 2, 0], \"fov\": 50}";
    std::fs::write(&way, format!("{{\"frames_per_second\": 5, \"keys\": [{keys}]}}")).expect("written");
    let tiny = ["bench", "all", "--quick", "--size", "64x36", "--lights", "8", "--frames", "1", "--path", &way];
    let output = lampyris(&[&tiny[..], &["--json", &json, "--plot", &plots, "--report", &report]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    let value: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&json).expect("a file")).expect("JSON");
    let page = std::fs::read_to_string(folder.join("report/index.html")).expect("a page");
    for outside in ["src=", "href=\"http", "url(", "@import", "<script", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let experiments = value["experiments"].as_array().expect("a list");
    let names = BenchName::value_variants().iter().filter_map(ValueEnum::to_possible_value).skip(1);
    for (experiment, name) in experiments.iter().zip(names) {
        let name = name.get_name();
        assert_eq!(experiment["experiment"], name);
        assert!(experiment["rows"].as_array().is_some_and(|rows| rows.len() > 1), "{name}: {experiment}");
        assert!(said.contains(&format!("\n{name}: ")) && page.contains(&format!("<h2>{name}: ")), "{name}: {said}");
        let svg = std::fs::read_to_string(folder.join(format!("plots/{name}.svg"))).expect("an SVG");
        assert!(svg.starts_with("<svg ") && page.contains(&svg), "{name}");
        let png = std::fs::read(folder.join(format!("plots/{name}.png"))).expect("a PNG");
        assert!(image::load_from_memory(&png).is_ok(), "{name}");
        assert!(file::png_text(&png).iter().any(|note| note.0 == "lampyris arguments"), "{name}");
    }
    assert_eq!(experiments.len(), BenchName::value_variants().len() - 2, "all but `all` and `profile`");
    let rows: Vec<&serde_json::Value> = experiments[1..].iter().flat_map(|e| e["rows"].as_array()).flatten().collect();
    let text = document("README.md");
    assert_eq!(undocumented_fields(&first_column(&text, "### Rows of the other experiments"), &rows), [""; 0]);
    assert_eq!(undocumented_fields(&["rows[].a.b", "rows[].c"], &[&serde_json::json!({ "a": 1, "d": 2 })]), ["c", "d"]);
    for row in &rows {
        // Not every driver has what the others need.
        let must = row["case"] == "forward" || row["technique"] == "tiled-forward";
        let measured = row["outcome"] == "measured" && row["ms"]["median"].as_f64() > Some(0.0);
        assert!(measured || (!must && row["outcome"] == "refused" && row["why"].is_string()), "{row}");
    }
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn what_cannot_be_drawn_is_a_sentence_and_no_file() {
    let Some(folder) = drawn_folder("bench-refused") else { return };
    let json = folder.join("a.json").display().to_string();
    refused(
        &["bench", "views", "--size", "100000x100000", "--lights", "4", "--json", &json],
        1,
        "100000x100000 passes this device's largest image",
    );
    refused(
        &["bench", "lights", "--lights", "4", "--light-range=-1"],
        2,
        "--light-range -1 is not a positive distance",
    );
    assert!(!folder.join("a.json").exists());
    std::fs::remove_dir_all(folder).expect("cleaned up");
}
