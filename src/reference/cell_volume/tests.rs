use glam::DMat4;

use super::*;
use crate::math::random::Random;
use crate::scene::{Camera, Projection};

fn view(projection: Projection, width: u32, height: u32) -> View {
    let camera = Camera { name: "here".into(), camera_to_world: DMat4::IDENTITY, projection };
    View::new(&camera, width, height).expect("a good camera")
}

/// Four columns of 2 m and one row of 2 m about the axis.
fn flat() -> View {
    view(Projection::Orthographic { xmag: 4.0, ymag: 1.0, znear: 0.0, zfar: 10.0 }, 4, 1)
}

fn lens() -> View {
    view(Projection::Perspective { yfov: 1.1, aspect: None, znear: 0.05, zfar: None }, 160, 90)
}

fn distance(volume: &Volume, point: [f64; 3]) -> f64 {
    let point = DVec3::from_array(point);
    volume.closest(point).map_or(f64::INFINITY, |closest| closest.distance(point))
}

#[test]
fn distances_to_faces_edges_and_corners_are_those_by_hand() {
    let block = Volume::piece(&flat(), [1, 3], [0, 1], [4.0, 6.0]);
    for (point, expected) in [
        ([0.5, -0.5, -5.0], 0.0),
        ([5.0, 0.0, -5.0], 3.0),
        ([5.0, 5.0, -5.0], 5.0),
        ([4.0, 3.0, -3.0], 3.0),
        ([-4.0, -3.0, -7.0], 3.0),
        ([0.0, 0.0, 0.0], 4.0),
    ] {
        assert!((distance(&block, point) - expected).abs() < 1e-12, "{point:?}: {}", distance(&block, point));
    }
    let corner = DVec3::new(4.0, 3.0, -3.0);
    assert!(!block.touches(corner, 3.0 - 1e-9) && block.touches(corner, 3.0 + 1e-9));
    assert!(!block.touches(DVec3::new(5.0, 0.0, -5.0), 3.0), "touching is not meeting");
    let slab = block.within([0.0, 1.0], [-1.0, -0.5]);
    assert!((distance(&slab, [4.0, 3.5, -5.0]) - 5.0).abs() < 1e-12);
    let nothing = Volume::piece(&flat(), [1, 3], [0, 1], [4.0, 6.0]).within([5.0, 6.0], [-1.0, 1.0]);
    assert_eq!(nothing.closest(DVec3::ZERO), None);
    assert!(!nothing.touches(DVec3::new(3.0, 0.0, -5.0), 100.0));
}

#[test]
fn a_piece_without_an_end_goes_on() {
    let cone = Volume::piece(&lens(), [0, 160], [0, 90], [1.0, 1e18]);
    assert_eq!(distance(&cone, [0.0, 0.0, -1e9]), 0.0);
    assert!((distance(&cone, [0.0, 0.0, 3.0]) - 4.0).abs() < 1e-12);
    assert!(cone.touches(DVec3::new(0.0, 0.0, -1e6), 1e-3));
}

/// A tile's piece, and one cut to a part of the box round it.
fn random_volumes(view: &View, random: &mut Random) -> [Volume; 2] {
    let pick = |random: &mut Random, most: u32| (random.unit_f64() * f64::from(most)) as u32;
    let (x, y) = (pick(random, view.width - 16), pick(random, view.height - 16));
    let (columns, rows) = ([x, x + 16], [y, y + 16]);
    let near = random.range(0.1, 5.0);
    // Flat ones too.
    let far = near * [1.0, 1.01, 1.5, 6.0][pick(random, 4) as usize];
    let piece = Volume::piece(view, columns, rows, [near, far]);
    let [low, high] = extent(view, columns, rows, [near, far]);
    let mut part = |low: f64, high: f64| {
        let (a, b) = (random.range(low, high), random.range(low, high));
        if random.unit_f64() < 0.3 { [low, high] } else { [a.min(b), a.max(b)] }
    };
    let (across, up) = (part(low.x, high.x), part(low.y, high.y));
    [piece.clone(), piece.within(across, up)]
}

/// Points of a volume, by trying.
fn points_within(volume: &Volume, random: &mut Random) -> Vec<DVec3> {
    let mut points = Vec::new();
    for _ in 0..400 {
        let point = DVec3::from_array([0, 1, 2].map(|i: usize| random.range(volume.low[i], volume.high[i])));
        if volume.planes.iter().all(|plane| plane.excess(point) <= 0.0) {
            points.push(point);
        }
    }
    points
}

