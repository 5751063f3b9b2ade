//! Effects that a scene calls for, by the rows that `check` prints.

use lampyris::plan::{Limits, Plan, Request, STATEMENTS};
use lampyris::scene::builtin;

use crate::documents::{document, table};
use crate::support::run;

#[test]
fn t8_blended_surfaces_are_lit_alike_everywhere() {
    run("transparency");
}

#[test]
fn bounds_of_blended_surfaces_equal_their_twin() {
    run("transparent_bounds");
}

#[test]
fn blended_surfaces_are_mixed_without_float_blending() {
    run("transparent_layer");
}

#[test]
fn parallax_against_rays() {
    run("parallax");
}

#[test]
fn shading_models_of_materials() {
    run("material_models");
}

#[test]
fn several_samples_a_pixel_in_every_technique() {
    run("msaa");
}

#[test]
fn t7_a_far_wall_in_one_sample_of_four() {
    run("msaa_bar");
}

#[test]
fn samples_are_lit_one_by_one_where_they_differ() {
    run("msaa_edges");
}

#[test]
fn spot_lights_are_culled_by_their_cones() {
    run("spot_lists");
}

#[test]
fn shadows_against_rays_by_size_and_filter() {
    run("shadow_error");
}

#[test]
fn surfaces_do_not_shade_themselves() {
    run("shadow_acne");
}

#[test]
fn light_does_not_leak_through_walls() {
    run("shadow_leaks");
}

#[test]
fn l1_shadows_of_cones_of_every_width() {
    run("shadow_cones");
}

#[test]
fn shadows_stand_still_under_a_moving_camera() {
    run("shadows_still");
}

#[test]
fn shadows_in_every_technique() {
    run("shadow_agreement");
}

#[test]
fn shadow_maps_are_drawn_where_and_when_they_are_called_for() {
    run("shadow_maps");
}

#[test]
fn a_covering_array_of_effects_and_their_overrides() {
    run("subsets");
}

#[test]
fn the_table_of_effects_is_what_effects_state() {
    let text = document("README.md");
    let rows: Vec<String> = STATEMENTS
        .iter()
        .map(|s| format!("| `{}` | {} | {} | {} |", s.name, s.called_by, s.costs, s.off).replace("2|4|8", "2\\|4\\|8"))
        .collect();
    assert_eq!(table(&text, "### Effects"), rows);
    let scene = builtin::load("cornell").expect("a built-in scene");
    let plan = Plan::new(&scene, &Request::default(), &Limits::MINIMUM).expect("a plan");
    let planned: Vec<&str> = plan.effects.iter().map(|effect| effect.name).collect();
    assert_eq!(planned, STATEMENTS.map(|s| s.name));
}
