//! Slices in f64, and every bound counted once more by hand.

use super::*;
use crate::plan::{GbufferLayout, Plan, Technique};
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Projection, Scene, builtin, scatter};
use crate::shared::FAR_LIMIT;

fn request(width: u32, height: u32) -> Request {
    let rules = LightRules { range: RangeRule::Fixed(1.0), ..LightRules::default() };
    Request { width, height, technique: Technique::ClusteredForward, rules, ..Request::default() }
}

fn atrium(lights: usize) -> Scene {
    let mut scene = builtin::load("atrium").expect("a built-in scene");
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 5);
    scene
}

fn planned(scene: &Scene, request: &Request, limits: &Limits) -> (Clusters, Tiles) {
    let plan = Plan::new(scene, request, limits).expect("a plan");
    (plan.clusters.expect("clusters"), plan.tiles.expect("tiles"))
}

fn with_lens(mut scene: Scene, projection: Projection) -> Scene {
    let mut camera = scene.cameras.first().cloned().expect("a camera");
    camera.projection = projection;
    scene.cameras = vec![camera];
    scene
}

#[test]
fn bits_and_rooms() {
    assert_eq!([1, 2, 3, 240, 256, 257].map(bits), [0, 1, 2, 8, 8, 9]);
    let grid = TileGrid { width: 70, height: 40, ..TileGrid::default() };
    // 4 x 2 whole squares, 4 cut below (16 x 8), 2 cut right (6 x 16), one of 6 x 8.
    assert_eq!(room(&grid, 16, 1000), 70 * 40);
    assert_eq!(room(&grid, 16, 100), 8 * 100 + 4 * 100 + 2 * 96 + 48);
    assert_eq!(room(&grid, 16, 1), 15);
    assert_eq!(room(&TileGrid { width: 32, height: 16, ..grid }, 16, 7), 14);
}

#[test]
fn keys_have_room_for_the_tiles_of_a_large_picture() {
    let (mut clusters, tiles) = planned(&atrium(8), &request(3840, 2160), &Limits::UNLIMITED);
    assert_eq!(tiles.count_tiles(), 240 * 135);
    assert!(clusters.key_bits <= 15 + 9 && clusters.key_bits == bits(240 * 135) + clusters.grid.slice_bits);
    clusters.key_bits = 33;
    let refused = clusters.check(&tiles, &Limits::UNLIMITED).expect_err("too many bits").to_string();
    assert!(
        refused.contains("33 bits") && refused.contains("16x16 pixels") && refused.contains("3840x2160"),
        "{refused}"
    );
}

#[test]
fn slices_follow_each_other_and_the_last_is_unbounded() {
    let near = |znear, zfar| Projection::Perspective { yfov: 1.0, aspect: None, znear, zfar };
    let flat = |znear, zfar| Projection::Orthographic { xmag: 8.0, ymag: 5.0, znear, zfar };
    let lenses = [near(0.05, None), near(0.5, Some(40.0)), near(5.0, Some(5.01)), flat(0.0, 50.0), flat(-9.0, 30.0)];
    for lens in lenses {
        let (clusters, tiles) = planned(&with_lens(atrium(8), lens), &request(160, 90), &Limits::MINIMUM);
        let (slices, znear) = (&clusters.slices, f64::from(tiles.grid.near));
        assert!(slices.len() <= 256 && slices.len() == clusters.grid.slices as usize, "{lens:?}");
        assert!((f64::from(slices[0][0]) - znear).abs() <= 1e-3 * znear.abs().max(1.0), "{lens:?} {}", slices[0][0]);
        assert_eq!(slices[slices.len() - 1][1], FAR_LIMIT);
        for pair in slices.windows(2) {
            let (this, next) = (pair[0], pair[1]);
            assert!(this[0] < next[0] && this[1] < next[1] && next[0] <= this[1], "{lens:?} {pair:?}");
            assert!(this[1] - next[0] < 0.1 * (this[1] - this[0]), "{lens:?} {pair:?}");
        }
    }
}

