//! The device against itself and against f64, by the rows that `check` prints.

use std::path::Path;

use lampyris::checks;
use lampyris::plan::Request;
use lampyris::scene::gltf;

use crate::support::{gpu, run};

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
