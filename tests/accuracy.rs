//! `accuracy` as a user calls it: every knob drawn tiny, its rows, figures and page, and what the documents say of it.

use std::path::Path;

use clap::ValueEnum;
use lampyris::cli::KnobName;
use serde_json::Value;

use crate::command_line::{drawn_folder, lampyris, refused};
use crate::documents::{differences, document, first_column};

fn knobs() -> Vec<String> {
    let typed = KnobName::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    typed.map(|value| value.get_name().to_string()).collect()
}

#[test]
fn the_table_of_knobs_is_the_program() {
    assert_eq!(first_column(&document("README.md"), "### What accuracy costs"), knobs());
}

#[test]
fn wrong_options_are_one_sentence() {
    refused(&["accuracy", "--knob", "volume"], 2, "volume");
    refused(&["accuracy", "--rounds", "0"], 2, "--rounds");
    refused(&["accuracy", "/nonexistent/scene.glb"], 1, "/nonexistent/scene.glb");
    refused(&["accuracy", "--json", "/nonexistent/a.json"], 1, "not a folder");
    refused(
        &["plan", "--technique", "forward", "--limits", "minimum", "--accumulation", "f16"],
        2,
        "--accumulation f16 is for",
    );
    refused(&["plan", "--limits", "minimum", "--slices-per-octave", "3"], 2, "a power of two");
}

#[test]
fn what_cannot_be_measured_leaves_no_file() {
    let Some(folder) = drawn_folder("accuracy-refused") else { return };
    let json = folder.join("a.json").display().to_string();
    refused(&["accuracy", "--size", "100000x100000", "--json", &json], 1, "100000x100000");
    refused(&["accuracy", "--light-range=-1", "--json", &json], 2, "--light-range -1 is not a positive distance");
    assert!(!folder.join("a.json").exists());
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

fn rows<'a>(value: &'a Value, knob: &str) -> Vec<&'a Value> {
    let rows = value["rows"].as_array().expect("rows");
    rows.iter().filter(|row| row["knob"] == knob && row["outcome"] == "measured").collect()
}

fn number(row: &Value, path: &str) -> f64 {
    row.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {row}"))
}

