//! Light hierarchy: a wide tree of boxes over the lights in Morton order (after C. Lauterbach et al., "Fast BVH Construction on GPUs",
//! Computer Graphics Forum 28(2), 2009, with 8 children a node, so that no pointer is needed). It answers which lights may reach
//! a box; `glsl/inc/light_tree.glsl` has the walk.
//!
//! Reads: lights to cull. Writes: boxes of lights and nodes, level by level, and the lights' order in them. Steps: keys (a thread a
//! light), radix sort, boxes of single lights (a thread a light), and one node of the graph a level upwards (a thread a node of 8);
//! groups of 64. Limits: the plan counts entries and refuses more than 4 million lights. CPU twin: `reference/light_tree.rs`.

use bytemuck::{Pod, bytes_of};

use super::tile_bin::cull_fetch;
use super::{TileHandles, radix_sort};
use crate::graph::access::{ComputeStorageRead, ComputeStorageReadWrite, ComputeStorageWrite, ComputeTexel};
use crate::graph::program::Program;
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::plan::Tiles;
use crate::plan::light_tree::LightTree;
use crate::shaders::bvh::{light_keys, light_leaves, light_nodes, light_query};
use crate::shared::{self, TREE_KEY_BITS, TreeQuery};

/// Value of TREE_FETCH.
pub fn tree_fetch(tree: &LightTree) -> u32 {
    if tree.by_texel { shared::WORDS_TEXEL } else { shared::WORDS_STORAGE }
}

/// Adds all steps; the buffer of header and entries.
pub fn add(graph: &mut Graph, tiles: &Tiles, tree: &LightTree, handles: &TileHandles) -> BufferHandle {
    let light_count = tree.shape.light_count;
    let cull_fetch = cull_fetch(tiles);
    let bytes = u64::from(light_count.max(1)) * 4;
    let [keys, lights] =
        ["light_tree_keys", "light_tree_indices"].map(|name| graph.word_buffer(name, bytes, Lifetime::Transient));
    let set = light_keys::Bindings {
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        keys: ComputeStorageWrite(keys),
        lights: ComputeStorageWrite(lights),
    };
    let spec = light_keys::Spec { CULL_FETCH: cull_fetch };
    let work = dispatch(&light_keys::PROGRAM, spec.values(), set.list(), &tree.shape, [light_count, 1]);
    graph.add("light_keys", work);
    let (_, sorted) = radix_sort::add(graph, "light_tree", keys, lights, light_count, TREE_KEY_BITS);
    let texels = graph.buffer("light_tree", tree.tree_bytes(), Lifetime::Transient);
    let set = light_leaves::Bindings {
        cull_lights_storage: ComputeStorageRead(handles.lights),
        cull_lights_texel: ComputeTexel(handles.lights),
        sorted_lights: ComputeStorageRead(sorted),
        light_tree: ComputeStorageWrite(texels),
    };
    let spec = light_leaves::Spec { CULL_FETCH: cull_fetch };
    let work = dispatch(&light_leaves::PROGRAM, spec.values(), set.list(), &tree.shape, [light_count, 1]);
    graph.add("light_leaves", work);
    for depth in (0..tree.shape.height).rev() {
        let level = tree.level(depth);
        let set = light_nodes::Bindings { light_tree: ComputeStorageReadWrite(texels) };
        let work = dispatch(&light_nodes::PROGRAM, Vec::new(), set.list(), &level, [level.count, 1]);
        graph.add(&format!("light_nodes_{depth}"), work);
    }
    texels
}

