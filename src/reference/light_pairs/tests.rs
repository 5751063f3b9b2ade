//! The oracle against counts by hand, and against asking every light for every sample.

use std::collections::BTreeSet;

use glam::DMat4;

use super::*;
use crate::math::random::Random;
use crate::scene::view::Extents;
use crate::scene::{Camera, Projection};

/// Lists that own their memory.
struct Owned {
    cell_of_sample: Vec<u32>,
    offsets: Vec<u32>,
    lights: Vec<u32>,
}

impl Owned {
    fn new(cell_of_sample: &[u32], lists: &[Vec<u32>]) -> Self {
        let mut offsets = vec![0];
        for list in lists {
            offsets.push(offsets[offsets.len() - 1] + list.len() as u32);
        }
        Self { cell_of_sample: cell_of_sample.to_vec(), offsets, lights: lists.concat() }
    }

    fn lists(&self) -> Lists<'_> {
        Lists { cell_of_sample: &self.cell_of_sample, offsets: &self.offsets, lights: &self.lights }
    }
}

fn light(kind: LightKind, position: DVec3, range: f64) -> ResolvedLight {
    ResolvedLight { kind, position, direction: DVec3::NEG_Z, intensity: DVec3::ONE, range, shadow: false }
}

fn point(x: f64, range: f64) -> ResolvedLight {
    light(LightKind::Point, DVec3::new(x, 0.0, -5.0), range)
}

fn view(projection: Projection, width: u32, height: u32) -> View {
    let camera = Camera { name: "test".into(), camera_to_world: DMat4::IDENTITY, projection };
    View::new(&camera, width, height).expect("a good camera")
}

/// Four pixels whose samples of depth 0.5 lie at x = -3, -1, 1, 3 and z = -5.
fn row() -> View {
    view(Projection::Orthographic { xmag: 4.0, ymag: 1.0, znear: 0.0, zfar: 10.0 }, 4, 1)
}

fn row_lights() -> Vec<ResolvedLight> {
    let sun = light(LightKind::Directional, DVec3::ZERO, f64::INFINITY);
    vec![point(-3.0, 0.5), sun, point(0.0, 1.5), point(2.0, 1.5)]
}

/// The last pixel is sky, although a cell claims it.
const ROW_DEPTH: [f32; 4] = [0.5, 0.5, 0.5, 0.0];
const ROW_CELLS: [u32; 4] = [0, 0, 1, 1];

#[test]
fn counts_of_a_row_are_those_counted_by_hand() {
    let lists = Owned::new(&ROW_CELLS, &[vec![0, 2, 3], vec![2, 3], vec![0]]);
    let counts = Oracle::new(&row_lights(), &row()).count(&ROW_DEPTH, &lists.lists());
    let expected = PairCounts {
        samples: 3,
        exact_pairs: 4,
        listed_pairs: 8,
        missed_pairs: 0,
        listed_cells: 5,
        reached_cells: 4,
        longest_list: 3,
        unordered: 0,
        foreign: 0,
        lights_of_sample: vec![1, 1, 2, 0],
        missed_of_sample: vec![0; 4],
        listed_of_sample: vec![3, 3, 2, 0],
    };
    assert_eq!(counts, expected);
    assert_eq!((counts.waste_samples(), counts.waste_cells()), (2.0, 1.25));
}

#[test]
fn a_removed_id_is_missed_in_exactly_its_pairs() {
    let oracle = Oracle::new(&row_lights(), &row());
    let missed = |lists: [Vec<u32>; 2]| {
        let counts = oracle.count(&ROW_DEPTH, &Owned::new(&ROW_CELLS, &lists).lists());
        assert_eq!(counts.missed_pairs, counts.missed_of_sample.iter().map(|n| u64::from(*n)).sum::<u64>());
        counts.missed_of_sample
    };
    assert_eq!(missed([vec![0, 2], vec![2, 3]]), [0, 0, 0, 0]);
    assert_eq!(missed([vec![2], vec![2, 3]]), [1, 0, 0, 0]);
    assert_eq!(missed([vec![0], vec![2, 3]]), [0, 1, 0, 0]);
    assert_eq!(missed([vec![0, 2], vec![3]]), [0, 0, 1, 0]);
    assert_eq!(missed([vec![0, 2], vec![]]), [0, 0, 2, 0]);
}

