use glam::{DMat4, DVec3};

use super::*;
use crate::math::random::Random;
use crate::plan::{Plan, Technique};
use crate::scene::{Light, Projection, builtin, scatter};

fn request(shadows: Option<u32>) -> Request {
    Request { technique: Technique::Forward, shadows, shadow_size: 256, ..Request::default() }
}

fn limits() -> Limits {
    Limits { max_image_dimension: 16_384, max_texel_elements: 65_536, ..Limits::MINIMUM }
}

fn planned(scene: &Scene, request: &Request) -> Plan {
    Plan::new(scene, request, &limits()).expect("a plan")
}

/// A room of 4 m that is seen from within, and lights of every kind in it; the fourth is far outside.
fn lit() -> Scene {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    let light = |kind: LightKind, position: [f64; 3], intensity: f32, range: f32| Light {
        name: "lamp".into(),
        kind,
        color: [1.0; 3],
        intensity,
        position: DVec3::from_array(position),
        direction: DVec3::NEG_Z,
        range: Some(range),
        shadow: false,
    };
    let cone = |outer: f32| LightKind::Spot { inner: 0.2, outer };
    let sun = light(LightKind::Directional, [0.0; 3], 1.0, 1.0);
    scene.lights = vec![
        light(LightKind::Point, [0.5, 0.2, -1.0], 4.0, 3.0),
        Light { direction: DVec3::new(0.2, -0.5, -1.0).normalize(), range: None, ..sun },
        light(cone(0.5), [-1.0, 1.0, 1.0], 1.0, 9.0),
        light(LightKind::Point, [0.0, 0.0, 60.0], 100.0, 2.0),
        light(cone(1.3), [1.0, 1.0, 1.0], 1.0, 9.0),
    ];
    scene
}

fn places(plan: &Plan) -> Vec<DVec3> {
    plan.lighting.lights.iter().filter(|light| light.shadow).map(|light| light.position).collect()
}

#[test]
fn lights_that_matter_most_come_first_and_those_out_of_view_never() {
    let plan = planned(&lit(), &request(Some(9)));
    assert_eq!(plan.shadows.as_ref().expect("shadows").lights.len(), 4);
    assert!(plan.lighting.lights[..4].iter().all(|light| light.shadow) && !plan.lighting.lights[4].shadow);
    // Three lux at the middle of its range over a third of the picture, against one everywhere and less.
    let point = lit().lights[0].position;
    assert_eq!(places(&planned(&lit(), &request(Some(1)))), [point]);
    let mut dim = lit();
    dim.lights[0].intensity = 1e-3;
    assert!(!places(&planned(&dim, &request(Some(3)))).contains(&point));
    assert!(planned(&lit(), &request(None)).shadows.is_none() && planned(&lit(), &request(Some(0))).shadows.is_none());
    let mut asking = lit();
    asking.lights[2].shadow = true;
    asking.lights[3].shadow = true;
    assert_eq!(places(&planned(&asking, &request(None))), [asking.lights[2].position]);
}

#[test]
fn a_cone_that_shines_away_takes_nobodys_place() {
    let mut scene = lit();
    for outer in [0.4, 1.4] {
        // Behind the eye, which looks along -z.
        let away = Light {
            direction: DVec3::Z,
            intensity: 1e6,
            position: DVec3::new(0.4, 0.2, 1.9),
            ..scene.lights[2].clone()
        };
        scene.lights[2] = Light { kind: LightKind::Spot { inner: 0.0, outer }, ..away };
        let plan = planned(&scene, &request(Some(1)));
        assert_eq!(places(&plan), [scene.lights[0].position], "{outer}");
    }
}

#[test]
fn each_kind_of_light_has_its_maps() {
    let plan = planned(&lit(), &request(Some(9)));
    let shadows = plan.shadows.expect("shadows");
    let counts: Vec<usize> = shadows.lights.iter().map(|light| light.map_count).collect();
    // The sun first; then in the order of the scene.
    assert_eq!(counts[1..], [6, 1, 6]);
    let wide = &shadows.lights[3];
    let behind = &shadows.maps[wide.first_map + 4];
    assert_eq!(behind.area[2], 0, "a cone of 1.3 rad along -z has no map towards +z");
    // Out of doors the far end of the view is farther than what the first cascades hold.
    let terrain = planned(&builtin::load("terrain").expect("a built-in scene"), &request(Some(1)));
    assert_eq!(terrain.shadows.expect("shadows").lights[0].map_count, 4);
}