/// Adds the probe that asks the hierarchy for many boxes: four words a box and walk.
pub fn add_query(graph: &mut Graph, tree: &LightTree, texels: BufferHandle, queries: &TreeQuery) -> BufferHandle {
    let walks = tree.walk_count();
    let bytes = u64::from(queries.query_count) * u64::from(walks) * 16;
    let found = graph.word_buffer("light_query_found", bytes, Lifetime::Transient);
    let set = light_query::Bindings {
        found: ComputeStorageWrite(found),
        light_tree_storage: ComputeStorageRead(texels),
        light_tree_texel: ComputeTexel(texels),
    };
    let spec = light_query::Spec { TREE_FETCH: tree_fetch(tree) };
    let size = [queries.query_count, walks];
    graph.add("light_query", dispatch(&light_query::PROGRAM, spec.values(), set.list(), queries, size));
    found
}

/// Work of `size` threads by groups.
fn dispatch(
    program: &'static Program,
    constants: Vec<(u32, u32)>,
    bindings: Vec<Binding>,
    push: &impl Pod,
    [threads, groups]: [u32; 2],
) -> Work {
    let groups = Groups::Fixed([threads.div_ceil(program.local_size[0]).max(1), groups, 1]);
    Work::Dispatch { pipeline: ComputePipeline { program, constants }, bindings, push: bytes_of(push).to_vec(), groups }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};
    use crate::passes::SceneHandles;
    use crate::plan::{Limits, Plan, Request, Technique};
    use crate::scene::{builtin, scatter};

    fn made(lights: usize) -> (Graph, LightTree) {
        let mut scene = builtin::load("furnace").expect("a scene");
        scene.lights = scatter::point_lights(&scene.bounds(), lights, 3);
        let request = Request { width: 16, height: 16, technique: Technique::TiledForward, ..Request::default() };
        let plan = Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan");
        let mut graph = Graph::new();
        let handles = SceneHandles::declare(&mut graph, &plan).tiles.expect("tiles");
        let tiles = plan.tiles.expect("tiles");
        let tree = LightTree::new(&tiles.lights, &Limits::MINIMUM).expect("a tree");
        let before = graph.buffers.len();
        let texels = add(&mut graph, &tiles, &tree, &handles);
        let bytes: u64 = graph.buffers[before..].iter().map(|b| b.bytes).sum();
        assert_eq!(bytes, tree.bytes(), "{lights} lights");
        let queries = TreeQuery { query_count: 100, ..TreeQuery::default() };
        add_query(&mut graph, &tree, texels, &queries);
        (graph, tree)
    }

    #[test]
    fn each_level_is_ordered_after_the_one_below() {
        let (graph, tree) = made(70);
        assert_eq!(tree.shape.height, 3);
        let names: Vec<_> = graph.nodes.iter().map(|n| n.name.as_str()).collect();
        let last = ["light_leaves", "light_nodes_2", "light_nodes_1", "light_nodes_0", "light_query"];
        assert_eq!((names[0], &names[names.len() - 5..]), ("light_keys", &last[..]));
        assert!(graph.problems().is_empty());
        let mut barriers = hazard::derive(&graph);
        assert!(checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
        let of_level = |b: &hazard::Barrier| graph.nodes[b.before].name == "light_nodes_1";
        let level = barriers.iter().position(of_level).expect("a level waits for the one below");
        barriers.remove(level);
        assert!(!checker::check(&graph, &log::declared(&graph, &barriers, 3)).is_empty());
    }

    #[test]
    fn every_buffer_is_counted_whatever_the_number_of_lights() {
        for lights in [1, 8, 9, 33, 300] {
            made(lights);
        }
    }

    #[test]
    fn no_shader_binds_more_than_four_storage_buffers() {
        for program in [&light_keys::PROGRAM, &light_leaves::PROGRAM, &light_nodes::PROGRAM, &light_query::PROGRAM] {
            assert!(program.slots.iter().filter(|s| s.kind.is_storage_buffer()).count() <= 4, "{}", program.name);
        }
        assert_eq!(light_keys::PROGRAM.push_bytes as usize, size_of::<shared::TreeShape>());
        assert_eq!(light_nodes::PROGRAM.push_bytes as usize, size_of::<shared::TreeLevel>());
        assert_eq!(light_query::PROGRAM.push_bytes as usize, size_of::<TreeQuery>());
    }
}
