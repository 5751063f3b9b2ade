use super::*;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Bounds, Camera, Scene, scatter};

/// Lights around a camera that looks along -z.
fn planned(request: &Request, lights: usize, range: f64, limits: &Limits) -> Result<Tiles> {
    let mut bounds = Bounds::EMPTY;
    bounds.include(DVec3::new(-8.0, -6.0, -20.0));
    bounds.include(DVec3::new(8.0, 6.0, 4.0));
    let scene = Scene { lights: scatter::point_lights(&bounds, lights, 1), ..Scene::default() };
    let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
    let lighting = Lighting::new(&scene, &rules)?;
    let view = View::new(&Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 1.0), request.width, request.height)?;
    Tiles::new(request, &lighting, &view, 30.0, limits)
}

/// Pairs and the longest list, by asking every cell.
fn asked(spans: &[Span], columns: u32, rows: u32) -> (u64, u32) {
    let of = |x: u32, y: u32| {
        spans.iter().filter(|[x0, x1, y0, y1]| (*x0..=*x1).contains(&x) && (*y0..=*y1).contains(&y)).count() as u32
    };
    let lengths = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| of(x, y));
    lengths.fold((0, 0), |(sum, most), length| (sum + u64::from(length), most.max(length)))
}

#[test]
fn pairs_are_those_of_asking_every_bin_and_tile() {
    for (cull, range) in [(CullTest::Bounds, 2.0), (CullTest::FrustumAabb, 2.0), (CullTest::FrustumAabb, 0.2)] {
        let request = Request { width: 410, height: 230, tile: 8, cull, ..Request::default() };
        let tiles = planned(&request, 400, range, &Limits::MINIMUM).expect("fits");
        let (of_bins, of_tiles): (Vec<_>, Vec<_>) =
            tiles.spans().into_iter().map(|[bins, tiles]| (bins, tiles)).unzip();
        let grid = &tiles.grid;
        let (pairs, most) = asked(&of_bins, grid.bin_columns, grid.bin_rows);
        assert_eq!((tiles.bin_pairs, tiles.longest_bin), (pairs, most));
        let (pairs, most) = asked(&of_tiles, grid.columns, grid.rows);
        assert_eq!((tiles.tile_pairs, tiles.longest_tile), (pairs, most));
        assert!(pairs > 100 && most > 1, "{cull:?}: {pairs} {most}");
    }
}

#[test]
fn what_is_added_can_be_taken_out_again() {
    let mut corners = vec![0; 5 * 4];
    assert_eq!(add_span(&mut corners, 5, [1, 3, 0, 2], 1), 9);
    assert_eq!(add_span(&mut corners, 5, [3, 3, 1, 1], 1), 1);
    assert_eq!(add_span(&mut corners, 5, [1, 0, 0, 2], 1), 0);
    assert_eq!(longest(&mut corners.clone(), 5), 2);
    add_span(&mut corners, 5, [3, 3, 1, 1], -1);
    assert_eq!(longest(&mut corners.clone(), 5), 1);
    add_span(&mut corners, 5, [1, 3, 0, 2], -1);
    assert!(corners.iter().all(|c| *c == 0));
}

#[test]
fn offsets_of_many_tiles_are_not_read_by_texel() {
    let request = Request { width: 4096, height: 2160, tile: 8, ..Request::default() };
    let tiles = planned(&request, 1, 0.1, &Limits::MINIMUM).expect("fits");
    assert!(tiles.tile_pairs < 65_536 && u64::from(tiles.count_tiles()) > Limits::MINIMUM.max_texel_elements);
    assert!(!tiles.words_by_texel && tiles.lights_by_texel);
    let coarse = planned(&Request { tile: 64, ..request }, 1, 0.1, &Limits::MINIMUM).expect("fits");
    assert!(coarse.words_by_texel);
}

#[test]
fn what_passes_a_limit_is_refused_in_one_sentence() {
    let refused = |request: &Request, lights: usize, range: f64, limits: &Limits| {
        let said = planned(request, lights, range, limits).expect_err("past a limit").to_string();
        assert!(!said.contains('\n'), "{said}");
        said
    };
    // 256 x 256 bins, one more than a row of workgroups.
    let wide = Request { width: 16_384, height: 16_384, tile: 8, ..Request::default() };
    let said = refused(&wide, 1, 0.1, &Limits::UNLIMITED);
    assert!(said.contains("4194304 tiles") && said.contains("65536 workgroups"), "{said}");
    // Offsets alone pass a binding.
    let narrow = Limits { max_storage_bytes: 1 << 20, ..Limits::MINIMUM };
    let many = Request { width: 4096, height: 4096, tile: 8, ..Request::default() };
    assert!(refused(&many, 1, 0.1, &narrow).contains("1048580 bytes"));
    // 48 bytes a light.
    let said = refused(&Request { width: 64, height: 64, ..Request::default() }, 30_000, 0.01, &narrow);
    assert!(said.contains("1440000 bytes") && said.contains("1048576 at once"), "{said}");
}

#[test]
fn lists_longer_than_loops_go_round_do_not_seek() {
    let request = Request { width: 64, height: 64, cull: CullTest::Frustum, ..Request::default() };
    let loops = |most: u32| Limits { max_loop_iterations: most, ..Limits::MINIMUM };
    let tiles = planned(&request, 300, 50.0, &loops(1000)).expect("fits");
    assert!(tiles.list_seek && tiles.longest_tile > 250);
    assert!(!planned(&request, 300, 50.0, &loops(500)).expect("fits").list_seek);
}
