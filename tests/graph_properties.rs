//! Random graphs: the derived barriers satisfy the checker, and each of them is needed.

use ash::vk;
use lampyris::graph::hazard::{self, Hazard};
use lampyris::graph::{
    Access, BufferHandle, Declared, Graph, ImageHandle, Lifetime, Node, Resource, Work, checker, log,
};
use proptest::prelude::*;

const BUFFER_ACCESSES: &[Access] = &[
    Access::ComputeStorageRead,
    Access::ComputeStorageWrite,
    Access::ComputeStorageReadWrite,
    Access::ComputeTexel,
    Access::VertexStorageRead,
    Access::FragmentStorageRead,
    Access::IndirectRead,
    Access::TransferRead,
    Access::TransferWrite,
    Access::ClearWrite,
];

const IMAGE_ACCESSES: &[Access] = &[
    Access::ComputeSampled,
    Access::ComputeImageRead,
    Access::ComputeImageWrite,
    Access::ComputeImageReadWrite,
    Access::FragmentSampled,
    Access::ColorAttachmentWrite,
    Access::ColorAttachmentReadWrite,
    Access::TransferRead,
    Access::TransferWrite,
];

/// Resources 0 to 2 are buffers, 3 and 4 images; a node touches some of them, each once.
fn graphs() -> impl Strategy<Value = Vec<Vec<(usize, usize, bool)>>> {
    let touch = (0usize..5, 0usize..64, any::<bool>());
    prop::collection::vec(prop::collection::vec(touch, 1..4), 1..7)
}

fn build(nodes: &[Vec<(usize, usize, bool)>]) -> Graph {
    let mut graph = Graph::new();
    let buffers: Vec<BufferHandle> =
        (0..3).map(|i| graph.buffer(&format!("buffer {i}"), 64, Lifetime::Transient)).collect();
    let format = vk::Format::R32G32B32A32_SFLOAT;
    let images: Vec<ImageHandle> =
        (0..2).map(|i| graph.image(&format!("image {i}"), format, [4, 4], Lifetime::Transient)).collect();
    let mut written = [false; 5];
    for (index, touches) in nodes.iter().enumerate() {
        let mut accesses: Vec<Declared> = Vec::new();
        for &(resource, kind, fresh) in touches {
            let (handle, access) = match resource {
                0..3 => (Resource::Buffer(buffers[resource]), BUFFER_ACCESSES[kind % BUFFER_ACCESSES.len()]),
                _ => (Resource::Image(images[resource - 3]), IMAGE_ACCESSES[kind % IMAGE_ACCESSES.len()]),
            };
            if accesses.iter().any(|a| a.resource == handle) {
                continue;
            }
            // Contents are discarded only by pure writes; an image's first use is one, so that a layout is defined.
            let pure_write = access.writes() && access.read_flags().is_empty();
            let access = if resource >= 3 && !written[resource] { Access::TransferWrite } else { access };
            let fresh = (fresh && pure_write) || (resource >= 3 && !written[resource]);
            written[resource] = true;
            accesses.push(Declared { name: format!("touch {resource}"), resource: handle, access, fresh });
        }
        graph.nodes.push(Node { name: format!("node {index}"), accesses, work: Work::Host });
    }
    graph
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn derived_barriers_order_every_access(nodes in graphs()) {
        let graph = build(&nodes);
        let barriers = hazard::derive(&graph);
        let found = checker::check(&graph, &log::declared(&graph, &barriers, 3));
        prop_assert!(found.is_empty(), "{found:#?}\n{}", lampyris::graph::describe::listing(&graph, &barriers));
    }

    #[test]
    fn removing_any_barrier_is_found(nodes in graphs()) {
        let graph = build(&nodes);
        let barriers = hazard::derive(&graph);
        for index in 0..barriers.len() {
            let mut fewer = barriers.clone();
            let removed = fewer.remove(index);
            let found = checker::check(&graph, &log::declared(&graph, &fewer, 3));
            prop_assert!(!found.is_empty(), "not needed: {}", lampyris::graph::describe::sentence(&graph, &removed));
        }
    }

    #[test]
    fn weakening_a_memory_barrier_is_found(nodes in graphs()) {
        let graph = build(&nodes);
        let barriers = hazard::derive(&graph);
        for index in 0..barriers.len() {
            if barriers[index].hazard != Hazard::Raw || barriers[index].layouts.0 != barriers[index].layouts.1 {
                continue;
            }
            let mut weaker = barriers.clone();
            weaker[index].dst_access = vk::AccessFlags2::NONE;
            let found = checker::check(&graph, &log::declared(&graph, &weaker, 3));
            prop_assert!(!found.is_empty(), "invisible: {}", lampyris::graph::describe::sentence(&graph, &barriers[index]));
        }
    }
}
