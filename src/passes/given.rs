//! Scripts of lists from what is given instead of drawn, so that two drivers start from the same words: lists of tiles from their bounds,
//! and lists of tiles or clusters from depths. Adds no node of its own.

use ash::vk;

use super::depth_reduce::BOUNDS_FORMAT;
use super::resources::Given;
use super::{Frame, SceneHandles, cluster_lists, read_back, tile_bin, tile_cull};
use crate::graph::{Graph, Lifetime};
use crate::plan::{Clusters, Plan};

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
    scene.given = Some(Given { image, size, bytes: bytemuck::cast_slice(bounds).to_vec() });
    let bins = tile_bin::add(&mut graph, tiles, &handles);
    let lists = tile_cull::add(&mut graph, "tile", tiles, &handles, bins, Some(image));
    graph.end_frame();
    let buffers = [("list_offsets", lists.offsets), ("list_lights", lists.lights)];
    let results = read_back::add_all(&mut graph, &[], &buffers);
    Some(Frame { graph, scene, results })
}

/// The frame that makes the plan's lists from `depth`, one reversed depth a pixel, and leaves what [`super::list_frame`] or
/// [`super::cluster_frame`] leave. `None` where the technique has no lists, reads normals too, or the picture has another number of pixels.
pub fn given_depth_frame(plan: &Plan, depth: &[f32]) -> Option<Frame> {
    let mut graph = Graph::new();
    let mut scene = SceneHandles::declare(&mut graph, plan);
    let size = [plan.view.width, plan.view.height];
    let by_normal = plan.clusters.as_ref().is_some_and(Clusters::by_normal);
    if plan.tiles.is_none() || by_normal || depth.len() as u64 != plan.pixels() {
        return None;
    }
    let image = graph.image("given_depth", vk::Format::R32_SFLOAT, size, Lifetime::Static);
    scene.given = Some(Given { image, size, bytes: bytemuck::cast_slice(depth).to_vec() });
    let results = match cluster_lists::Parts::of(plan, &scene) {
        Some(parts) => cluster_lists::add_and_leave(&mut graph, &parts, image, None),
        None => super::add_and_leave_lists(&mut graph, plan, &scene, image, None),
    };
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
