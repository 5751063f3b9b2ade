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
            // What is read has been written before, and an image's first use defines its layout.
            let first = !written[resource];
            let access = if first && !access.writes() { Access::TransferWrite } else { access };
            let pure_write = access.writes() && access.read_flags().is_empty();
            let access = if first && !pure_write { Access::TransferWrite } else { access };
            let fresh = first || (fresh && access.read_flags().is_empty() && access.writes());
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
        prop_assert!(graph.problems().is_empty(), "{:?}", graph.problems());
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

/// One transient image, touched by one node.
fn one_node(accesses: &[(Access, bool)]) -> Graph {
    let mut graph = Graph::new();
    let image = graph.image("image", vk::Format::R32_SFLOAT, [4, 4], Lifetime::Transient);
    let touch = |&(access, fresh): &(Access, bool)| Declared {
        name: "touch".into(),
        resource: Resource::Image(image),
        access,
        fresh,
    };
    let accesses = accesses.iter().map(touch).collect();
    graph.nodes.push(Node { name: "node".into(), accesses, work: Work::Host });
    graph
}

#[test]
fn what_cannot_be_synchronized_is_said() {
    let says = |accesses: &[(Access, bool)]| one_node(accesses).problems().join("; ");
    assert_eq!(says(&[(Access::ComputeImageWrite, true)]), "");
    assert!(says(&[(Access::ComputeImageWrite, false)]).contains("before anything defines it"));
    assert!(says(&[(Access::ComputeImageWrite, true), (Access::ComputeSampled, false)]).contains("at once"));
}

#[test]
fn reading_what_nothing_wrote_is_found() {
    let mut graph = Graph::new();
    let buffer = graph.buffer("buffer", 64, Lifetime::Transient);
    let read = Declared {
        name: "touch".into(),
        resource: Resource::Buffer(buffer),
        access: Access::ComputeStorageRead,
        fresh: false,
    };
    graph.nodes.push(Node { name: "node".into(), accesses: vec![read], work: Work::Host });
    let found = checker::check(&graph, &log::declared(&graph, &[], 1));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].problem, checker::Problem::Undefined);
}
