//! The script of clusters: lists of tiles or the light hierarchy as candidates, keys of samples, boxes, assignment. Adds no node of its
//! own.

use super::cluster_assign::{self, Candidates, Keyed};
use super::tile_bin::Bins;
use super::tile_cull::Lists;
use super::{
    ClusterHandles, Frame, SceneHandles, TileHandles, cluster_flags, cluster_index, cluster_keys, cluster_unique,
};
use super::{depth_prepass, gbuffer, light_tree, read_back, tile_lists};
use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::plan::{Clusters, Plan, Tiles};
use crate::shared::{CLUSTER_OF_PIXEL, CLUSTER_OF_RANK, CLUSTER_OF_SLICE};

/// Layer of [`cluster_frame`]: the codes of normals that directions come from.
pub const NORMAL_CODES: &str = "normal_codes";

/// What a plan with clusters has.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// Tiles.
    pub tiles: &'a Tiles,
    /// Their static buffers.
    pub tile_handles: &'a TileHandles,
    /// Clusters.
    pub clusters: &'a Clusters,
    /// Their static buffers.
    pub handles: &'a ClusterHandles,
}

impl<'a> Parts<'a> {
    /// The parts of a plan; `None` where its technique has no clusters.
    pub fn of(plan: &'a Plan, scene: &'a SceneHandles) -> Option<Self> {
        Some(Self {
            tiles: plan.tiles.as_ref()?,
            tile_handles: scene.tiles.as_ref()?,
            clusters: plan.clusters.as_ref()?,
            handles: scene.clusters.as_ref()?,
        })
    }
}

/// Lists of clusters, and which cluster a sample has.
#[derive(Debug, Clone, Copy)]
pub struct ClusterLists {
    /// List c belongs to cluster c.
    pub lists: Lists,
    /// Value of CLUSTER_OF.
    pub lookup: u32,
    /// u32 a sample or a slice of a tile; `None` where every slice of every tile is a cluster, which shading computes.
    pub index: Option<ImageHandle>,
    /// Lists of tiles, where candidates came from them.
    pub tile_lists: Option<Lists>,
    /// What is known of the tiles' depths.
    pub tile_bounds: Option<ImageHandle>,
    /// Lists of bins, where candidates came from tiles.
    pub bins: Option<Bins>,
    /// Header and entries of the light hierarchy, where candidates came from it.
    pub tree: Option<BufferHandle>,
    /// What clusters were made of samples.
    pub keyed: Option<Keyed>,
}

/// Adds every step; `depth` is what a pre-pass left, and clusters are made of its samples where the plan says so; `normals` are the codes
/// of a compact G-buffer, where clusters tell directions.
pub fn add(graph: &mut Graph, parts: &Parts, depth: Option<ImageHandle>, normals: Option<ImageHandle>) -> ClusterLists {
    let Parts { tiles, tile_handles, clusters, handles } = *parts;
    let (candidates, tile_bounds, bins) = match &clusters.tree {
        Some(source) => {
            (Candidates::Tree(source, light_tree::add(graph, tiles, &source.tree, tile_handles)), None, None)
        }
        None => {
            let made = tile_lists(graph, tiles, tile_handles, depth, None);
            (Candidates::Tiles(made.lists), made.bounds, Some(made.bins))
        }
    };
    let made = depth.filter(|_| clusters.keyed).map(|depth| {
        if clusters.flagged {
            return cluster_flags::add_samples(graph, parts, depth);
        }
        let (tile_grid, cluster_grid) = (tile_handles.grid, handles.grid);
        let normals = normals.filter(|_| clusters.by_normal()).unwrap_or(tile_handles.no_bounds);
        let inputs = cluster_keys::Inputs { clusters, tile_grid, cluster_grid, depth, normals };
        let entries = cluster_keys::add(graph, &inputs);
        let merged = clusters.merged.then(|| cluster_unique::add(graph, clusters, &entries));
        let indexed = cluster_index::add(graph, &inputs, &entries, merged.as_ref());
        let (keys, counted) = merged.map_or((entries.keys, entries.counted), |m| (m.keys, m.counted));
        (Keyed { keys, bounds: indexed.bounds, counted }, indexed.index)
    });
    let (keyed, index) = made.unzip();
    let lookup = match index {
        None => CLUSTER_OF_SLICE,
        Some(_) if clusters.flagged => CLUSTER_OF_RANK,
        Some(_) => CLUSTER_OF_PIXEL,
    };
    let tree = candidates.texels();
    let inputs = cluster_assign::Inputs { name: "cluster", tiles, tile_handles, clusters, handles, candidates, keyed };
    let lists = cluster_assign::add(graph, &inputs);
    ClusterLists { lists, lookup, index, tile_lists: candidates.lists(), tile_bounds, bins, tree, keyed }
}

/// The frame that makes clusters with their lists and leaves them, with the depths they were made from: for counting and judging. `None`
/// where the technique has no clusters.
pub fn cluster_frame(plan: &Plan) -> Option<Frame> {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let parts = Parts::of(plan, &scene)?;
    let depth = depth_prepass::add(&mut graph, plan, &scene);
    let planned = plan.deferred.as_ref().filter(|_| parts.clusters.by_normal());
    let layers = planned.map(|deferred| gbuffer::add(&mut graph, plan, &deferred.gbuffer, &scene, Some(depth)));
    let normals = layers.map(|layers| layers.normals);
    let results = add_and_leave(&mut graph, &parts, depth, normals);
    Some(Frame { graph, scene, results })
}

