//! The table of hard cases, row by row. Those that need a device are rows of `check`; the others are values and sentences.

use glam::DVec3;
use lampyris::math::random::Random;
use lampyris::plan::{Limits, Plan, Request, Technique};
use lampyris::scene::lighting::{Attenuation, LightRules, Lighting};
use lampyris::scene::view::{Extents, Lens, View};
use lampyris::scene::{Camera, Light, LightKind, Projection, gltf};

use crate::hard_values::{lamp, room, scaled_lamp};
use crate::support::run;

#[test]
fn p1_to_p7_lights_whose_projection_is_hard() {
    run("projection");
}

#[test]
fn t2_t4_t6_t9_tiles() {
    run("tiles");
}

#[test]
fn t5_light_in_the_gap() {
    run("gap");
}

#[test]
fn t11_depths_of_positions() {
    run("depths");
}

#[test]
fn c1_c4_slices_on_the_device() {
    run("cluster_slices");
}

#[test]
fn c2_c3_c5_c6_c8_clusters() {
    run("cluster_cases");
}

#[test]
fn clusters_waste_less_than_tiles() {
    run("cluster_waste");
}

#[test]
fn c7_sort_is_stable_and_equals_the_cpus() {
    run("sort");
}

#[test]
fn scan_equals_its_twin() {
    run("scan");
}

#[test]
fn t3_each_way_of_culling_keeps_its_gain() {
    run("tile_waste");
}

#[test]
fn t1_lists_hold_little_that_is_not_needed() {
    run("waste");
}

#[test]
fn c10_twenty_runs_give_the_same_lists() {
    run("twenty_runs");
}

#[test]
fn l1_spot_cones_of_every_angle() {
    run("spot_cones");
}

#[test]
fn l2_light_ends_at_its_range_bit_for_bit() {
    run("range_edge");
}

#[test]
fn l2_light_on_the_surface_is_finite() {
    run("light_on_surface");
}

#[test]
fn l3_loops_as_long_as_the_plan_allows() {
    run("long_loops");
}

#[test]
fn sums_in_parts_are_sums_in_one() {
    run("light_parts");
}

#[test]
fn lights_by_the_ten_thousand_miss_nothing_and_draw_what_forward_draws() {
    run("lights_65536");
}

#[test]
fn l3_many_lights_and_weak_beside_strong() {
    run("many_lights");
}

#[test]
fn l4_surfaces_without_directions() {
    run("surface_fallbacks");
}

#[test]
fn l5_normals_decoded_on_the_device() {
    run("octahedral");
}

#[test]
fn l6_cameras_far_from_the_origin() {
    run("far_camera");
}

#[test]
fn l9_radiance_over_all_of_f32() {
    run("radiance_range");
}

#[test]
fn l10_every_distance_law_on_the_device() {
    run("attenuations");
}

#[test]
fn t9_nodes_that_mirror_and_stretch() {
    run("node_transforms");
}

#[test]
fn p7_lenses_of_every_kind() {
    run("lenses");
}

/// `c + l d + q d^2` over `intensity / cutoff`, less 1.
fn residual(law: &Attenuation, ratio: f64, d: f64) -> f64 {
    ((law.constant + d * (law.linear + d * law.quadratic)) / ratio - 1.0).abs()
}

/// The denominator has no negative term, so putting the distance back rounds by some 1e-16 whatever its parts are.
const RESIDUAL: f64 = 1e-12;

