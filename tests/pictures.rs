//! The device against itself and against f64, by the rows that `check` prints.

use crate::support::run;

#[test]
fn shared_structs_lie_alike_on_both_sides() {
    run("layout");
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
