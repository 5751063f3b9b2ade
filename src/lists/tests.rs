use glam::DMat4;

use super::*;
use crate::plan::{Limits, Request, Technique};
use crate::scene::view::View;
use crate::scene::{Camera, Projection, builtin};

/// Four pixels whose samples of depth 0.5 lie at x = -3, -1, 1, 3 and z = -5; the last one is sky.
const DEPTH: [f32; 4] = [0.5, 0.5, 0.5, 0.0];

fn view() -> View {
    let projection = Projection::Orthographic { xmag: 4.0, ymag: 1.0, znear: 0.0, zfar: 10.0 };
    let camera = Camera { name: "row".into(), camera_to_world: DMat4::IDENTITY, projection };
    View::new(&camera, 4, 1).expect("a good camera")
}

/// A directional light, then three of which one, one and two reach the three samples.
fn lights() -> Vec<ResolvedLight> {
    let light = |kind, x, range| ResolvedLight {
        kind,
        position: DVec3::new(x, 0.0, -5.0),
        direction: DVec3::NEG_Z,
        intensity: DVec3::ONE,
        range,
        shadow: false,
    };
    vec![
        light(LightKind::Directional, 0.0, f64::INFINITY),
        light(LightKind::Point, -3.0, 0.5),
        light(LightKind::Point, 0.0, 1.5),
        light(LightKind::Point, 2.0, 1.5),
    ]
}

/// Two cells of two pixels each, and one without any.
fn cells() -> Cells {
    Cells { cell_of_sample: vec![0, 0, 1, 1], offsets: vec![0, 3, 5, 6], lights: vec![1, 2, 3, 2, 3, 1], capacity: 6 }
}

fn counters(cells: &Cells) -> Counters {
    Counters::new(cells, &cells.judge(Oracle::new(&lights(), &view()), &DEPTH), 1)
}

#[test]
fn counters_are_those_counted_by_hand() {
    let expected = Counters {
        light_pairs: 6,
        exact_pairs: 4,
        missed_pairs: 0,
        waste_cells: 1.25,
        waste_samples: 2.0,
        light_evaluations: 3 + 8,
        lists_overflowed: 0,
        longest_list: 3,
    };
    assert_eq!(counters(&cells()), expected);
}

#[test]
fn a_light_that_is_left_out_is_missed_and_one_too_many_is_waste() {
    let fewer = Cells { offsets: vec![0, 3, 4, 5], lights: vec![1, 2, 3, 3, 1], capacity: 5, ..cells() };
    let found = counters(&fewer);
    assert_eq!((found.missed_pairs, found.light_pairs, found.light_evaluations), (1, 5, 3 + 7));
    let more = Cells { offsets: vec![0, 3, 6, 6], lights: vec![1, 2, 3, 1, 2, 3], ..cells() };
    assert_eq!((counters(&more).missed_pairs, counters(&more).waste_samples), (0, 9.0 / 4.0));
}

#[test]
fn lists_beyond_their_memory_are_counted() {
    assert_eq!(counters(&Cells { capacity: 5, ..cells() }).lists_overflowed, 1);
    assert_eq!(counters(&Cells { capacity: 4, ..cells() }).lists_overflowed, 2);
}

#[test]
fn without_lists_one_cell_lists_every_light() {
    let found = counters(&Cells::whole_picture(4, 1..4));
    assert_eq!((found.light_pairs, found.longest_list, found.missed_pairs), (3, 3, 0));
    assert_eq!((found.light_evaluations, found.lists_overflowed), (3 * 4, 0));
    assert_eq!((found.waste_samples, found.waste_cells), (9.0 / 4.0, 1.0));
}

#[test]
fn waste_of_a_pixel_is_one_only_where_nothing_is_listed_in_vain() {
    assert_eq!([waste(0.0, 0.0), waste(3.0, 3.0), waste(3.0, 2.0)], [1.0, 1.0, 1.5]);
    assert_eq!(waste(1.0, 0.0), f32::INFINITY);
}

#[test]
fn list_lengths_are_those_of_the_pixels_cells() {
    assert_eq!(cells().list_lengths(), [3.0, 3.0, 2.0, 2.0]);
    let outside = Cells { cell_of_sample: vec![u32::MAX], ..cells() };
    assert!(outside.list_lengths()[0].is_nan());
}

