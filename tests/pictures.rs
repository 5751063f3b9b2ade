//! The device against itself and against f64, by the rows that `check` prints.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use glam::DVec3;
use lampyris::checks;
use lampyris::gbuffer::{self, ALBEDO, EMISSION, MATERIAL, NORMAL};
use lampyris::lists::{self, Counters};
use lampyris::passes::{self, surface::LAYERS};
use lampyris::plan::{CameraChoice, ClusterBounds, CullTest, DepthBounds, GbufferLayout, Plan, Request, Technique};
use lampyris::reference::octahedral;
use lampyris::renderer::Renderer;
use lampyris::scene::{Scene, builtin, gltf};

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
fn techniques_agree_on_everything_a_scene_may_have() {
    run("agreement");
}

#[test]
fn c12_pictures_are_the_same_whatever_light_data_is_read_from() {
    run("fetches");
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
fn r9_gathers_equal_their_twin() {
    run("radiosity_twin");
}

#[test]
fn r10_r11_a_red_wall_and_a_bright_sun() {
    run("radiosity_hard");
}

#[test]
fn r17_moved_lights_are_as_if_they_had_always_been_there() {
    run("radiosity_moving");
}

#[test]
fn a_device_sees_what_the_cpu_sees() {
    run("radiosity_sight");
}

#[test]
fn light_of_patches_at_first_is_what_rays_find() {
    run("radiosity_direct");
}

#[test]
fn r5_a_furnace_is_one_everywhere() {
    run("radiosity_furnace");
}

#[test]
fn r14_no_light_comes_through_a_wall() {
    run("radiosity_leaks");
}

#[test]
fn techniques_agree_on_bounced_light() {
    run("radiosity_agreement");
}

#[test]
fn bounced_light_is_what_paths_find() {
    run("radiosity_path");
}

/// What the eye among its lights sees.
fn beside(technique: Technique) -> Request {
    let camera = CameraChoice::LookAt(DVec3::ZERO, DVec3::NEG_Z, FRAC_PI_2);
    Request { width: 96, height: 96, technique, camera, ..Request::default() }
}

fn counters(gpu: &Renderer, scene: &Scene, request: &Request) -> Counters {
    let plan = Plan::new(scene, request, &gpu.limits()).expect("a plan");
    let made = lists::make(gpu, scene, &plan).expect("lists");
    assert!(made.violations.is_empty(), "{:#?}", made.violations);
    let counters = Counters::new(&made.cells, &made.judge(&plan), lists::directional(&plan));
    println!("{} {}: {counters:?}", request.technique.name(), request.cull.name());
    counters
}

#[test]
fn the_textbooks_rectangles_miss_lights_and_tangents_none() {
    let Some(gpu) = gpu() else { return };
    let scene = lights_beside_the_eye();
    let counted = |technique, cull| counters(&gpu, &scene, &Request { cull, ..beside(technique) });
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
fn lists_of_clusters_are_counted_like_those_of_tiles() {
    let Some(gpu) = gpu() else { return };
    let scene = lights_beside_the_eye();
    let bounded = Request { depth_bounds: Some(DepthBounds::MinMax), ..beside(Technique::TiledForward) };
    let tiled = counters(&gpu, &scene, &bounded);
    for technique in [Technique::ClusteredForward, Technique::ClusteredDeferred] {
        for (prepass, bounds) in
            [(true, ClusterBounds::Explicit), (true, ClusterBounds::Implicit), (false, ClusterBounds::Implicit)]
        {
            let request = Request { prepass, cluster_bounds: Some(bounds), ..beside(technique) };
            let found = counters(&gpu, &scene, &request);
            assert_eq!((found.exact_pairs, found.missed_pairs, found.lists_overflowed), (tiled.exact_pairs, 0, 0));
            assert!(found.light_evaluations >= found.exact_pairs && found.waste_samples >= 1.0, "{found:?}");
            // Clusters choose from the lists of such tiles.
            assert!(!prepass || found.light_evaluations <= tiled.light_evaluations, "{found:?} {tiled:?}");
        }
    }
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
fn clusters_by_normal_draw_the_same_and_list_less() {
    run("cluster_normals");
}

#[test]
fn clusters_find_the_same_lights_in_lists_of_tiles_and_in_the_hierarchy() {
    run("cluster_trees");
}

/// Layers of four numbers a pixel that a G-buffer holds and that the surface probe leaves.
fn stored_and_seen(gpu: &Renderer, scene: &Scene, request: &Request) -> [[Vec<[f32; 4]>; 4]; 2] {
    let plan = Plan::new(scene, request, &gpu.limits()).expect("a plan");
    let (stored, violations) = gbuffer::make(gpu, scene, &plan).expect("a G-buffer");
    assert!(violations.is_empty(), "{violations:#?}");
    let mut probe = gpu.prepare_frame(scene, &plan, passes::surface_frame(&plan)).expect("a frame");
    probe.draw(1).expect("drawn");
    let seen = probe.read_back().expect("layers");
    let stored = [ALBEDO, NORMAL, MATERIAL, EMISSION].map(|name| stored.rgba(name).expect(name).to_vec());
    [stored, LAYERS.map(|name| seen.rgba(name).expect(name).to_vec())]
}

#[test]
fn gbuffers_hold_the_surfaces_to_their_bits() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::load("cornell").expect("a built-in scene");
    let fat = (gpu.limits().max_color_attachments >= 5).then_some((GbufferLayout::Fat, 16));
    let compact = [8, 10, 16].map(|bits| (GbufferLayout::Compact, bits));
    for (layout, normal_bits) in compact.into_iter().chain(fat) {
        let request = Request {
            // An odd number of pixels.
            width: 65,
            height: 47,
            technique: Technique::TiledDeferred,
            gbuffer: layout,
            normal_bits,
            ..Request::default()
        };
        let [[albedo, normal, material, emission], [position, normals, base, emissive]] =
            stored_and_seen(&gpu, &scene, &request);
        let exact = layout == GbufferLayout::Fat;
        let step = |codes: f32| if exact { 1e-6 } else { 1.0 / codes };
        let angle = if exact { 1e-6 } else { octahedral::angle_bound(normal_bits) + 1e-6 };
        let mut emitting = 0;
        for pixel in 0..65 * 47 {
            let lit = emissive[pixel][3] % 4.0 == 1.0;
            assert_eq!(albedo[pixel][3] == 1.0, lit, "{layout:?} {normal_bits}: {pixel}");
            if !lit {
                continue;
            }
            let near = |a: f32, b: f32, most: f32| assert!((a - b).abs() <= most, "{layout:?} {pixel}: {a} {b}");
            (0..3).for_each(|c| near(albedo[pixel][c].sqrt(), base[pixel][c].sqrt(), step(1023.0)));
            let unit = |p: [f32; 4]| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])).normalize();
            let apart = unit(normal[pixel]).distance(unit(normals[pixel]));
            assert!(2.0 * (apart * 0.5).asin() <= angle, "{layout:?} {normal_bits}: {pixel}: {apart}");
            near(material[pixel][0], position[pixel][3], step(65535.0));
            near(material[pixel][1], base[pixel][3], step(255.0));
            near(material[pixel][2], normals[pixel][3], step(255.0));
            emitting += usize::from(emissive[pixel][0] > 0.0);
            for (held, seen) in emission[pixel].into_iter().zip(emissive[pixel]).take(3) {
                // The fat layout adds ambient light to it.
                if exact { assert!(held >= seen, "{pixel}: {held} {seen}") } else { near(held, seen, seen / 1024.0) }
            }
        }
        assert!(emitting > 0, "the lamp is seen");
    }
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
        let request = Request { width: 160, height: 90, technique: Technique::Forward, ..Request::default() };
        let judged = checks::judge(&gpu, &scene, &request).expect(file);
        println!("{file}: {judged:?}");
        assert!(judged.covered > 0 && judged.interior > 0, "{file}: nothing is seen");
        assert_eq!(judged.not_finite, 0, "{file}");
        assert!(judged.error <= judged.bound, "{file}: {:e}, at most {:e}", judged.error, judged.bound);
    }
}
