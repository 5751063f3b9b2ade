//! What a node's work touches: derived from its typed bindings and attachments, so that nobody writes it twice.

use std::collections::BTreeSet;

use super::{Access, Binding, Declared, Graph, Groups, Lifetime, Node, Resource, Work};

/// One declaration.
pub(super) fn access(name: &str, resource: Resource, access: Access, fresh: bool) -> Declared {
    Declared { name: name.into(), resource, access, fresh }
}

/// Every access of a node.
pub(super) fn accesses_of(work: &Work) -> Vec<Declared> {
    let of_binding = |b: &Binding| access(b.name, b.resource, b.access, b.fresh);
    match work {
        Work::Dispatch { bindings, groups, .. } => {
            let mut list: Vec<_> = bindings.iter().map(of_binding).collect();
            if let Groups::Indirect(buffer) = groups {
                list.push(access("groups", Resource::Buffer(*buffer), Access::IndirectRead, false));
            }
            list
        }
        Work::Render(render) => {
            let mut list: Vec<_> = render.bindings.iter().map(of_binding).collect();
            for binding in render.material_bindings.iter().flatten() {
                let declared = of_binding(binding);
                if !list.iter().any(|d| d.resource == declared.resource && d.access == declared.access) {
                    list.push(declared);
                }
            }
            let buffers =
                [("vertices", render.vertices, Access::VertexAttribute), ("indices", render.indices, Access::Index)];
            for (name, buffer, kind) in buffers {
                list.extend(buffer.map(|b| access(name, Resource::Buffer(b), kind, false)));
            }
            for color in &render.colors {
                let kind = render.color_access(color);
                list.push(access("color", Resource::Image(color.image), kind, color.clear.is_some()));
            }
            if let Some(depth) = &render.depth {
                let kind = render.depth_access(depth);
                list.push(access("depth", Resource::Image(depth.image), kind, depth.clear.is_some()));
            }
            list
        }
        Work::CopyBuffer { from, to } => vec![
            access("from", Resource::Buffer(*from), Access::TransferRead, false),
            access("to", Resource::Buffer(*to), Access::TransferWrite, true),
        ],
        Work::CopyImageToBuffer { from, to } => vec![
            access("from", Resource::Image(*from), Access::TransferRead, false),
            access("to", Resource::Buffer(*to), Access::TransferWrite, true),
        ],
        Work::Fill { buffer, .. } => {
            vec![access("buffer", Resource::Buffer(*buffer), Access::ClearWrite, true)]
        }
        Work::Host => Vec::new(),
    }
}

/// What the frame reads of that which was written once before it: for each way to read, all that is read so. Barriers of one node do
/// not wait for each other, so each way has a node.
pub(super) fn handed_over(graph: &Graph) -> Vec<Vec<Declared>> {
    let (once, frame) = graph.nodes.split_at(graph.once_nodes);
    let written: BTreeSet<Resource> =
        once.iter().flat_map(|n| &n.accesses).filter(|d| d.access.writes()).map(|d| d.resource).collect();
    let mut list: Vec<Vec<Declared>> = Vec::new();
    for declared in frame.iter().flat_map(|n| &n.accesses).filter(|d| written.contains(&d.resource)) {
        match list.iter_mut().find(|way| way[0].access == declared.access) {
            Some(way) if way.iter().any(|known| known.resource == declared.resource) => {}
            Some(way) => way.push(declared.clone()),
            None => list.push(vec![declared.clone()]),
        }
    }
    list
}

/// See [`Graph::problems`].
pub(super) fn problems(graph: &Graph) -> Vec<String> {
    let mut found = Vec::new();
    let mut defined = BTreeSet::new();
    for node in &graph.nodes {
        for declared in &node.accesses {
            let Resource::Image(image) = declared.resource else { continue };
            let transient = graph.image_info(image).lifetime == Lifetime::Transient;
            if defined.insert(image) && transient && !declared.fresh {
                found.push(format!(
                    "{}: {} is used before anything defines it",
                    node.name,
                    graph.image_info(image).name
                ));
            }
        }
        found.extend(clashes(graph, node));
    }
    found
}

fn clashes(graph: &Graph, node: &Node) -> Vec<String> {
    let mut found = Vec::new();
    for (index, a) in node.accesses.iter().enumerate() {
        for b in &node.accesses[index + 1..] {
            let same = a.resource == b.resource && a.access != b.access;
            let layouts = matches!(a.resource, Resource::Image(_)) && a.access.layout() != b.access.layout();
            if same && (a.access.writes() || b.access.writes() || layouts) {
                let (name, a, b) = (graph.name_of(a.resource), a.access.name(), b.access.name());
                found.push(format!("{}: {name} is touched by {a} and {b} at once", node.name));
            }
        }
    }
    found
}
