//! Two oracles in f64 that share no formula with the code: roots of the condition that a line through the eye lies a radius from the
//! centre, and a search over slices of equal distance.

use glam::DMat4;

use super::*;
use crate::math::random::Random;
use crate::scene::view::Extents;

const NEAR: f64 = 0.05;
const SIZE: [f64; 2] = [1280.0, 720.0];

fn view_through(lens: Lens) -> View {
    View {
        name: String::new(),
        world_to_view: DMat4::IDENTITY,
        lens,
        znear: NEAR,
        zfar: None,
        width: SIZE[0] as u32,
        height: SIZE[1] as u32,
    }
}

fn perspective(left: f64, right: f64, bottom: f64, top: f64) -> View {
    view_through(Lens::Perspective(Extents { left, right, bottom, top }))
}

fn symmetric() -> View {
    let top = 30f64.to_radians().tan();
    perspective(-top * 16.0 / 9.0, top * 16.0 / 9.0, -top, top)
}

/// Symmetric, off-centre, mirrored both ways with the centre outside, orthographic with planes on both sides.
fn views() -> [View; 4] {
    let flat = Lens::Orthographic(Extents { left: -14.0, right: 18.0, bottom: 9.0, top: -9.0 });
    let orthographic = View { znear: -3.0, zfar: Some(60.0), ..view_through(flat) };
    [symmetric(), perspective(-0.2, 1.1, -0.7, 0.1), perspective(1.9, 0.1, 0.8, -0.5), orthographic]
}

/// Least and greatest across / ahead of the disc's part beyond `near`; None where it has none.
fn extremes(across: f64, ahead: f64, radius: f64, near: f64) -> Option<[f64; 2]> {
    let mut found: Option<[f64; 2]> = None;
    let mut meet = |slope: f64| {
        let [low, high] = found.unwrap_or([slope; 2]);
        found = Some([low.min(slope), high.max(slope)]);
    };
    // (c - u a)^2 = r^2 (1 + u^2), its discriminant free of cancellation.
    let (long, short) = (across.abs().max(ahead.abs()), across.abs().min(ahead.abs()));
    let power = (long - radius) * (long + radius) + short * short;
    if power >= 0.0 {
        let half = across * ahead + (radius * power.sqrt()).copysign(across * ahead);
        let roots = [half / ((ahead - radius) * (ahead + radius)), (across - radius) * (across + radius) / half];
        roots.into_iter().filter(|u| (across * u + ahead) / (1.0 + u * u) >= near).for_each(&mut meet);
    }
    let chord = (radius - (near - ahead)) * (radius + (near - ahead));
    if chord >= 0.0 && ahead + radius >= near {
        meet((across - chord.sqrt()) / near);
        meet((across + chord.sqrt()) / near);
    }
    found
}

/// Greatest across / ahead, by golden-section search: the greatest `across` of a slice is concave in its distance, so the quotient has
/// one maximum.
fn searched(across: f64, ahead: f64, radius: f64, near: f64) -> f64 {
    let slope = |s: f64| {
        let chord = (radius - (s - ahead)) * (radius + (s - ahead));
        (across + chord.max(0.0).sqrt()) / s
    };
    let (mut low, mut high) = (near.max(ahead - radius), ahead + radius);
    let mut best = slope(low).max(slope(high));
    for _ in 0..120 {
        let step = (high - low) * 0.618_033_988_749_894_9;
        let (left, right) = (high - step, low + step);
        best = best.max(slope(left)).max(slope(right));
        if slope(left) < slope(right) {
            low = left;
        } else {
            high = right;
        }
    }
    best
}