#[test]
fn lists_out_of_order_or_with_strangers_are_told() {
    let oracle = Oracle::new(&row_lights(), &row());
    let form = |list: &[u32]| {
        let counts = oracle.count(&ROW_DEPTH, &Owned::new(&ROW_CELLS, &[list.to_vec(), vec![2, 3]]).lists());
        assert_eq!(counts.missed_pairs, 0);
        (counts.unordered, counts.foreign)
    };
    assert_eq!(form(&[0, 2]), (0, 0));
    assert_eq!(form(&[2, 0]), (1, 0));
    assert_eq!(form(&[0, 2, 2]), (1, 0));
    // The directional light, and one that is not there.
    assert_eq!(form(&[0, 1, 2, 4]), (0, 2));
}

#[test]
fn what_lists_lack_is_missed() {
    let oracle = Oracle::new(&row_lights(), &row());
    let missed = |lists: &Lists| {
        let counts = oracle.count(&ROW_DEPTH, lists);
        (counts.missed_pairs, counts.reached_cells, counts.listed_pairs)
    };
    let none = Lists { cell_of_sample: &[], offsets: &[], lights: &[] };
    assert_eq!(missed(&none), (4, 0, 0));
    assert_eq!(missed(&Lists { cell_of_sample: &[NO_CELL; 4], offsets: &[0, 2], lights: &[0, 2] }), (4, 0, 0));
    assert_eq!(missed(&Lists { cell_of_sample: &ROW_CELLS, offsets: &[0, 2], lights: &[0, 2] }), (2, 4, 4));
    assert_eq!(missed(&Lists { cell_of_sample: &ROW_CELLS, offsets: &[0, 9, 3], lights: &[0, 2] }), (4, 4, 0));
}

#[test]
fn no_light_and_no_sample_waste_nothing() {
    let empty = Owned::new(&ROW_CELLS, &[vec![], vec![]]);
    let counts = Oracle::new(&[], &row()).count(&ROW_DEPTH, &empty.lists());
    assert_eq!((counts.samples, counts.exact_pairs, counts.waste_samples(), counts.waste_cells()), (3, 0, 1.0, 1.0));
    let listed = Owned::new(&ROW_CELLS, &[vec![0], vec![]]);
    let counts = Oracle::new(&[point(100.0, 1.0)], &row()).count(&ROW_DEPTH, &listed.lists());
    assert_eq!((counts.waste_samples(), counts.waste_cells()), (f64::INFINITY, f64::INFINITY));
    let sky = Oracle::new(&row_lights(), &row()).count(&[0.0; 4], &listed.lists());
    assert_eq!((sky.samples, sky.listed_pairs, sky.listed_cells, sky.longest_list), (0, 0, 0, 1));
}

#[test]
fn the_range_itself_is_out_of_reach() {
    let reaching = |range: f64| Oracle::new(&[point(0.0, range)], &row()).reaching(DVec3::new(1.0, 0.0, -5.0)).len();
    assert_eq!([0.0, 1.0 - f64::EPSILON, 1.0, 1.0 + f64::EPSILON, f64::INFINITY].map(reaching), [0, 0, 0, 1, 1]);
}

#[test]
fn a_cone_reaches_what_lies_inside_it() {
    // From 2 m before the row the samples lie at atan(1/2) = 0.464 and atan(3/2) = 0.983 rad.
    let pairs = |outer: f32| {
        let spot = light(LightKind::Spot { inner: 0.0, outer }, DVec3::new(0.0, 0.0, -3.0), f64::INFINITY);
        let lists = Lists { cell_of_sample: &[], offsets: &[], lights: &[] };
        Oracle::new(&[spot], &row()).count(&[0.5; 4], &lists).lights_of_sample
    };
    assert_eq!(pairs(0.46), [0, 0, 0, 0]);
    assert_eq!(pairs(0.47), [0, 1, 1, 0]);
    assert_eq!(pairs(0.98), [0, 1, 1, 0]);
    assert_eq!(pairs(0.99), [1, 1, 1, 1]);
    let closed = light(LightKind::Spot { inner: 0.0, outer: 0.0 }, DVec3::ZERO, 9.0);
    assert!(Oracle::new(&[closed], &row()).reaching(DVec3::new(0.0, 0.0, -5.0)).is_empty());
}

