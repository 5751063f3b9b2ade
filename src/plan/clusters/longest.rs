//! The longest list that a cluster can have: what its shading loops over.

use rayon::prelude::*;

use super::super::light_parts::Sum;
use super::super::tiles::{self, Span};
use super::{Limits, Tiles};
use crate::shared::CULL_TEXELS;

/// Where a light begins to be in the lists of some tiles, or ends to.
struct Change {
    slice: usize,
    tiles: Span,
    sign: i32,
}

/// Entries of the longest list, at most. Lists of whole tiles bound it, and are all that is asked where loops go round as often; else each
/// slice is asked with the lights that reach into it.
pub(super) fn longest_list(tiles: &Tiles, slices: &[[f32; 4]], limits: &Limits) -> u32 {
    let of_tiles = Sum { lights: tiles.longest_tile, ahead: tiles.grid.first_light, seek: false };
    if of_tiles.fits(limits) { of_tiles.lights } else { of_slices(tiles, slices) }
}

fn of_slices(tiles: &Tiles, slices: &[[f32; 4]]) -> u32 {
    let wide = tiles.grid.columns as usize + 1;
    let mut corners = vec![0; wide * (tiles.grid.rows as usize + 1)];
    let mut most = 0;
    for changes in changes(tiles, slices).chunk_by(|a, b| a.slice == b.slice) {
        for change in changes {
            tiles::add_span(&mut corners, wide, change.tiles, change.sign);
        }
        most = most.max(tiles::longest(&mut corners.clone(), wide));
    }
    most
}

/// By slice, ascending.
fn changes(tiles: &Tiles, slices: &[[f32; 4]]) -> Vec<Change> {
    // A light reaches from the first slice that ends beyond its near end to the last one that begins before its far end; what rounding
    // does to the order of slices widens this.
    let (mut begins, mut ends): (Vec<f32>, Vec<f32>) = slices.iter().map(|slice| (slice[0], slice[1])).unzip();
    for index in 1..ends.len() {
        ends[index] = ends[index].max(ends[index - 1]);
    }
    for index in (1..begins.len()).rev() {
        begins[index - 1] = begins[index - 1].min(begins[index]);
    }
    let of = |(light, [_, span]): (&[[f32; 4]], [Span; 2])| {
        let [near, far, ..] = light[1];
        let first = ends.partition_point(|&end| end < near);
        let end = begins.partition_point(|&begin| begin <= far);
        let reaches = near <= far && first < end;
        [(first, 1), (end, -1)]
            .map(|(slice, sign)| Change { slice, tiles: span, sign })
            .into_iter()
            .filter(move |_| reaches)
    };
    let lights = tiles.lights.par_chunks_exact(CULL_TEXELS as usize);
    let mut changes: Vec<Change> = lights.zip(tiles.spans()).flat_map_iter(of).collect();
    changes.par_sort_unstable_by_key(|change| change.slice);
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Plan, Request, Technique};
    use crate::scene::lighting::{LightRules, RangeRule};
    use crate::scene::{builtin, scatter};

    fn planned() -> Plan {
        let mut scene = builtin::load("corridor").expect("a built-in scene");
        scene.lights = scatter::point_lights(&scene.bounds(), 500, 1);
        let rules = LightRules { range: RangeRule::Fixed(0.5), ..LightRules::default() };
        let technique = Technique::ClusteredForward;
        let request = Request { width: 90, height: 50, technique, rules, ..Request::default() };
        Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan")
    }

    #[test]
    fn slices_are_as_long_as_asking_each_of_them() {
        let plan = planned();
        let tiles = plan.tiles.as_ref().expect("tiles");
        let slices = &plan.clusters.as_ref().expect("clusters").slices;
        let spans = tiles.spans();
        let lights: Vec<_> = tiles.lights.chunks_exact(CULL_TEXELS as usize).zip(&spans).collect();
        let mut most = 0;
        for slice in slices {
            for (x, y) in (0..tiles.grid.rows).flat_map(|y| (0..tiles.grid.columns).map(move |x| (x, y))) {
                let listed = |(light, [_, [x0, x1, y0, y1]]): &&(&[[f32; 4]], &[Span; 2])| {
                    (*x0..=*x1).contains(&x)
                        && (*y0..=*y1).contains(&y)
                        && light[1][0] <= light[1][1]
                        && light[1][0] <= slice[1]
                        && light[1][1] >= slice[0]
                };
                most = most.max(lights.iter().filter(listed).count() as u32);
            }
        }
        assert_eq!(of_slices(tiles, slices), most);
        assert!(slices.len() > 3 && most > 3 && most < tiles.longest_tile, "{most} of {}", tiles.longest_tile);
    }

    #[test]
    fn slices_are_asked_only_where_tiles_are_too_long() {
        let plan = planned();
        let (tiles, clusters) = (plan.tiles.expect("tiles"), plan.clusters.expect("clusters"));
        assert_eq!(clusters.longest_list, tiles.longest_tile);
        let few = Limits { max_loop_iterations: tiles.longest_tile - 1, ..Limits::MINIMUM };
        assert!(longest_list(&tiles, &clusters.slices, &few) < tiles.longest_tile);
    }
}