/// Unclamped pixels per axis, low before high.
fn exact(center: DVec3, radius: f64, view: &View) -> Option<[[f64; 2]; 2]> {
    let range = |across: f64| match view.lens {
        Lens::Perspective(_) => extremes(across, -center.z, radius, view.znear),
        Lens::Orthographic(_) => {
            let gap = (view.znear + center.z).max(-center.z - view.zfar?).max(0.0);
            let half = ((radius - gap) * (radius + gap)).sqrt();
            (radius >= gap).then_some([across - half, across + half])
        }
    };
    let e = view.lens.extents();
    let pixels = |u: [f64; 2], first: f64, last: f64, size: f64| {
        let [a, b] = u.map(|u| (u - first) / (last - first) * size);
        [a.min(b), a.max(b)]
    };
    Some([pixels(range(center.x)?, e.left, e.right, SIZE[0]), pixels(range(center.y)?, e.top, e.bottom, SIZE[1])])
}

/// The part in the picture; None where there is none.
fn visible(center: DVec3, radius: f64, view: &View) -> Option<[[f64; 2]; 2]> {
    let ranges = exact(center, radius, view)?;
    let inside = ranges.iter().zip(SIZE).all(|([low, high], size)| *low <= size && *high >= 0.0);
    inside.then(|| [0, 1].map(|axis| [ranges[axis][0].max(0.0), ranges[axis][1].min(SIZE[axis])]))
}

/// Pixels by which `rect` falls short of `exact`, and pixels beyond a thousandth of its size by which it passes it.
fn compare(rect: Option<PixelRect>, exact: [[f64; 2]; 2]) -> (f64, f64) {
    let Some(rect) = rect else { return (f64::INFINITY, 0.0) };
    let (mut short, mut loose) = (0f64, 0f64);
    for (found, exact) in [rect.x, rect.y].into_iter().zip(exact) {
        let [low, high] = found.map(f64::from);
        let allowed = 1e-3 * (exact[1] - exact[0]);
        short = short.max(low - exact[0]).max(exact[1] - high);
        loose = loose.max(exact[0] - low - allowed).max(high - exact[1] - allowed);
    }
    (short, loose)
}

fn power_of_ten(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(random.range(low, high))
}

fn direction(random: &mut Random) -> DVec3 {
    loop {
        let point = DVec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)));
        if point.length_squared() > 1e-3 && point.length_squared() <= 1.0 {
            return point.normalize();
        }
    }
}

/// Kind 0: ordinary. 1: any radius, the eye from a billionth of it to a thousand times it outside. 2: nearly touching the near plane from
/// either side. 3: far and tiny.
fn sphere(kind: usize, random: &mut Random) -> (DVec3, f64) {
    match kind {
        0 => {
            let center = DVec3::new(random.range(-40.0, 40.0), random.range(-30.0, 30.0), random.range(-50.0, 30.0));
            (center, power_of_ten(random, -2.0, 1.0))
        }
        1 => {
            let radius = power_of_ten(random, -6.0, 9.0);
            (direction(random) * radius * (1.0 + power_of_ten(random, -9.0, 3.0)), radius)
        }
        2 => {
            let radius = power_of_ten(random, -6.0, 9.0);
            let side = if random.unit_f64() < 0.5 { 1.0 } else { -1.0 };
            let ahead = NEAR - side * radius * (1.0 - power_of_ten(random, -12.0, 0.0));
            (DVec3::new(random.range(-3.0, 3.0) * radius, random.range(-3.0, 3.0) * radius, -ahead), radius)
        }
        _ => {
            let center = DVec3::new(random.range(-1.2, 1.2), random.range(-0.8, 0.8), -1.0);
            (center * power_of_ten(random, -1.0, 7.0), power_of_ten(random, -6.0, -3.0))
        }
    }
}

/// A sphere whose centre is `ratio` radii ahead of the eye (behind it where negative), aside of it by 1 to 3 radii.
fn beside(ratio: f64, random: &mut Random) -> (DVec3, f64) {
    let radius = power_of_ten(random, -1.0, 2.0);
    let (sine, cosine) = random.range(0.0, std::f64::consts::TAU).sin_cos();
    let aside = radius * random.range(1.0, 3.0);
    (DVec3::new(aside * cosine, aside * sine, -ratio * radius), radius)
}

