//! The device against itself and against f64, by the rows that `check` prints.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use glam::DVec3;
use lampyris::checks;
use lampyris::lists::{self, Counters};
use lampyris::plan::{CameraChoice, CullTest, Plan, Request, Technique};
use lampyris::scene::gltf;

use crate::support::{gpu, lights_beside_the_eye, run};

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
fn tiled_forward_equals_forward() {
    run("tiled");
}

#[test]
fn light_lists_equal_their_twin_and_miss_nothing() {
    run("tile_lists");
}

#[test]
fn the_textbooks_rectangles_miss_lights_and_tangents_none() {
    let Some(gpu) = gpu() else { return };
    let scene = lights_beside_the_eye();
    let counted = |technique, cull| {
        let camera = CameraChoice::LookAt(DVec3::ZERO, DVec3::NEG_Z, FRAC_PI_2);
        let request = Request { width: 96, height: 96, technique, cull, camera, ..Request::default() };
        let plan = Plan::new(&scene, &request, &gpu.limits()).expect("a plan");
        let made = lists::make(&gpu, &scene, &plan).expect("lists");
        assert!(made.violations.is_empty(), "{:#?}", made.violations);
        let counters = Counters::new(&made.cells, &made.judge(&plan), lists::directional(&plan));
        println!("{} {}: {counters:?}", technique.name(), cull.name());
        counters
    };
    let textbook = counted(Technique::TiledForward, CullTest::BoundsTextbook);
    let tangents = counted(Technique::TiledForward, CullTest::Bounds);
    let forward = counted(Technique::Forward, CullTest::Bounds);
    assert!(textbook.missed_pairs > 1000, "{textbook:?}");
    assert_eq!((tangents.missed_pairs, forward.missed_pairs), (0, 0));
    assert_eq!((tangents.exact_pairs, forward.exact_pairs), (textbook.exact_pairs, textbook.exact_pairs));
    assert_eq!((forward.light_pairs, forward.longest_list, forward.light_evaluations), (64, 64, 64 * 96 * 96));
    assert!(tangents.light_evaluations < forward.light_evaluations && tangents.light_pairs > forward.light_pairs);
    assert_eq!(textbook.lists_overflowed + tangents.lists_overflowed + forward.lists_overflowed, 0);
}

#[test]
fn clustered_forward_equals_forward() {
    run("clustered");
}

#[test]
fn clusters_equal_their_twin_and_miss_nothing() {
    run("cluster_lists");
}

#[test]
fn deferred_techniques_agree() {
    run("deferred");
}

#[test]
fn light_markers_are_the_same_everywhere() {
    run("markers");
}

#[test]
fn l7_light_volumes_wherever_the_eye_is() {
    run("volumes");
}

#[test]
fn light_tree_equals_its_twin() {
    run("light_tree");
}

#[test]
fn lists_are_sorted_as_the_twin_sorts_them() {
    run("list_sort");
}

#[test]
fn shading_against_f64() {
    run("shading");
}

#[test]
fn pictures_against_rays() {
    run("picture");
}

#[test]
fn textures_through_every_sampler() {
    run("samplers");
}

#[test]
fn maps_of_every_kind() {
    run("material_maps");
}

#[test]
fn materials_of_every_kind() {
    run("material_modes");
}

#[test]
fn every_scene_every_shading_against_f64() {
    let Some(gpu) = gpu() else { return };
    let rows = checks::scenes(&gpu).expect("the scenes draw");
    assert!(!rows.is_empty());
    for row in &rows {
        println!("{}: {}", row.name, row.detail);
    }
    let failed: Vec<_> = rows.iter().filter(|r| !r.passed).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Files that other programs wrote, kept beside the checkout and not in it.
const STRANGERS: [&str; 4] =
    ["assets/FlightHelmet/FlightHelmet.gltf", "assets/CornellBox.glb", "assets/Cubes.glb", "peers/grid-256.glb"];

#[test]
fn strangers_files_draw() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let Some(gpu) = gpu() else { return };
    for file in STRANGERS {
        let path = folder.join(file);
        if !path.is_file() {
            println!("{file}: not there");
            continue;
        }
        let scene = gltf::load(&path).expect(file);
        let request = Request { width: 160, height: 90, ..Request::default() };
        let judged = checks::judge(&gpu, &scene, &request).expect(file);
        println!("{file}: {judged:?}");
        assert!(judged.covered > 0 && judged.interior > 0, "{file}: nothing is seen");
        assert_eq!(judged.not_finite, 0, "{file}");
        assert!(judged.error <= judged.bound, "{file}: {:e}, at most {:e}", judged.error, judged.bound);
    }
}