/// Views of every kind of lens, of a scene with lights of every kind.
fn views() -> Vec<Scene> {
    let lens = |projection: Projection, turn: f64| {
        let mut scene = lit();
        let camera = &mut scene.cameras[0];
        camera.projection = projection;
        camera.camera_to_world *= DMat4::from_rotation_y(turn);
        scene
    };
    let flat = |xmag: f64| Projection::Orthographic { xmag, ymag: 1.5, znear: -0.5, zfar: 3.0 };
    let deep = |zfar: Option<f64>| Projection::Perspective { yfov: 1.2, aspect: None, znear: 0.01, zfar };
    vec![lit(), lens(flat(1.5), 0.1), lens(flat(-1.5), 0.0), lens(deep(Some(3.2)), 0.3), lens(deep(None), -0.4)]
}

#[test]
fn what_is_seen_lies_in_a_map_clear_of_what_a_filter_reaches() {
    let mut random = Random::new(5);
    let mut compared = [0; 5];
    for (scene, compared) in views().iter().zip(&mut compared) {
        for filter in [0, 2, 8] {
            let plan = planned(scene, &Request { shadow_filter: filter, ..request(Some(9)) });
            let shadows = plan.shadows.as_ref().expect("shadows");
            let inset = 1.0 - f64::from(filter + 1) / f64::from(shadows.size);
            for _ in 0..2000 {
                // A point of a wall, the floor or the ceiling.
                let mut at = [0; 3].map(|_| random.range(-2.0, 2.0));
                let axis = (random.unit_f64() * 3.0) as usize % 3;
                at[axis] = if random.unit_f64() < 0.5 { -2.0 } else { 2.0 };
                let at = DVec3::from_array(at);
                let seen = plan.view.world_to_view.transform_point3(at);
                let clip = plan.view.view_to_clip() * seen.extend(1.0);
                if clip.w <= 0.0 || clip.x.abs() > clip.w || clip.y.abs() > clip.w || clip.z < 0.0 || clip.z > clip.w {
                    continue;
                }
                *compared += 1;
                for light in &shadows.lights {
                    let maps = &shadows.maps[light.first_map..light.first_map + light.map_count];
                    let holds = |map: &Map| {
                        let clip = map.view_to_map * seen.extend(1.0);
                        clip.w > 0.0 && (clip.x / clip.w).abs() < inset && (clip.y / clip.w).abs() < inset
                    };
                    let resolved = &plan.lighting.lights[light.light];
                    let to_point = (at - resolved.position).normalize();
                    let in_cone = resolved.cone(to_point.dot(resolved.direction)) > 0.0;
                    if resolved.kind == LightKind::Directional
                        || (in_cone && at.distance(resolved.position) < resolved.range)
                    {
                        assert!(maps.iter().any(|map| map.area[2] > 0 && holds(map)), "{:?} at {at}", resolved.kind);
                    }
                }
            }
        }
    }
    assert!(compared.iter().all(|count| *count > 300), "{compared:?}");
}

#[test]
fn a_light_of_huge_range_draws_what_is_close_to_it() {
    let mut scene = lit();
    scene.lights.truncate(1);
    for range in [None, Some(1e9)] {
        scene.lights[0] = Light { range, intensity: 1e6, ..scene.lights[0].clone() };
        let plan = planned(&scene, &request(Some(1)));
        let shadows = plan.shadows.as_ref().expect("shadows");
        let map = shadows.maps.iter().find(|map| map.area[2] > 0).expect("a map");
        // Depth is the near distance over distance, which at 1 cm from the light has to stay below 1.
        let near = map.view_to_map.row(2).w;
        assert!(near > 0.0 && near < 1e-3, "{near}");
    }
}