fn eye_inside(center: DVec3, radius: f64) -> bool {
    center.length() <= radius * (1.0 + f64::from(f32::EPSILON))
}

#[test]
fn rectangles_contain_the_exact_ones_of_random_spheres_and_seldom_more() {
    let mut random = Random::new(1);
    for (lens, view) in views().iter().enumerate() {
        let (mut ordinary, mut loose) = (0usize, 0usize);
        for index in 0..25_000 {
            let (center, radius) = sphere(index % 4, &mut random);
            let Some(exact) = visible(center, radius, view) else { continue };
            let (short, over) = compare(tangent_rectangle(center, radius, view), exact);
            assert!(short <= 0.0, "lens {lens}: {center} radius {radius}: {short} pixels lost");
            if index % 4 == 0 && !eye_inside(center, radius) {
                ordinary += 1;
                loose += usize::from(over > 1.0);
            }
        }
        assert!(ordinary > 300, "lens {lens}: {ordinary} visible");
        assert!(loose * 1000 <= ordinary, "lens {lens}: {loose} of {ordinary} more than a pixel too large");
    }
}

#[test]
fn the_closed_oracle_is_what_a_search_finds() {
    let mut random = Random::new(2);
    let mut seen = 0;
    for index in 0..4000 {
        let (center, radius) = sphere([0, 2][index % 2], &mut random);
        if !(1e-3..1e3).contains(&radius) || radius - center.z < NEAR + 1e-9 {
            continue;
        }
        let Some([low, high]) = extremes(center.x, -center.z, radius, NEAR) else {
            panic!("{center} radius {radius} is visible")
        };
        let found = [-searched(-center.x, -center.z, radius, NEAR), searched(center.x, -center.z, radius, NEAR)];
        for (closed, found) in [low, high].into_iter().zip(found) {
            assert!((closed - found).abs() <= 1e-8 * (1.0 + closed.abs()), "{center} {radius}: {closed} {found}");
        }
        seen += 1;
    }
    assert!(seen > 1500, "{seen} spheres");
}

#[test]
fn p1_every_ratio_of_depth_to_radius_is_contained() {
    let (view, mut random) = (symmetric(), Random::new(3));
    for step in 0..200 {
        let ratio = 10f64.powf(-8.0 + 13.0 * f64::from(step) / 199.0);
        for ratio in [ratio, -ratio] {
            let (mut seen, mut loose) = (0usize, 0usize);
            for _ in 0..120 {
                let (center, radius) = beside(ratio, &mut random);
                let Some(exact) = visible(center, radius, &view) else { continue };
                let (short, over) = compare(tangent_rectangle(center, radius, &view), exact);
                assert!(short <= 0.0, "ratio {ratio}: {center} radius {radius}: {short} pixels lost");
                seen += 1;
                loose += usize::from(over > 1.0 && !eye_inside(center, radius));
            }
            assert!(seen > 0 || ratio < -0.25, "ratio {ratio}: nothing visible");
            assert!(loose <= 2, "ratio {ratio}: {loose} of {seen} more than a pixel too large");
        }
    }
}

/// Shares of the visible lights of which the textbook form loses more than a pixel, and all.
fn textbook_losses(low: f64, high: f64, random: &mut Random) -> [f64; 2] {
    let view = symmetric();
    let (mut seen, mut lost, mut all) = (0usize, 0usize, 0usize);
    for _ in 0..20_000 {
        let ratio = power_of_ten(random, low, high);
        let (center, radius) = beside(ratio, random);
        let Some(exact) = visible(center, radius, &view).filter(|_| !eye_inside(center, radius)) else { continue };
        let rect = textbook_rectangle(center.as_vec3(), radius as f32, &view);
        seen += 1;
        lost += usize::from(compare(rect, exact).0 > 1.0);
        all += usize::from(rect.is_none());
    }
    [lost, all].map(|count| count as f64 / seen as f64)
}

