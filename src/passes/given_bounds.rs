//! The script of lists of tiles from bounds that are given instead of reduced from depths, so that two drivers start from the same words.
//! Adds no node of its own.

use super::depth_reduce::BOUNDS_FORMAT;
use super::resources::GivenBounds;
use super::{Frame, SceneHandles, read_back, tile_bin, tile_cull};
use crate::graph::{Graph, Lifetime};
use crate::plan::Plan;

/// The frame that makes lists of tiles from `bounds`, a texel a tile as depth reduction stores it, row-major, and leaves them. `None`
/// where the technique has no tiles or has another number of them.
pub fn given_bounds_frame(plan: &Plan, bounds: &[[u32; 4]]) -> Option<Frame> {
    let mut graph = Graph::new();
    let mut scene = SceneHandles::declare(&mut graph, plan);
    let (tiles, handles) = (plan.tiles.as_ref()?, scene.tiles?);
    if bounds.len() != tiles.count_tiles() as usize {
        return None;
    }
    let size = [tiles.grid.columns, tiles.grid.rows];
    let image = graph.image("given_bounds", BOUNDS_FORMAT, size, Lifetime::Static);
    scene.given_bounds = Some(GivenBounds { image, texels: bounds.to_vec() });
    let bins = tile_bin::add(&mut graph, tiles, &handles);
    let lists = tile_cull::add(&mut graph, tiles, &handles, bins, Some(image));
    graph.end_frame();
    let buffers = [("list_offsets", lists.offsets), ("list_lights", lists.lights)];
    let results = read_back::add_all(&mut graph, &[], &buffers);
    Some(Frame { graph, scene, results })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};
    use crate::plan::{Limits, Request, Technique};
    use crate::scene::builtin;

    #[test]
    fn bounds_of_every_tile_are_bound_and_ordered() {
        let scene = builtin::load("cornell").expect("a built-in scene");
        let plan = |technique| {
            let request = Request { width: 40, height: 24, technique, ..Request::default() };
            Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan")
        };
        let tiled = plan(Technique::TiledForward);
        let frame = given_bounds_frame(&tiled, &[[0; 4]; 6]).expect("three columns and two rows");
        let graph = &frame.graph;
        assert!(graph.problems().is_empty(), "{:?}", graph.problems());
        let barriers = hazard::derive(graph);
        let found = checker::check(graph, &log::declared(graph, &barriers, 3));
        assert!(found.is_empty(), "{found:#?}");
        assert!(!graph.nodes.iter().any(|node| node.name == "depth_reduce" || node.name == "depth_prepass"));
        assert!(given_bounds_frame(&tiled, &[[0; 4]; 5]).is_none());
        assert!(given_bounds_frame(&plan(Technique::Forward), &[]).is_none());
    }
}