#[test]
fn l10_solved_ranges_put_back_into_the_law() {
    let cutoff = 5.0 / 256.0;
    for [constant, linear, quadratic] in
        [[1.0, 0.7, 0.0], [1.0, 0.7, 1.8], [0.0, 0.0, 1.0], [1.0, 1.0, 1e-12], [0.0, 1.0, 1e-300], [51.0, 1e-9, 1e-9]]
    {
        let law = Attenuation { constant, linear, quadratic };
        let d = law.solve_range(1.0, cutoff);
        assert!(residual(&law, 1.0 / cutoff, d) <= RESIDUAL, "{law:?}: {d}");
        assert!((law.falloff(d) / cutoff - 1.0).abs() <= RESIDUAL, "{law:?}: {d}");
    }
    let mut random = Random::new(10);
    let mut power = |low: f64, high: f64| 10f64.powf(random.range(low, high));
    for _ in 0..10_000 {
        let ratio = power(-6.0, 12.0);
        let constant = ratio * (1.0 - power(-9.0, 0.0));
        let law = Attenuation { constant, linear: power(-15.0, 15.0), quadratic: power(-15.0, 15.0) };
        let d = law.solve_range(ratio * cutoff, cutoff);
        assert!(residual(&law, ratio, d) <= RESIDUAL, "{law:?}, {ratio}: {d}");
    }
    // The textbook root loses most digits here, and the measure shows it.
    let (linear, quadratic, target) = (1.0f64, 1e-12, 50.2);
    let textbook = ((linear * linear + 4.0 * quadratic * target).sqrt() - linear) / (2.0 * quadratic);
    let law = Attenuation { constant: 1.0, linear, quadratic };
    assert!(residual(&law, 1.0 / cutoff, textbook) > 1e3 * RESIDUAL, "{textbook}");
}

#[test]
fn l10_ranges_past_f64_are_infinite_or_right() {
    let physical = Attenuation::PHYSICAL;
    assert_eq!(physical.solve_range(1.0, 0.0), f64::INFINITY);
    assert_eq!(physical.solve_range(1e6, 1e-310), f64::INFINITY, "the ratio itself is infinite");
    // 1e308 fits f64, four times as much does not.
    assert!((physical.solve_range(1.0, 1e-308) / 1e154 - 1.0).abs() < RESIDUAL);
    let linear = Attenuation { constant: 0.0, linear: 1e200, quadratic: 0.0 };
    assert!((linear.solve_range(1.0, 1e-300) / 1e100 - 1.0).abs() < RESIDUAL);
}

#[test]
fn l10_absent_and_unbounded_lights_are_counted_and_said() {
    let solved = |[constant, linear, quadratic]: [f64; 3]| {
        let mut scene = room();
        scene.lights = vec![Light { kind: LightKind::Point, intensity: 1.0, ..lamp() }];
        let attenuation = Attenuation { constant, linear, quadratic };
        let rules = LightRules { attenuation, ..LightRules::default() };
        let lighting = Lighting::new(&scene, &rules).expect("good rules");
        let request = Request { width: 8, height: 6, rules, technique: Technique::Forward, ..Request::default() };
        let notes = Plan::new(&scene, &request, &Limits::UNLIMITED).expect("a plan").notes.join("; ");
        (lighting.absent, lighting.unbounded, lighting.lights.len(), notes)
    };
    // 1 cd over the cut-off of 5/256 is 51.2.
    for [constant, linear] in [[51.2, 0.0], [51.2, 1.0], [60.0, 0.0]] {
        let (absent, unbounded, present, notes) = solved([constant, linear, 0.0]);
        assert_eq!((absent, unbounded, present), (1, 0, 0), "K_c {constant}");
        assert!(notes.contains("1 lights never rise"), "{notes}");
    }
    let (absent, unbounded, present, notes) = solved([51.1, 0.0, 0.0]);
    assert_eq!((absent, unbounded, present), (0, 1, 1));
    assert!(notes.contains("no finite range"), "{notes}");
    let (absent, unbounded, present, notes) = solved([1.0, 0.7, 1.8]);
    assert_eq!((absent, unbounded, present), (0, 0, 1));
    assert!(!notes.contains("no finite range") && !notes.contains("never rise"), "{notes}");
}