#[test]
fn p1_the_textbook_form_loses_lights() {
    let mut random = Random::new(4);
    // A numpy float32 copy, 90,000 visible lights a ratio: 13 % wholly lost up to 1e-4; at 3e-4, 1e-3, 3e-3, 1e-2 and 3e-2 more than
    // a pixel of 20, 37, 31, 2 and 0.01 %; none from 0.1 on, apart from L_z = r exactly.
    let [_, all] = textbook_losses(-8.0, -4.0, &mut random);
    assert!((0.05..0.25).contains(&all), "{all} of the lights gone under 1e-4");
    let [lost, _] = textbook_losses(-4.0, -1.5, &mut random);
    assert!((0.05..0.4).contains(&lost), "{lost} of the lights cut under 0.03");
    let [lost, _] = textbook_losses(0.05, 2.0, &mut random);
    assert!(lost < 0.002, "{lost} of the lights cut where the form is sound");
}

#[test]
fn p2_the_near_plane_cuts_the_sphere() {
    let view = symmetric();
    // The tangent would be at slope 0.2041; the chord of half-width 0.01 at 0.05 ends at 0.2.
    let rect = tangent_rectangle(DVec3::new(0.0, 0.0, -NEAR), 0.01, &view).expect("it is in front");
    let half = (640.0 * 0.2 / view.lens.extents().right) as f32;
    assert!((rect.x[0] - (640.0 - half)).abs() < 0.01 && (rect.x[1] - (640.0 + half)).abs() < 0.01, "{rect:?}");
    let touching = DVec3::new(0.0, 0.0, 1.0 - NEAR);
    assert!(tangent_rectangle(touching, 1.0, &view).is_some());
    assert!(tangent_rectangle(touching, 0.999, &view).is_none());
}

#[test]
fn p3_the_eye_inside_or_on_the_surface_sees_it_everywhere() {
    let whole = Some(PixelRect { x: [0.0, 1280.0], y: [0.0, 720.0] });
    let mut random = Random::new(5);
    for view in &views()[..3] {
        for _ in 0..500 {
            let (mut toward, radius) = (direction(&mut random), power_of_ten(&mut random, 0.0, 9.0));
            toward.z = -toward.z.abs();
            for scale in [0.5, 1.0 - f64::EPSILON, 1.0, 1.0 + f64::EPSILON, 1.0 + f64::from(f32::EPSILON) * 0.5] {
                assert_eq!(
                    tangent_rectangle(toward * radius * scale, radius, view),
                    whole,
                    "{toward} {radius} {scale}"
                );
            }
        }
        assert_eq!(tangent_rectangle(DVec3::new(0.0, 3.0, 1.0), f64::INFINITY, view), whole);
    }
}

#[test]
fn p4_a_centre_behind_the_eye_shows_only_what_reaches_in_front() {
    let view = symmetric();
    let center = DVec3::new(3.0, 0.0, 1.0);
    let rect = tangent_rectangle(center, 3.1, &view).expect("it reaches 2.1 m ahead");
    let left = exact(center, 3.1, &view).expect("the oracle sees it")[0][0];
    assert!(left > 900.0 && (f64::from(rect.x[0]) - left).abs() < 0.01 && rect.x[1] == 1280.0, "{rect:?}, {left}");
    assert_eq!(tangent_rectangle(center, 1.04, &view), None);
    assert_eq!(distance_range(center, 3.1, &view).map(|range| range[0]), Some(rounded_down(NEAR)));
}

#[test]
fn p5_any_radius_gives_a_closed_rectangle_inside_the_picture() {
    for view in &views() {
        for exponent in -6..=9 {
            for distance in [0.06, 1.0, 30.0] {
                let center = DVec3::new(0.5, -0.2, -1.0) * distance;
                let radius = 10f64.powi(exponent);
                let Some(rect) = tangent_rectangle(center, radius, view) else { panic!("{center} radius {radius}") };
                for ([low, high], size) in [(rect.x, 1280.0), (rect.y, 720.0)] {
                    assert!((0.0..=high).contains(&low) && high <= size, "{center} radius {radius}: {rect:?}");
                }
                let [x0, x1, y0, y1] = rectangle_tiles(&rect, 16, 80, 45);
                assert!((x0..80).contains(&x1) && (y0..45).contains(&y1));
            }
        }
    }
}