#[test]
fn one_slice_where_near_is_far_or_nothing_is_drawn_behind_near() {
    for (znear, zfar) in [(5.0, Some(5.01)), (1e4, None), (1e-30, Some(1.0001e-30))] {
        let lens = Projection::Perspective { yfov: 1.0, aspect: None, znear, zfar };
        let (clusters, _) = planned(&with_lens(atrium(8), lens), &request(160, 90), &Limits::MINIMUM);
        assert_eq!((clusters.grid.slices, clusters.slices.len(), clusters.grid.slice_bits), (1, 1, 0), "{znear}");
    }
}

#[test]
fn slices_are_about_as_deep_as_a_tile_is_wide() {
    let lens = Projection::Perspective { yfov: 1.0, aspect: None, znear: 4.0, zfar: None };
    let scene = with_lens(atrium(8), lens);
    for tile in [8, 16, 32, 64] {
        let (clusters, _) = planned(&scene, &Request { tile, ..request(1280, 720) }, &Limits::UNLIMITED);
        let wide = 2.0 * 0.5f64.tan() * f64::from(tile) / 720.0;
        let octave = 1 << (23 - clusters.grid.slice_shift);
        let deep = (1.0 / f64::from(octave)).exp2() - 1.0;
        assert!(deep > wide * 0.65 && deep < wide * 1.5, "{tile}: {deep} of {wide}");
    }
}

#[test]
fn pairs_are_those_counted_one_by_one() {
    let scene = atrium(300);
    for tile in [8, 32] {
        let (clusters, tiles) = planned(&scene, &Request { tile, ..request(320, 180) }, &Limits::UNLIMITED);
        let mut wanted = 0;
        for light in tiles.lights.chunks_exact(CULL_TEXELS as usize) {
            let [x, y, z, _] = light[0];
            let [near, far, radius, _] = light[1];
            let passes = |edge: usize, at: f32| {
                cull::edge_distance(tiles.edges[edge], at, z) >= -radius
                    && cull::edge_distance(tiles.edges[edge + 1], at, z) <= radius
            };
            let of_bins = |first: f32, last: f32, at: u32| {
                first <= last && at / BIN_TILES >= first as u32 / BIN_TILES && at / BIN_TILES <= last as u32 / BIN_TILES
            };
            let columns =
                (0..tiles.grid.columns).filter(|&c| of_bins(light[2][0], light[2][1], c) && passes(c as usize, x));
            let base = tiles.grid.columns as usize + 1;
            let rows =
                (0..tiles.grid.rows).filter(|&r| of_bins(light[2][2], light[2][3], r) && passes(base + r as usize, y));
            let reached = clusters.slices.iter().filter(|s| s[0] <= far && s[1] >= near && near <= far).count();
            wanted += (columns.count() * rows.count() * reached.min((tile * tile) as usize)) as u64;
        }
        assert_eq!(clusters.pairs, wanted, "{tile}");
        assert!(wanted > 0);
    }
}

#[test]
fn slices_get_deeper_where_lists_would_not_fit() {
    let (scene, request) = (atrium(3000), request(320, 180));
    let (fine, tiles) = planned(&scene, &request, &Limits::UNLIMITED);
    let limits = Limits { max_storage_bytes: fine.pairs * 4 - 1, ..Limits::UNLIMITED };
    let (coarse, _) = planned(&scene, &request, &limits);
    assert!(coarse.grid.slices < fine.grid.slices && coarse.pairs * 4 <= limits.max_storage_bytes);
    assert!(coarse.why.contains("as many as") && !fine.why.contains("as many as"), "{} {}", coarse.why, fine.why);
    let refused = Clusters { pairs: 1 << 30, ..fine }.check(&tiles, &limits).expect_err("too long").to_string();
    assert!(refused.contains("binds at most") && refused.contains("320x180"), "{refused}");
}