#[test]
fn t9_scaled_cameras_stay_rigid_and_ranges_stay_as_given() {
    let camera = |scale: &str| {
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"camera":0,"scale":[{scale}],"translation":[1,2,3],
            "rotation":[0.1,-0.7,0.2,0.678233]}}],
            "cameras":[{{"type":"perspective","perspective":{{"yfov":0.7,"znear":0.05}}}}]}}"#
        );
        let mut scene = gltf::load_slice(text.as_bytes(), None, "camera.gltf").expect("a camera");
        scene.cameras.remove(0)
    };
    let straight = camera("1,1,1");
    for scale in ["2,3,0.5", "-1,1,1", "-2,3,0.5", "1e-6,1e-6,1e-6", "1e6,1,1e6"] {
        let scaled = camera(scale);
        assert!(scaled.camera_to_world.abs_diff_eq(straight.camera_to_world, 1e-12), "{scale}: {scaled:?}");
        assert_eq!(scaled.projection, straight.projection);
    }
    // KHR_lights_punctual: a node's scale does not change what a light reaches.
    for scale in ["1", "-2", "1e3"] {
        let scene = gltf::load_slice(scaled_lamp(scale).as_bytes(), None, "lamp.gltf").expect(scale);
        assert_eq!(scene.lights[0].range, Some(3.0), "{scale}");
    }
}

/// Column, row and depth 1..0 at which the rasteriser puts a point.
fn projected(view: &View, point: DVec3) -> DVec3 {
    let clip = view.view_to_clip() * point.extend(1.0);
    let ndc = clip.truncate() / clip.w;
    let pixel = |ndc: f64, size: u32| 0.5 * (ndc + 1.0) * f64::from(size) - 0.5;
    DVec3::new(pixel(ndc.x, view.width), pixel(ndc.y, view.height), ndc.z)
}

#[test]
fn p7_rays_and_clip_space_agree_off_centre() {
    let (perspective, flat) = (
        Projection::Perspective { yfov: 0.8, aspect: None, znear: 0.1, zfar: Some(900.0) },
        Projection::Orthographic { xmag: 1.0, ymag: 1.0, znear: -2.0, zfar: 900.0 },
    );
    let extents = [
        [-0.7, 0.7, -0.5, 0.5],
        [-0.3, 1.1, -0.9, 0.2],
        [2.0, 3.0, -2.0, -1.5],
        [0.7, -0.7, -0.5, 0.5],
        [-0.3, 1.1, 0.2, -0.9],
    ];
    for projection in [perspective, flat] {
        let camera = Camera { projection, ..Camera::looking(DVec3::ONE, DVec3::ZERO, 1.0) };
        let mut view = View::new(&camera, 64, 48).expect("a good camera");
        for [left, right, bottom, top] in extents {
            let extents = Extents { left, right, bottom, top };
            let perspective = view.lens.is_perspective();
            view.lens = if perspective { Lens::Perspective(extents) } else { Lens::Orthographic(extents) };
            let (near, far) = (view.znear, view.zfar.unwrap_or(f64::INFINITY));
            // Corners of the picture, centres of its corner pixels, and a point between.
            let points = [-0.5, 0.0, 17.3, 63.0, 63.5].map(|x| [-0.5, 0.0, 31.9, 47.0, 47.5].map(|y| (x, y)));
            for (x, y) in points.into_iter().flatten() {
                let (origin, direction) = view.ray(x, y);
                for (distance, depth) in [(near, Some(1.0)), (1.0, None), (700.0, None), (far, Some(0.0))] {
                    let found = projected(&view, origin + direction * distance);
                    let off = (found.x - x).abs().max((found.y - y).abs());
                    assert!(off <= 1e-12, "{extents:?}, ({x}, {y}) at {distance} m: {found}");
                    assert!(depth.is_none_or(|d| (found.z - d).abs() <= 1e-12), "{distance} m: depth {}", found.z);
                    assert!((-1e-12..=1.0 + 1e-12).contains(&found.z), "{distance} m: depth {}", found.z);
                }
            }
        }
    }
}
