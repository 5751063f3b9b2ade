//! The device against itself and against f64, by the rows that `check` prints.

use lampyris::checks;

use crate::support;

fn run(name: &str) {
    let Some(gpu) = support::gpu() else { return };
    let check = checks::ALL.iter().find(|c| c.0 == name).expect("a check of that name").1;
    let rows = check(&gpu.renderer).expect("the check runs");
    assert!(!rows.is_empty());
    for row in &rows {
        println!("{}: {}", row.name, row.detail);
    }
    let failed: Vec<_> = rows.iter().filter(|r| !r.passed).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn prepass_changes_nothing() {
    run("prepass");
}

#[test]
fn light_fetch_changes_nothing() {
    run("fetch");
}

#[test]
fn c11_first_frame_equals_tenth() {
    run("still");
}

#[test]
fn shading_against_f64() {
    run("shading");
}

#[test]
fn pictures_against_rays() {
    run("picture");
}