#[test]
fn normals_are_refused_where_there_are_none() {
    let request = Request { cluster_normals: true, ..request(32, 32) };
    let refused = Plan::new(&atrium(1), &request, &Limits::MINIMUM).expect_err("no normals").to_string();
    assert!(refused.contains("--cluster-normals") && refused.contains("clustered-forward"), "{refused}");
    let deferred = Request { technique: Technique::ClusteredDeferred, ..request };
    let fat = Request { gbuffer: GbufferLayout::Fat, ..deferred.clone() };
    let limits = Limits { max_color_attachments: 5, ..Limits::MINIMUM };
    let lamps = Scene { instances: Vec::new(), ..atrium(1) };
    let empty = Plan::new(&lamps, &deferred, &limits).expect("nothing to tell apart");
    assert!(empty.clusters.is_some_and(|clusters| !clusters.by_normal()));
    let auto = Request { technique: Technique::Auto, ..deferred.clone() };
    assert_eq!(Plan::new(&atrium(1), &auto, &limits).expect("a plan").technique, Technique::ClusteredDeferred);
    for (asked, word) in [(Request { prepass: false, ..deferred.clone() }, "pre-pass"), (fat, "fat")] {
        let refused = Plan::new(&atrium(1), &asked, &limits).expect_err("no normals").to_string();
        assert!(refused.contains("--cluster-normals") && refused.contains(word), "{refused}");
    }
    assert!(Plan::new(&atrium(1), &deferred, &limits).is_ok());
}

#[test]
fn directions_give_way_before_slices_do() {
    let (scene, plain) = (atrium(3000), Request { technique: Technique::ClusteredDeferred, ..request(320, 180) });
    let told = Request { cluster_normals: true, ..plain.clone() };
    let ((without, _), (many, _)) =
        (planned(&scene, &plain, &Limits::UNLIMITED), planned(&scene, &told, &Limits::UNLIMITED));
    assert!(!without.by_normal() && without.grid.direction_bits == 0);
    assert_eq!((many.grid.direction_bits, many.grid.slices, many.directions.len()), (6, without.grid.slices, 128));
    assert_eq!((many.grid.slice_bits, many.key_bits), (without.grid.slice_bits + 6, without.key_bits + 6));
    let limits = Limits { max_storage_bytes: many.pairs * 4 - 1, ..Limits::UNLIMITED };
    let (few, _) = planned(&scene, &told, &limits);
    assert_eq!((few.grid.direction_bits, few.grid.slices), (4, without.grid.slices));
    assert!(few.why.contains("16 directions") && few.pairs < many.pairs, "{}", few.why);
}

#[test]
fn without_a_pre_pass_every_slice_of_every_tile_is_a_cluster() {
    let (clusters, tiles) = planned(&atrium(8), &Request { prepass: false, ..request(320, 180) }, &Limits::UNLIMITED);
    assert!(!clusters.keyed && !clusters.merged && clusters.bounds == ClusterBounds::Implicit);
    assert_eq!(clusters.grid.capacity, tiles.count_tiles() * clusters.grid.slices);
    let (keyed, _) = planned(&atrium(8), &Request { tile: 64, ..request(320, 180) }, &Limits::UNLIMITED);
    assert!(keyed.keyed && keyed.merged && keyed.grid.tile_parts == 4 && keyed.bounds == ClusterBounds::Explicit);
    assert!(keyed.bytes() > 0 && u64::from(keyed.grid.capacity) <= 320 * 180);
}

#[test]
fn slices_an_octave_are_those_asked_for() {
    let scene = atrium(8);
    for (asked, shift) in [(1, 23), (4, 21), (16, 19)] {
        let request = Request { slices_per_octave: Some(asked), ..request(160, 90) };
        assert_eq!(planned(&scene, &request, &Limits::UNLIMITED).0.grid.slice_shift, shift);
    }
    let flat = with_lens(scene, Projection::Orthographic { xmag: 8.0, ymag: 5.0, znear: 0.0, zfar: 50.0 });
    let asked = Request { slices_per_octave: Some(4), ..request(160, 90) };
    let refused = Plan::new(&flat, &asked, &Limits::UNLIMITED).expect_err("slices of one depth").to_string();
    assert!(refused.contains("--slices-per-octave"), "{refused}");
}