#[test]
fn p6_a_sphere_beyond_an_edge_is_gone_and_one_across_it_stays() {
    for view in &views()[..3] {
        let e = view.lens.extents();
        let middle = [e.left + e.right, e.top + e.bottom].map(|sum| sum * 0.5);
        for (axis, edges) in [[e.left, e.right], [e.top, e.bottom]].into_iter().enumerate() {
            for edge in edges {
                let outward = (edge - middle[axis]).signum() / (1.0 + edge * edge).sqrt();
                for (ahead, radius) in [(1.0, 0.3), (10.0, 5.0), (1000.0, 20.0)] {
                    let place = |from_edge: f64| {
                        let mut slope = middle;
                        slope[axis] = 0.0;
                        let mut center = DVec3::new(slope[0] * ahead, slope[1] * ahead, -ahead);
                        center[axis] = edge * ahead + from_edge * outward;
                        center.z += from_edge * outward * edge;
                        center
                    };
                    assert_eq!(tangent_rectangle(place(radius * 1.001), radius, view), None, "axis {axis}, {edge}");
                    assert!(tangent_rectangle(place(radius * 0.999), radius, view).is_some(), "axis {axis}, {edge}");
                }
            }
        }
    }
}

#[test]
fn p7_a_mirrored_lens_mirrors_the_rectangle() {
    let (straight, mirrored) = (perspective(-0.2, 1.1, -0.7, 0.1), perspective(1.1, -0.2, -0.7, 0.1));
    let rect = tangent_rectangle(DVec3::new(1.5, -1.0, -4.0), 0.5, &straight).expect("visible");
    let other = tangent_rectangle(DVec3::new(1.5, -1.0, -4.0), 0.5, &mirrored).expect("visible");
    assert!((rect.x[0] - (1280.0 - other.x[1])).abs() < 0.01 && (rect.x[1] - (1280.0 - other.x[0])).abs() < 0.01);
    assert_eq!(rect.y, other.y);
}

#[test]
fn distances_are_those_between_the_planes() {
    let view = View { zfar: Some(100.0), ..symmetric() };
    let at = |ahead: f64, radius: f64| distance_range(DVec3::new(5.0, 0.0, -ahead), radius, &view);
    assert_eq!(at(10.0, 20.0).map(|range| range[1]), Some(30f32.next_up()));
    assert_eq!(at(95.0, 20.0).map(|range| range[1]), Some(100.0));
    assert_eq!(at(0.0, f64::INFINITY), Some([rounded_down(NEAR), 100.0]));
    assert!([at(-1.0, 1.0), at(121.0, 20.0), at(50.0, -1.0)].iter().all(Option::is_none));
    let third = at(10.0, 1.0 / 3.0).expect("between the planes").map(f64::from);
    assert!(third[0] < 10.0 - 1.0 / 3.0 && third[1] > 10.0 + 1.0 / 3.0 && third[1] - third[0] < 0.66667);
}

#[test]
fn a_rectangle_owns_both_tiles_of_an_edge_it_touches() {
    let tiles = |x: [f32; 2]| rectangle_tiles(&PixelRect { x, y: [0.0, 720.0] }, 16, 80, 45);
    assert_eq!(tiles([16.0, 16.0]), [0, 1, 0, 44]);
    assert_eq!(tiles([16f32.next_up(), 32f32.next_down()]), [1, 1, 0, 44]);
    assert_eq!(tiles([0.0, 1e-40]), [0, 0, 0, 44]);
    assert_eq!(tiles([1280.0, 1280.0]), [79, 79, 0, 44]);
}