/// Every step, and the end of a frame that leaves clusters and lists with what they were made from.
pub(super) fn add_and_leave(
    graph: &mut Graph,
    parts: &Parts,
    depth: ImageHandle,
    normals: Option<ImageHandle>,
) -> Vec<(&'static str, BufferHandle)> {
    let made = add(graph, parts, Some(depth), normals);
    graph.end_frame();
    let mut images = vec![("depth", depth)];
    images.extend(normals.map(|normals| (NORMAL_CODES, normals)));
    images.extend(made.tile_bounds.map(|bounds| ("tile_bounds", bounds)));
    images.extend(made.index.map(|index| ("cluster_index", index)));
    let mut buffers: Vec<(&'static str, BufferHandle)> =
        vec![("list_offsets", made.lists.offsets), ("list_lights", made.lists.lights)];
    if let Some(lists) = made.tile_lists {
        buffers.extend([("tile_offsets", lists.offsets), ("tile_lights", lists.lights)]);
    }
    if let Some(keyed) = made.keyed {
        let of_clusters =
            [("cluster_total", keyed.counted.total), ("cluster_keys", keyed.keys), ("cluster_bounds", keyed.bounds)];
        buffers.extend(of_clusters);
    }
    read_back::add_all(graph, &images, &buffers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Work, checker, hazard, log};
    use crate::passes;
    use crate::plan::{AssignChoice, ClusterBounds, Limits, Request, Technique};
    use crate::scene::lighting::{LightRules, RangeRule};
    use crate::scene::{builtin, scatter};

    fn planned(tile: u32, prepass: bool, bounds: ClusterBounds) -> Plan {
        let request = Request {
            width: 150,
            height: 85,
            technique: Technique::ClusteredForward,
            tile,
            prepass,
            cluster_bounds: Some(bounds),
            ..Request::default()
        };
        let scene = builtin::load("cornell").expect("a built-in scene");
        Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan")
    }

    /// The same where candidates come from the light hierarchy, by lights of 1 m.
    fn planned_by_tree(tile: u32, prepass: bool, lights: usize) -> Plan {
        let request = Request {
            width: 150,
            height: 85,
            technique: Technique::ClusteredDeferred,
            tile,
            prepass,
            assign: AssignChoice::Tree,
            rules: LightRules { range: RangeRule::Fixed(1.0), ..LightRules::default() },
            ..Request::default()
        };
        let mut scene = builtin::load("cornell").expect("a built-in scene");
        scene.lights = scatter::point_lights(&scene.bounds(), lights, 1);
        Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan")
    }

    fn names(graph: &Graph) -> Vec<&str> {
        graph.nodes.iter().map(|node| node.name.as_str()).collect()
    }

    #[test]
    fn every_kind_of_clusters_is_ordered() {
        for tile in [8, 64] {
            for (prepass, bounds) in
                [(true, ClusterBounds::Explicit), (true, ClusterBounds::Implicit), (false, ClusterBounds::Implicit)]
            {
                let plan = planned(tile, prepass, bounds);
                for frame in [passes::frame(&plan), cluster_frame(&plan).expect("clusters")] {
                    let graph = &frame.graph;
                    assert!(graph.problems().is_empty(), "{:?}", graph.problems());
                    let barriers = hazard::derive(graph);
                    let found = checker::check(graph, &log::declared(graph, &barriers, 3));
                    assert!(found.is_empty(), "{tile} {prepass} {bounds:?}: {found:#?}");
                }
            }
        }
    }

    #[test]
    fn lists_by_tree_are_ordered_and_ask_no_tile() {
        // One root and lists of one run; two roots and lists that are merged.
        for (lights, tile) in [(20, 16), (40_000, 64)] {
            for prepass in [true, false] {
                let plan = planned_by_tree(tile, prepass, lights);
                for frame in [passes::frame(&plan), cluster_frame(&plan).expect("clusters")] {
                    let graph = &frame.graph;
                    assert!(graph.problems().is_empty(), "{:?}", graph.problems());
                    let barriers = hazard::derive(graph);
                    let found = checker::check(graph, &log::declared(graph, &barriers, 3));
                    assert!(found.is_empty(), "{lights} {prepass}: {found:#?}");
                    let names = names(graph);
                    assert!(!names.iter().any(|name| name.starts_with("tile_") || *name == "depth_reduce"));
                    assert_eq!(names.contains(&"cluster_walk_offsets"), lights > 32_768, "{names:?}");
                    assert_eq!(names.contains(&"cluster_list_merge_0_out"), lights > 32_768);
                    assert!(names.contains(&"cluster_walk_fill") && names.contains(&"light_leaves"));
                }
            }
        }
    }

    #[test]
    fn a_tile_of_one_block_needs_no_sort() {
        let one = cluster_frame(&planned(16, true, ClusterBounds::Explicit)).expect("clusters").graph;
        assert!(!names(&one).iter().any(|name| name.contains("radix") || *name == "cluster_bounds"));
        let several = cluster_frame(&planned(32, true, ClusterBounds::Explicit)).expect("clusters").graph;
        assert!(["cluster_origin", "cluster_bounds"].iter().all(|name| names(&several).contains(name)));
        let dense = cluster_frame(&planned(16, false, ClusterBounds::Implicit)).expect("clusters").graph;
        assert!(!names(&dense).contains(&"cluster_keys") && names(&dense).contains(&"cluster_cells"));
    }

    #[test]
    fn no_shader_binds_more_than_four_storage_buffers() {
        for plan in [planned(64, true, ClusterBounds::Explicit), planned_by_tree(64, true, 40_000)] {
            for node in passes::frame(&plan).graph.nodes {
                let Work::Dispatch { pipeline, bindings, .. } = node.work else { continue };
                let slots = pipeline.program.slots.iter().filter(|slot| slot.kind.is_storage_buffer());
                let count = slots.filter(|slot| bindings.iter().any(|bound| bound.name == slot.name)).count();
                assert!(count <= 4, "{}", node.name);
            }
        }
    }
}