#[test]
fn positions_come_back_through_the_projection() {
    let perspective = |zfar| Projection::Perspective { yfov: 1.0, aspect: None, znear: 0.1, zfar };
    let orthographic = Projection::Orthographic { xmag: 3.0, ymag: -2.0, znear: -5.0, zfar: 10.0 };
    let off_centre = Extents { left: -0.3, right: 0.9, bottom: -0.2, top: 0.5 };
    for (projection, perspective) in [(perspective(None), true), (perspective(Some(20.0)), true), (orthographic, false)]
    {
        let centred = view(projection, 9, 5);
        let lens = if perspective { Lens::Perspective(off_centre) } else { Lens::Orthographic(off_centre) };
        for view in [View { lens, ..centred.clone() }, centred] {
            for (x, y, depth) in [(0, 0, 1.0), (8, 4, 0.7), (3, 1, 1e-3), (5, 4, 1e-6f32)] {
                let position = Oracle::position(&view, x, y, depth).expect("a surface");
                let clip = view.view_to_clip() * position.extend(1.0);
                let found = clip.truncate() / clip.w;
                let centre = |pixel: u32, size: u32| (f64::from(pixel) + 0.5) / f64::from(size) * 2.0 - 1.0;
                let expected = DVec3::new(centre(x, 9), centre(y, 5), f64::from(depth));
                assert!((found - expected).abs().max_element() < 1e-12, "{view:?}: {found} is not {expected}");
                assert!((found.z / expected.z - 1.0).abs() < 1e-8, "{view:?}: {found} is not {expected}");
            }
            assert!([0.0, -0.0, -1.0, f32::NAN, f32::INFINITY].map(|d| Oracle::position(&view, 1, 1, d)) == [None; 5]);
        }
    }
}

fn direction(random: &mut Random) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| random.range(-1.0, 1.0))).try_normalize().unwrap_or(DVec3::X)
}

/// Every kind and four decades of range.
fn mixed_lights(random: &mut Random, count: usize) -> Vec<ResolvedLight> {
    let mut one = |id: usize| {
        let outer = random.range(0.05, 3.0) as f32;
        let kind = match id % 8 {
            0 => LightKind::Directional,
            1..=3 => LightKind::Spot { inner: outer * 0.5, outer },
            _ => LightKind::Point,
        };
        let unbounded = kind == LightKind::Directional || id % 31 == 5;
        let range = if unbounded { f64::INFINITY } else { 10f64.powf(random.range(-2.0, 2.0)) };
        let position = DVec3::from_array([0; 3].map(|_| random.range(-6.0, 6.0)));
        ResolvedLight { kind, position, direction: direction(random), intensity: DVec3::ONE, range, shadow: false }
    };
    (0..count).map(&mut one).collect()
}

/// Straight from the definition.
fn reaches(light: &ResolvedLight, view: &View, position: DVec3) -> bool {
    let away = position - view.world_to_view.transform_point3(light.position);
    let axis = view.world_to_view.transform_vector3(light.direction);
    let standing = light.kind != LightKind::Directional;
    standing && away.length() < light.range && light.cone(away.normalize().dot(axis)) > 0.0
}

fn ask_every_light(lights: &[ResolvedLight], view: &View, depth: &[f32], owned: &Owned) -> PairCounts {
    let nothing = vec![0; depth.len()];
    let mut counts = PairCounts {
        lights_of_sample: nothing.clone(),
        missed_of_sample: nothing.clone(),
        listed_of_sample: nothing,
        ..PairCounts::default()
    };
    let list_of = |cell: u32| {
        let [from, to] = [0, 1].map(|k| owned.offsets[cell as usize + k] as usize);
        &owned.lights[from..to]
    };
    let mut reached = BTreeSet::new();
    let mut owners = BTreeSet::new();
    for (pixel, depth) in depth.iter().enumerate() {
        let (x, y) = (pixel as u32 % view.width, pixel as u32 / view.width);
        let Some(position) = Oracle::position(view, x, y, *depth) else { continue };
        let cell = owned.cell_of_sample[pixel];
        let list = if cell != NO_CELL { list_of(cell) } else { &[] };
        counts.samples += 1;
        counts.listed_pairs += list.len() as u64;
        counts.listed_of_sample[pixel] = list.len() as u32;
        for id in (0..lights.len()).filter(|id| reaches(&lights[*id], view, position)) {
            counts.lights_of_sample[pixel] += 1;
            counts.missed_of_sample[pixel] += u32::from(!list.contains(&(id as u32)));
            reached.insert((cell, id));
        }
        owners.insert(cell);
    }
    counts.exact_pairs = counts.lights_of_sample.iter().map(|n| u64::from(*n)).sum();
    counts.missed_pairs = counts.missed_of_sample.iter().map(|n| u64::from(*n)).sum();
    counts.reached_cells = reached.iter().filter(|(cell, _)| *cell != NO_CELL).count() as u64;
    counts.listed_cells = owners.iter().filter(|c| **c != NO_CELL).map(|c| list_of(*c).len() as u64).sum();
    for cell in 0..owned.offsets.len() as u32 - 1 {
        let list = list_of(cell);
        counts.longest_list = counts.longest_list.max(list.len() as u32);
        let directional = |id: &&u32| lights[**id as usize].kind == LightKind::Directional;
        counts.foreign += list.iter().filter(directional).count() as u64;
        counts.unordered += (1..list.len()).filter(|k| list[*k] <= list[*k - 1]).count() as u64;
    }
    counts
}

