//! What a node's work touches: derived from its typed bindings and attachments, so that nobody writes it twice.

use super::{Access, Binding, Declared, Resource, Work};

/// One declaration.
pub(super) fn access(name: &str, resource: Resource, access: Access, fresh: bool) -> Declared {
    Declared { name: name.into(), resource, access, fresh }
}

/// Accesses follow from typed bindings and attachments; nobody writes them twice.
pub(super) fn accesses_of(work: &Work) -> Vec<Declared> {
    let of_binding = |b: &Binding| access(b.name, b.resource, b.access, false);
    match work {
        Work::Dispatch { bindings, .. } => bindings.iter().map(of_binding).collect(),
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
                list.push(access("color", Resource::Image(color.image), Access::ColorAttachmentWrite, true));
            }
            if let Some(depth) = &render.depth {
                let kind =
                    if depth.clear.is_some() { Access::DepthAttachmentWrite } else { Access::DepthAttachmentRead };
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