/// A plan of 20x9 pixels in two tiles, and depths: two of the nearest, one a tile, one of the farthest in the second tile.
fn clustered(prepass: bool) -> (Plan, Vec<f32>) {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let request =
        Request { width: 20, height: 9, technique: Technique::ClusteredForward, prepass, ..Request::default() };
    let plan = Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan");
    let mut depth = vec![0.0; 180];
    (depth[0], depth[17], depth[19]) = (1.0, 1.0, f32::MIN_POSITIVE);
    (plan, depth)
}

fn words_as_layers(layers: &[(&str, Vec<u32>)]) -> Picture {
    let mut picture = Picture::new(20, 9);
    for (name, words) in layers {
        picture.add_layer(name, words.iter().map(|&word| f32::from_bits(word)).collect());
    }
    picture
}

#[test]
fn without_samples_every_slice_of_every_tile_is_a_cell() {
    let (plan, depth) = clustered(false);
    let (tiles, clusters) = (plan.tiles.as_ref().expect("tiles"), plan.clusters.as_ref().expect("clusters"));
    let (slices, capacity) = (clusters.grid.slices, clusters.grid.capacity);
    assert!(slices > 1 && capacity == 2 * slices);
    let picture =
        words_as_layers(&[("list_offsets", (0..=capacity).collect()), ("list_lights", vec![5; capacity as usize + 3])]);
    let cells = Cells::of_clusters(tiles, clusters, &picture, &depth);
    assert_eq!([0, 17, 19, 1].map(|pixel| cells.cell_of_sample[pixel]), [0, slices, 2 * slices - 1, NO_CELL]);
    assert_eq!((cells.light_pairs(), cells.longest_list(), cells.overflowed()), (u64::from(capacity), 1, 0));
    assert_eq!(cells.capacity, capacity as usize + 3);
    let made = Made { depth, cells, ..Made::default() };
    let shown = |view| {
        let numbers = made.numbers(view, &plan, &PairCounts::default()).expect("a view of clusters");
        (numbers.0, [0, 17, 19].map(|pixel| numbers.1[pixel]), numbers.1.iter().filter(|n| n.is_nan()).count())
    };
    let last = (slices - 1) as f32;
    assert_eq!(shown(DebugView::Slices), ("slice", [0.0, 0.0, last], 177));
    assert_eq!(shown(DebugView::Clusters), ("cluster", [0.0, last + 1.0, 2.0 * last + 1.0], 177));
    assert_eq!(shown(DebugView::ClusterLights), ("cluster_lights", [1.0; 3], 177));
}

#[test]
fn cells_are_the_clusters_that_own_samples() {
    let (plan, depth) = clustered(true);
    let (tiles, clusters) = (plan.tiles.as_ref().expect("tiles"), plan.clusters.as_ref().expect("clusters"));
    let mut index = vec![NO_CELL; 180];
    (index[0], index[17], index[19]) = (0, 1, 2);
    let picture = words_as_layers(&[
        ("cluster_total", vec![3]),
        ("cluster_index", index),
        // Two clusters more than there are.
        ("list_offsets", vec![0, 2, 2, 5, 9, 9]),
        ("list_lights", vec![1, 2, 1, 2, 3, 7, 7, 7]),
    ]);
    let cells = Cells::of_clusters(tiles, clusters, &picture, &depth);
    assert_eq!((cells.light_pairs(), cells.longest_list(), cells.lights.len(), cells.capacity), (5, 3, 5, 8));
    let lengths = cells.list_lengths();
    assert_eq!([0, 17, 19].map(|pixel| lengths[pixel]), [2.0, 0.0, 3.0]);
    assert!(lengths[1].is_nan());
    let candidates = Cells { cell_of_sample: vec![0; 180], offsets: vec![0, 9], ..Cells::default() };
    let made = Made { depth, cells, candidates: Some(candidates), ..Made::default() };
    let of_tiles = made.numbers(DebugView::TileLights, &plan, &PairCounts::default()).expect("lists of tiles");
    assert_eq!((of_tiles.0, of_tiles.1[0]), ("list_length", 9.0));
    let tiled = Plan { clusters: None, ..plan };
    assert!(made.numbers(DebugView::Clusters, &tiled, &PairCounts::default()).is_none());
}
