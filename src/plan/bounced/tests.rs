use super::*;

/// A diagonal operator whose eigenvalues are known: the iteration leaves what it says at most.
#[test]
fn both_iterations_leave_what_their_bounds_say() {
    let (smallest, largest) = (-0.4, 0.9);
    let both = [Iteration::Chebyshev, Iteration::Neumann];
    for (iteration, count) in both.into_iter().flat_map(|way| [1, 2, 4, 8, 16].map(|count| (way, count))) {
        let steps = steps(iteration, smallest, largest, count);
        let bound = left_after(count, iteration, smallest, largest);
        for k in 0..=20 {
            let eigenvalue = smallest + (largest - smallest) * f64::from(k) / 20.0;
            let right = 1.0 / (1.0 - eigenvalue);
            let (mut now, mut before) = (0.0, 0.0);
            for [step, weight] in &steps {
                let gathered = 1.0 + eigenvalue * now;
                let next = f64::from(*weight) * ((now - before) + f64::from(*step) * (gathered - now)) + before;
                (before, now) = (now, next);
            }
            assert!((now - right).abs() <= bound * right * 1.001 + 1e-6, "{count} steps, {eigenvalue}: {now}");
        }
    }
}

/// R17: light that comes and goes leaves nothing behind but what the iteration's bound allows, and no gather grows it.
#[test]
fn r17_light_that_is_switched_off_decays() {
    let (smallest, largest) = (-0.3, 0.8);
    for iteration in [Iteration::Chebyshev, Iteration::Neumann] {
        for eigenvalue in [smallest, 0.1, largest] {
            let (mut now, mut before) = (1e4, 1e4);
            for [step, weight] in steps(iteration, smallest, largest, 12) {
                let next = f64::from(weight) * ((now - before) + f64::from(step) * (eigenvalue * now - now)) + before;
                (before, now) = (now, next);
            }
            let left = left_after(12, iteration, smallest, largest);
            assert!(now.is_finite() && now.abs() <= 1e4 * left * 1.001, "{eigenvalue}: {now}, {left}");
        }
    }
}

/// Of the box with walls that reflect so much of what they do.
fn planned(share: f32, tolerance: f64) -> Decision {
    let mut scene = crate::scene::builtin::load("cornell").expect("a built-in scene");
    for material in &mut scene.materials {
        (0..3).for_each(|c| material.base_color[c] *= share);
        material.emissive = [0.0; 3];
    }
    let settings =
        crate::radiosity::Settings { patches: crate::radiosity::bake::PatchRule::Count(60), ..Default::default() };
    let bake = Arc::new(Bake::of_scene(&scene, settings).expect("a bake"));
    let gathering = Gathering { tolerance, ..Gathering::default() };
    let request =
        Request { gi: Gi::Radiosity(gathering), bake: Some(bake), width: 32, height: 32, ..Request::default() };
    let plan = Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan");
    Bounced::new(&request, &plan.view, &plan.lighting, &Limits::MINIMUM).expect("a decision")
}

/// As few gathers as the tolerance asks for, none where nothing is reflected, and the number that decided in the sentence.
#[test]
fn gathers_are_as_few_as_the_scene_calls_for() {
    let (loose, _) = planned(1.0, 0.1);
    let (tight, why) = planned(1.0, 1e-3);
    let count = |of: &Option<Bounced>| of.as_ref().map_or(0, |bounced| bounced.steps.len());
    assert!(count(&loose) >= 1 && count(&tight) > count(&loose), "{} {}", count(&loose), count(&tight));
    assert!(why.contains("eigenvalues from") && why.contains("gathers"), "{why}");
    let (dark, _) = planned(0.05, Gathering::TOLERANCE);
    assert!(count(&dark) <= 2, "{}", count(&dark));
    let (none, why) = planned(0.005, Gathering::TOLERANCE);
    assert!(none.is_none() && why.contains("less than the tolerance"), "{why}");
}

/// Few points are looked at where little bounces, and those that are lie in strata of their own, others in the next patch.
#[test]
fn few_points_are_enough_for_little_light() {
    let enough: Vec<bool> = [0.9, 0.2, 0.05, 0.01].iter().map(|share| few_are_enough(*share, 0.005)).collect();
    assert_eq!(enough, [false, false, true, true]);
    assert!(!few_are_enough(0.05, 1e-6));
    let all: Vec<[glam::DVec3; 2]> = (0..2 * POINTS).map(|k| [glam::DVec3::X * f64::from(k); 2]).collect();
    let found: Vec<f64> = points(&all, FEW_POINTS).map(|point| point[0].x).collect();
    let strata: Vec<u32> = found.iter().map(|x| *x as u32 / (POINTS / FEW_POINTS)).collect();
    assert_eq!(strata, (0..2 * FEW_POINTS).collect::<Vec<_>>());
    assert_ne!(found[0] as u32 % POINTS, found[FEW_POINTS as usize] as u32 % POINTS);
    assert!(points(&all, POINTS).eq(all.iter()));
}

/// Few points were chosen since all light came from afar: a lamp is refused, and more sun is not.
#[test]
fn a_lamp_is_refused_where_few_points_were_planned() {
    let mut scene = crate::scene::builtin::load("cornell").expect("a built-in scene");
    for material in &mut scene.materials {
        (material.emissive, material.base_color) = ([0.0; 3], [0.04, 0.04, 0.04, 1.0]);
    }
    scene.lights.truncate(1);
    scene.lights[0].kind = LightKind::Directional;
    scene.lights[0].range = None;
    let bake = Arc::new(Bake::of_scene(&scene, crate::radiosity::Settings::of_count(60)).expect("a bake"));
    let gi = Gi::Radiosity(Gathering::default());
    let request = Request { gi, bake: Some(bake), lights_move: true, width: 32, height: 32, ..Request::default() };
    let plan = Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan");
    assert_eq!(plan.bounced.as_ref().map(|bounced| bounced.points_each), Some(FEW_POINTS));
    scene.lights[0].intensity *= 2.0;
    let plan = plan.relit(&scene, &request, &Limits::MINIMUM).expect("a plan of more light");
    scene.lights[0].kind = LightKind::Point;
    let said = plan.relit(&scene, &request, &Limits::MINIMUM).expect_err("a lamp").to_string();
    assert!(said.contains("lamp"), "{said}");
}
