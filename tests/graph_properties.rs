//! Random graphs: the derived barriers satisfy the checker, and each of them is needed.

use std::time::{Duration, Instant};

use ash::vk;
use lampyris::graph::hazard::{self, Barrier, Hazard};
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
    Access::GraphicsStorageRead,
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
    Access::DepthAttachmentRead,
    Access::DepthAttachmentWrite,
    Access::TransferRead,
    Access::TransferWrite,
];

/// Attachments that a pass reads and may all the same clear first: blended into, or tested against.
const CLEARED: &[Access] = &[Access::ColorAttachmentReadWrite, Access::DepthAttachmentWrite];

/// What each node touches, and how many of the nodes run once before the frame, and read back.
type Touches = (Vec<Vec<(usize, usize, bool)>>, usize, usize);

/// Resources 0 to 2 are buffers, 3 and 4 images; a node touches some of them, each once.
fn graphs(most: usize) -> impl Strategy<Value = Touches> {
    let touch = (0usize..5, 0usize..64, any::<bool>());
    (prop::collection::vec(prop::collection::vec(touch, 1..4), 1..most), 0usize..3, 0usize..4)
}

fn build((nodes, once, tail): &Touches) -> Graph {
    let mut graph = Graph::new();
    let buffers: Vec<BufferHandle> =
        (0..3).map(|i| graph.buffer(&format!("buffer {i}"), 64, Lifetime::Transient)).collect();
    let format = vk::Format::R32G32B32A32_SFLOAT;
    let images: Vec<ImageHandle> =
        (0..2).map(|i| graph.image(&format!("image {i}"), format, [4, 4], Lifetime::Transient)).collect();
    let mut written = [false; 5];
    let mut once_written = [false; 5];
    let frame_end = nodes.len().saturating_sub(*tail).max(1);
    let once = (*once).min(frame_end - 1);
    for (index, touches) in nodes.iter().enumerate() {
        if index == once {
            once_written = written;
            graph.end_once();
        }
        if index == frame_end {
            graph.end_frame();
        }
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
            let may_discard = |a: Access| a.writes() && (a.read_flags().is_empty() || CLEARED.contains(&a));
            let access = if first && !may_discard(access) { Access::TransferWrite } else { access };
            let fresh = first || (fresh && may_discard(access));
            // What was written once is only read in every frame, and always in one layout.
            let access = match (index >= once && once_written[resource], resource) {
                (false, _) => access,
                (true, 0..3) => Access::ComputeStorageRead,
                (true, _) => Access::FragmentSampled,
            };
            let fresh = fresh && !(index >= once && once_written[resource]);
            written[resource] = true;
            accesses.push(Declared { name: format!("touch {resource}"), resource: handle, access, fresh });
        }
        graph.nodes.push(Node { name: format!("node {index}"), accesses, work: Work::Host });
    }
    if frame_end == nodes.len() {
        graph.end_frame();
    }
    graph
}

/// The definition of what [`hazard::derive`] leaves out: one question to the checker for each barrier that only waits.
fn pruned_by_the_checker(graph: &Graph) -> Vec<Barrier> {
    let mut barriers = hazard::derive_each(graph);
    let mut index = 0;
    while index < barriers.len() {
        let b = &barriers[index];
        if b.src_access.is_empty() && b.dst_access.is_empty() && b.layouts.0 == b.layouts.1 {
            let removed = barriers.remove(index);
            if checker::check(graph, &log::declared(graph, &barriers, 3)).is_empty() {
                continue;
            }
            barriers.insert(index, removed);
        }
        index += 1;
    }
    barriers
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn derived_barriers_order_every_access(nodes in graphs(7)) {
        let graph = build(&nodes);
        prop_assert!(graph.problems().is_empty(), "{:?}", graph.problems());
        let barriers = hazard::derive(&graph);
        let found = checker::check(&graph, &log::declared(&graph, &barriers, 3));
        prop_assert!(found.is_empty(), "{found:#?}\n{}", lampyris::graph::describe::listing(&graph, &barriers));
    }

    #[test]
    fn removing_any_barrier_is_found(nodes in graphs(7)) {
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
    fn what_is_left_out_is_what_the_checker_does_not_miss(nodes in graphs(14)) {
        let graph = build(&nodes);
        prop_assert_eq!(hazard::derive(&graph), pruned_by_the_checker(&graph));
    }

    #[test]
    fn weakening_a_memory_barrier_is_found(nodes in graphs(7)) {
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

/// Asking the checker about each wait takes minutes here.
#[test]
fn long_graphs_are_derived_at_once() {
    const WRITES: [Access; 3] = [Access::ComputeStorageWrite, Access::TransferWrite, Access::ClearWrite];
    const READS: [Access; 5] = [
        Access::ComputeStorageRead,
        Access::FragmentStorageRead,
        Access::VertexStorageRead,
        Access::IndirectRead,
        Access::TransferRead,
    ];
    let mut graph = Graph::new();
    let mut buffers = Vec::new();
    for index in 0..400 {
        let written = graph.buffer(&format!("buffer {index}"), 64, Lifetime::Transient);
        buffers.push(written);
        let touch = |buffer, access| Declared {
            name: "touch".into(),
            resource: Resource::Buffer(buffer),
            access,
            fresh: false,
        };
        let mut accesses = vec![touch(written, WRITES[index % 3])];
        let earlier = 7919usize.checked_rem(index);
        accesses.extend(earlier.map(|e| touch(buffers[e], READS[index * 3 % 7 % 5])));
        graph.nodes.push(Node { name: format!("node {index}"), accesses, work: Work::Host });
    }
    let start = Instant::now();
    let barriers = hazard::derive(&graph);
    let elapsed = start.elapsed();
    // A few milliseconds; the rest is for a busy machine.
    assert!(elapsed < Duration::from_millis(500), "{elapsed:?}");
    assert!(barriers.len() < hazard::derive_each(&graph).len());
    let found = checker::check(&graph, &log::declared(&graph, &barriers, 3));
    assert!(found.is_empty(), "{:?}", found.first());
}