#[test]
fn every_count_equals_that_of_asking_every_light() {
    let mut random = Random::new(31);
    let lights = mixed_lights(&mut random, 300);
    let camera = Camera::looking(DVec3::new(3.0, 2.0, 8.0), DVec3::ZERO, 1.0);
    let view = View::new(&camera, 40, 24).expect("a good camera");
    let mut depth = || if random.unit_f64() < 0.1 { 0.0 } else { (view.znear / random.range(2.0, 15.0)) as f32 };
    let depth: Vec<f32> = (0..40 * 24).map(|_| depth()).collect();
    let tile = |pixel: u32| pixel / (40 * 8) * 5 + pixel % 40 / 8;
    let cells: Vec<u32> = (0..40 * 24).map(|p| if p % 97 == 0 { NO_CELL } else { tile(p) }).collect();
    let mut lists: Vec<Vec<u32>> = (0..15).map(|_| (0..300).filter(|_| random.unit_f64() < 0.5).collect()).collect();
    lists[3].reverse();
    let owned = Owned::new(&cells, &lists);
    let counts = Oracle::new(&lights, &view).count(&depth, &owned.lists());
    assert!(counts.missed_pairs > 1000 && counts.exact_pairs > counts.missed_pairs && counts.samples < 960);
    assert!(counts.unordered > 0 && counts.foreign > 0);
    assert_eq!(counts, ask_every_light(&lights, &view, &depth, &owned));
}

#[test]
fn reach_is_exact_far_away_and_at_every_range() {
    let mut random = Random::new(8);
    let view = row();
    let mut lights = Vec::new();
    for range in [1e-6, 1e-3, 0.9, 1.0, 1e3, 1e9] {
        for offset in [0.0, 1.0, 1e7] {
            for _ in 0..6 {
                // Multiples of the range, where cells that were no longer than it would begin.
                let steps = DVec3::from_array([0; 3].map(|_| random.range(-3.0, 3.0).round()));
                lights.push(light(LightKind::Point, DVec3::splat(offset) + steps * range, range));
            }
        }
    }
    let oracle = Oracle::new(&lights, &view);
    for light in &lights {
        for part in [0.0, 0.5, 1.0 - 1e-9, 1.0 + 1e-9] {
            for way in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z, direction(&mut random)] {
                let position = light.position + way * light.range * part;
                let near = |id: &u32| lights[*id as usize].position.distance(position) < lights[*id as usize].range;
                let expected: Vec<u32> = (0..lights.len() as u32).filter(near).collect();
                assert_eq!(oracle.reaching(position), expected, "{light:?} {part} {way}");
            }
        }
    }
}

#[test]
fn lights_at_one_point_are_each_found_once() {
    let lights = vec![point(1e7, 2.0); 20_000];
    let oracle = Oracle::new(&lights, &row());
    assert_eq!(oracle.reaching(DVec3::new(1e7 + 1.0, 0.0, -5.0)), (0..20_000).collect::<Vec<u32>>());
    assert!(oracle.reaching(DVec3::new(1e7 + 2.0, 0.0, -5.0)).is_empty());
    let single = Oracle::new(&lights[..1], &row());
    assert_eq!(single.reaching(DVec3::new(1e7, 0.0, -5.0)), [0]);
}

#[test]
fn lights_behind_a_surface_do_not_reach_it_and_those_before_it_are_missed() {
    let lists = Owned::new(&ROW_CELLS, &[vec![], vec![]]);
    // Samples at x = -3, -1 and 1; lights at -3 (in the first), at 0 (beyond -1 and before 1) and at 2.
    let counted = |x: f64| {
        let oracle = Oracle::new(&row_lights(), &row()).facing(vec![DVec3::X * x; 4]);
        oracle.count(&ROW_DEPTH, &lists.lists())
    };
    assert_eq!(counted(1.0).lights_of_sample, [0, 1, 1, 0]);
    assert_eq!(counted(-1.0).lights_of_sample, [0, 0, 1, 0]);
    assert_eq!((counted(1.0).missed_pairs, counted(-1.0).missed_pairs), (2, 1));
}