/// p is the closest point of a convex set to c where the plane through p across c - p has the whole set behind it.
fn check_closest(volume: &Volume, center: DVec3, samples: &[DVec3]) {
    let size = center.abs().max_element().max(volume.low.abs().max_element()).max(volume.high.abs().max_element());
    let Some(closest) = volume.closest(center) else {
        assert!(samples.is_empty(), "{volume:?} is not empty");
        return;
    };
    for plane in &volume.planes {
        assert!(plane.excess(closest) <= 2e-12 * size, "{closest} lies outside of {plane:?}");
    }
    let away = center - closest;
    for sample in samples {
        let past = away.dot(*sample - closest);
        assert!(past <= 1e-12 * size * size, "{sample} is closer to {center} than {closest}: {past:e}");
        assert!(sample.distance(center) >= away.length() - 1e-12 * size);
    }
}

#[test]
fn no_sampled_point_is_closer() {
    let mut random = Random::new(7);
    let mut sampled = 0;
    for view in [lens(), view(Projection::Orthographic { xmag: 5.0, ymag: -3.0, znear: -1.0, zfar: 20.0 }, 160, 90)] {
        for _ in 0..300 {
            for volume in random_volumes(&view, &mut random) {
                let samples = points_within(&volume, &mut random);
                sampled += samples.len();
                let middle = (volume.low + volume.high) * 0.5;
                for reach in [0.1, 1.0, 30.0] {
                    let mut off = || random.range(-reach, reach);
                    let center = middle + DVec3::new(off(), off(), off());
                    check_closest(&volume, center, &samples);
                }
            }
        }
    }
    assert!(sampled > 10_000, "only {sampled} points");
}

#[test]
fn the_eight_corners_of_a_piece_prove_its_closest_point() {
    let (view, mut random) = (lens(), Random::new(8));
    for _ in 0..2000 {
        let [piece, _] = random_volumes(&view, &mut random);
        let (near, far) = (-piece.high.z, -piece.low.z);
        // Each side plane is x = t d, or y = t d: its normal is along (1, -t) of that axis and the view's.
        let tangent = |index: usize, axis: usize| piece.planes[index].normal.z / piece.planes[index].normal[axis];
        let mut corners = Vec::new();
        for (x, y) in [(0, 2), (0, 3), (1, 2), (1, 3)].map(|(i, j)| (tangent(i, 0), tangent(j, 1))) {
            corners.extend([near, far].map(|d| DVec3::new(x, y, -1.0) * d));
        }
        let mut off = || random.range(-6.0, 6.0);
        let center = DVec3::new(off(), off(), off());
        check_closest(&piece, center, &corners);
    }
}

#[test]
fn pairs_are_counted_by_cell() {
    let view = flat();
    let cell = |column: u32| vec![Volume::piece(&view, [column, column + 1], [0, 1], [4.0, 6.0])];
    let light = |kind, x: f64, range| ResolvedLight {
        kind,
        position: DVec3::new(x, 0.0, -5.0),
        direction: DVec3::NEG_Z,
        intensity: DVec3::ONE,
        range,
        shadow: false,
    };
    let point = LightKind::Point;
    // Columns are cells of 2 m from x = -4 on; the last one is known to hold nothing.
    let lights = [light(LightKind::Directional, 0.0, f64::INFINITY), light(point, -3.0, 0.5), light(point, 0.0, 0.5)];
    let cells = [cell(0), cell(1), cell(2), Vec::new()];
    let counted = |offsets: &[u32], lights_of: &[u32]| {
        count(&cells, &Lists { cell_of_sample: &[], offsets, lights: lights_of }, &lights, &view)
    };
    let exact = counted(&[0, 1, 2, 3, 3], &[1, 2, 2]);
    assert_eq!(exact, VolumeCounts { listed: 3, touching: 3, unlisted: 0 });
    let wasteful = counted(&[0, 2, 4, 5, 7], &[1, 2, 1, 2, 2, 1, 2]);
    assert_eq!((wasteful.listed, wasteful.touching, wasteful.unlisted), (5, 3, 0));
    assert!((wasteful.waste() - 5.0 / 3.0).abs() < 1e-15);
    assert_eq!(counted(&[0, 1, 1, 2, 2], &[1, 2]).unlisted, 1);
    assert_eq!((VolumeCounts::default().waste(), counted(&[0; 5], &[]).unlisted), (1.0, 3));
}
