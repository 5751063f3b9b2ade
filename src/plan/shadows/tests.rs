use glam::DVec3;

use super::*;
use crate::math::random::Random;
use crate::plan::{Plan, Technique};
use crate::scene::{Light, builtin, scatter};

fn request(shadows: Option<u32>) -> Request {
    Request { technique: Technique::Forward, shadows, shadow_size: 256, ..Request::default() }
}

fn planned(scene: &Scene, request: &Request) -> Plan {
    Plan::new(scene, request, &Limits::UNLIMITED).expect("a plan")
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

#[test]
fn lights_that_matter_most_come_first_and_those_out_of_view_never() {
    let plan = planned(&lit(), &request(Some(9)));
    let shadows = plan.shadows.as_ref().expect("shadows");
    assert_eq!(shadows.lights.len(), 4);
    assert!(plan.lighting.lights[..4].iter().all(|light| light.shadow) && !plan.lighting.lights[4].shadow);
    let [one, two] = [1, 2].map(|n| planned(&lit(), &request(Some(n))));
    let places = |plan: &Plan| -> Vec<DVec3> {
        plan.lighting.lights.iter().filter(|light| light.shadow).map(|light| light.position).collect()
    };
    assert!(places(&two).contains(&places(&one)[0]));
    assert!(planned(&lit(), &request(None)).shadows.is_none() && planned(&lit(), &request(Some(0))).shadows.is_none());
    let mut asking = lit();
    asking.lights[2].shadow = true;
    asking.lights[3].shadow = true;
    let plan = planned(&asking, &request(None));
    assert_eq!(places(&plan), [asking.lights[2].position]);
}

#[test]
fn each_kind_of_light_has_its_maps() {
    let plan = planned(&lit(), &request(Some(9)));
    let shadows = plan.shadows.expect("shadows");
    let counts: Vec<usize> = shadows.lights.iter().map(|light| light.map_count).collect();
    // The sun first; then in the order of the scene. Cascades end with the first that holds the whole scene.
    assert_eq!(counts[1..], [6, 1, 6]);
    assert!((1..=4).contains(&counts[0]));
    let wide = &shadows.lights[3];
    let behind = &shadows.maps[wide.first_map + 4];
    assert_eq!(behind.area[2], 0, "a cone of 1.3 rad along -z has no map towards +z");
}

#[test]
fn what_is_seen_lies_in_a_map_clear_of_its_margin() {
    let mut random = Random::new(5);
    let mut compared = 0;
    for filter in [0, 2, 8] {
        let plan = planned(&lit(), &Request { shadow_filter: filter, ..request(Some(9)) });
        let shadows = plan.shadows.as_ref().expect("shadows");
        let reach = 0.5 * f64::from(filter + 1);
        for _ in 0..2000 {
            let at = DVec3::new(random.range(-2.0, 2.0), random.range(-2.0, 2.0), -2.0);
            let seen = plan.view.world_to_view.transform_point3(at);
            let clip = plan.view.view_to_clip() * seen.extend(1.0);
            if clip.w <= 0.0 || clip.x.abs() > clip.w || clip.y.abs() > clip.w {
                continue;
            }
            compared += 1;
            for light in &shadows.lights {
                let maps = &shadows.maps[light.first_map..light.first_map + light.map_count];
                let holds = |map: &Map| {
                    let clip = map.view_to_map * seen.extend(1.0);
                    let inset = 1.0 - 2.0 * reach / f64::from(shadows.size);
                    clip.w > 0.0 && (clip.x / clip.w).abs() < inset && (clip.y / clip.w).abs() < inset
                };
                let resolved = &plan.lighting.lights[light.light];
                let to_point = (at - resolved.position).normalize();
                let in_cone = resolved.cone(to_point.dot(resolved.direction)) > 0.0;
                let directional = resolved.kind == LightKind::Directional;
                if directional || in_cone {
                    assert!(maps.iter().any(|map| map.area[2] > 0 && holds(map)), "{:?} at {at}", resolved.kind);
                }
            }
        }
    }
    assert!(compared > 1000);
}

#[test]
fn maps_lie_beside_one_another_in_one_image() {
    let mut scene = builtin::load("atrium").expect("a built-in scene");
    scene.lights = scatter::point_lights(&scene.bounds(), 40, 1);
    let limits = Limits { max_image_dimension: 4096, ..Limits::UNLIMITED };
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
fn loops_over_lights_leave_room_for_those_of_shadows() {
    let plan = planned(&lit(), &request(Some(9)));
    let shadows = plan.shadows.expect("shadows");
    let left = shadows.leave(&Limits { max_loop_iterations: 65_535, ..Limits::UNLIMITED }).expect("room");
    assert!(left.max_loop_iterations < 65_535 - 4 * 12 && left.max_loop_iterations > 65_000);
    assert_eq!(shadows.leave(&Limits::UNLIMITED).expect("no limit").max_loop_iterations, u32::MAX);
    assert!(shadows.leave(&Limits { max_loop_iterations: 60, ..Limits::UNLIMITED }).is_err());
}