/// Every knob of a small room under eight lights.
fn measured(folder: &Path) -> (Value, String) {
    let place = |name: &str| folder.join(name).display().to_string();
    let tiny = ["accuracy", "builtin:cornell", "--quick", "--size", "64x36", "--lights", "8", "--rounds", "1"];
    let (json, plots, report) = (place("a.json"), place("plots"), place("report"));
    let output = lampyris(&[&tiny[..], &["--json", &json, "--plot", &plots, "--report", &report]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&json).expect("a file");
    (serde_json::from_str(&text).expect("JSON"), String::from_utf8(output.stdout).expect("UTF-8"))
}

#[test]
fn every_knob_gives_a_table_rows_figures_and_a_page() {
    let Some(folder) = drawn_folder("accuracy") else { return };
    let (value, said) = measured(&folder);
    assert_eq!(differences(&first_column(&document("README.md"), "### JSON of `accuracy`"), &value), [""; 0]);
    let page = std::fs::read_to_string(folder.join("report/index.html")).expect("a page");
    let idle = |knob: &String| knob.starts_with("transparent") || knob.starts_with("gi-");
    for knob in knobs().into_iter().filter(|knob| !idle(knob)) {
        let rows = rows(&value, &knob);
        assert!(rows.len() > 1, "{knob}: {value}");
        assert!(said.contains(&format!("\n{knob}: ")) && page.contains(&format!("<h2>{knob}: ")), "{knob}: {said}");
        for front in ["on_time_front", "on_bytes_front"] {
            assert!(rows.iter().any(|row| row[front] == true), "{knob} {front}");
        }
        for row in &rows {
            assert!(number(row, "/ms/median") > 0.0 && number(row, "/memory_bytes") > 0.0, "{row}");
            assert!(row["passes"].as_array().is_some_and(|passes| !passes.is_empty()), "{row}");
        }
        for name in [knob.clone(), format!("{knob}-2")] {
            let svg = std::fs::read_to_string(folder.join(format!("plots/{name}.svg"))).expect("an SVG");
            assert!(svg.starts_with("<svg ") && page.contains(&svg), "{name}");
            let png = std::fs::read(folder.join(format!("plots/{name}.png"))).expect("a PNG");
            assert!(image::load_from_memory(&png).is_ok(), "{name}");
        }
    }
    judged(&value);
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

/// Bounced light by knobs that are turned where they are asked for: more gathers come nearer to paths, and no codec but the thesis' is far off.
#[test]
fn knobs_of_bounced_light_are_judged_by_paths() {
    let Some(folder) = drawn_folder("accuracy-bounced") else { return };
    let json = folder.join("a.json").display().to_string();
    let tiny = ["--quick", "--size", "64x36", "--rounds", "1", "--json", &json];
    let room = [
        "accuracy",
        "builtin:cornell",
        "--shading",
        "lambert",
        "--knob",
        "gi-gathers,gi-tolerance,gi-iteration,gi-path,gi-patches,gi-codec",
    ];
    let output = lampyris(&[&room[..], &tiny[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_str(&std::fs::read_to_string(&json).expect("a file")).expect("JSON");
    let error = |row: &Value| number(row, "/error/mean");
    let gathers = rows(&value, "gi-gathers");
    assert_eq!(gathers.len(), 7, "{value}");
    assert!(error(gathers[1]) > 1.2 * error(gathers[0]) && error(gathers[0]) < 0.15, "{gathers:#?}");
    let tolerances = rows(&value, "gi-tolerance");
    assert_eq!(tolerances.len(), 5, "{value}");
    // Patches are what is wrong in all of them: a tighter tolerance than the default is not seen, a looser one is, whichever way.
    let [default, loose, tight] = [0, 1, 4].map(|at| error(tolerances[at]));
    let from_tight = |error: f64| (error / tight - 1.0).abs();
    assert!(from_tight(default) < 0.03 && from_tight(loose) > from_tight(default), "{tolerances:#?}");
    assert_eq!(rows(&value, "gi-iteration").len(), 2, "{value}");
    // Both paths have the same words.
    let paths = rows(&value, "gi-path");
    assert!(paths.len() == 2 && error(paths[0]) == error(paths[1]), "{paths:#?}");
    assert_eq!(rows(&value, "gi-patches").len(), 3, "{value}");
    let codecs = rows(&value, "gi-codec");
    assert_eq!(codecs.len(), 7, "{value}");
    for row in codecs {
        let thesis = row["setting"].as_str().is_some_and(|name| name.starts_with("thesis"));
        assert!(thesis || error(row) < 1.5 * error(gathers[0]), "{row}");
    }
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

#[test]
fn knobs_of_blended_surfaces_are_for_scenes_that_have_some() {
    let Some(folder) = drawn_folder("accuracy-glass") else { return };
    let json = folder.join("a.json").display().to_string();
    let tiny = ["--quick", "--size", "64x36", "--lights", "8", "--rounds", "1", "--json", &json];
    let glass = ["accuracy", "builtin:glass:layers=2", "--knob", "transparent-bounds,transparent-sort"];
    let output = lampyris(&[&glass[..], &tiny[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_str(&std::fs::read_to_string(&json).expect("a file")).expect("JSON");
    let bounds = rows(&value, "transparent-bounds");
    assert_eq!(bounds.len(), 3, "{value}");
    for row in bounds {
        assert_eq!(number(row, "/from_forward/differing_pixels"), 0.0, "{row}");
    }
    assert_eq!(rows(&value, "transparent-sort").len(), 2, "{value}");
    refused(&["accuracy", "builtin:cornell", "--knob", "transparent-sort"], 2, "nothing in builtin:cornell is blended");
    std::fs::remove_dir_all(folder).expect("cleaned up");
}

/// What each knob may change, and what it must not.
fn judged(value: &Value) {
    let is_exact = |row: &Value| row["setting"] != "bounds-textbook";
    for knob in ["tile", "cull", "depth-bounds", "slices"] {
        for row in rows(value, knob).into_iter().filter(|row| is_exact(row)) {
            let found = ["/missed_pairs", "/from_forward/differing_pixels"].map(|path| number(row, path));
            assert_eq!(found, [0.0, 0.0], "{row}");
        }
    }
    // The coarsest grid moves a vertex by 1/32 pixel along each axis, and of so small a picture that is much.
    assert!(rows(value, "tile").into_iter().all(|row| number(row, "/error/mean") < 0.05), "{value}");
    for row in rows(value, "gbuffer") {
        assert_eq!(number(row, "/from_forward/differing_pixels") == 0.0, row["setting"] == "fat", "{row}");
    }
    let errors: Vec<f64> = rows(value, "light-cutoff").into_iter().map(|row| number(row, "/error/mean")).collect();
    assert!(errors.len() == 4 && errors.windows(2).all(|pair| pair[0] > pair[1]), "{errors:?}");
    // Every device has one sample a pixel, and four; edges are closer with more.
    let sampled = rows(value, "msaa");
    let errors: Vec<f64> = sampled.iter().map(|row| number(row, "/error/mean")).collect();
    assert!(errors.len() > 1 && errors.windows(2).all(|pair| pair[0] > pair[1]), "{errors:?}");
    let accumulated = rows(value, "accumulation");
    let (whole, half) = (accumulated[0], accumulated[1]);
    assert!(number(half, "/memory_bytes") < number(whole, "/memory_bytes"), "{whole} {half}");
    assert!(number(half, "/from_forward/mean") > number(whole, "/from_forward/mean"), "{whole} {half}");
}