#[test]
fn maps_lie_beside_one_another_in_one_image() {
    let mut scene = builtin::load("atrium").expect("a built-in scene");
    scene.lights = scatter::point_lights(&scene.bounds(), 40, 1);
    let limits = Limits { max_image_dimension: 4096, ..limits() };
    let asked = Request { shadow_size: 1024, ..request(Some(40)) };
    let plan = Plan::new(&scene, &asked, &limits).expect("a plan");
    let shadows = plan.shadows.as_ref().expect("shadows");
    assert!(shadows.size < 1024 && plan.notes.iter().any(|note| note.contains("instead of 1024")));
    assert!(shadows.atlas.iter().all(|side| *side <= 4096));
    let areas: std::collections::BTreeSet<[u32; 4]> =
        shadows.maps.iter().map(|map| map.area).filter(|area| area[2] > 0).collect();
    assert_eq!(areas.len(), shadows.drawn());
    assert!(areas.iter().all(|[x, y, w, h]| x + w <= shadows.atlas[0] && y + h <= shadows.atlas[1]));
    assert!(areas.iter().all(|area| area.iter().all(|side| side % shadows.size == 0)));
    let refused =
        Plan::new(&scene, &Request { strict: true, ..asked.clone() }, &limits).expect_err("too many").to_string();
    assert!(refused.contains("--shadow-size 1024"), "{refused}");
    let none = Limits { max_image_dimension: 128, ..limits };
    let small = Request { width: 64, height: 64, ..asked };
    let refused = Plan::new(&scene, &small, &none).expect_err("none fits").to_string();
    assert!(refused.contains("--shadows N chooses fewer"), "{refused}");
}

#[test]
fn more_than_a_texel_buffer_tells_of_is_refused() {
    let mut scene = lit();
    scene.lights = scatter::point_lights(&scene.bounds(), 40, 1);
    let few = Limits { max_texel_elements: 1000, ..limits() };
    let refused = Plan::new(&scene, &request(Some(40)), &few).expect_err("too many").to_string();
    assert!(refused.contains("40 lights") && refused.contains("1000"), "{refused}");
}

#[test]
fn numbers_that_no_map_has_are_refused() {
    for (size, filter) in [(0, 2), (100, 2), (32, 2), (16_384, 2), (256, 9)] {
        let asked = Request { shadow_size: size, shadow_filter: filter, ..request(Some(1)) };
        assert!(Plan::new(&lit(), &asked, &limits()).is_err(), "{size} {filter}");
    }
}

#[test]
fn rays_need_no_maps_and_views_of_surfaces_no_shadows() {
    let few = Limits { max_image_dimension: 2048, max_texel_elements: 0, ..Limits::UNLIMITED };
    let traced = Request { technique: Technique::Reference, ..request(Some(9)) };
    let plan = Plan::new(&lit(), &traced, &few).expect("a plan");
    assert!(plan.shadows.is_none() && plan.lighting.lights.iter().filter(|light| light.shadow).count() == 4);
    let says = |plan: &Plan| plan.effects.iter().find(|e| e.name == "shadows").map(|e| (e.runs, e.bytes));
    assert_eq!(says(&plan), Some((true, 0)));
    let view = Request { debug_view: Some(crate::plan::DebugView::Albedo), ..request(Some(9)) };
    assert_eq!(says(&planned(&lit(), &view)), Some((false, 0)));
    // A cube of 256 x 256 texels of 4 bytes.
    assert_eq!(says(&planned(&lit(), &request(None))), Some((false, 6 << 18)));
}

/// Iterations of the loops of `shadow_share` and `cascade` (glsl/inc/shadow.glsl), the one in which each ends counted.
fn walked(filter: u32, maps: usize) -> u64 {
    let mut count = 0;
    for _ in 0..maps.min(4) {
        count += 1;
    }
    if filter > 0 {
        for _ in 0..=filter {
            count += 1;
            count += u64::from(filter) + 1 + 1;
        }
        count += 1;
    }
    count
}

#[test]
fn loops_over_lights_leave_room_for_those_of_shadows() {
    for filter in [0, 1, 2, 8] {
        let plan = planned(&lit(), &Request { shadow_filter: filter, ..request(Some(9)) });
        let shadows = plan.shadows.expect("shadows");
        let taken: u64 = shadows.lights.iter().map(|light| walked(filter, light.map_count)).sum();
        for each in [1, 4] {
            let left = shadows.leave(each, &Limits { max_loop_iterations: 65_535, ..limits() }).expect("room");
            assert!(u64::from(left.max_loop_iterations) + taken * u64::from(each) <= 65_535, "{filter} {each}");
        }
        assert_eq!(shadows.leave(4, &limits()).expect("no limit").max_loop_iterations, limits().max_loop_iterations);
        assert!(shadows.leave(1, &Limits { max_loop_iterations: 30, ..limits() }).is_err());
    }
}
