//! Whether two frames are made of the same things: what was made for one then draws the other.

use super::{BufferInfo, Graph, Groups, Node, Work};

impl Graph {
    /// Takes the sizes of a graph of the same shape, whose buffers are at least as large.
    ///
    /// # Errors
    /// The first thing in which they differ, in words.
    pub fn take_sizes_of(&mut self, made: &Self) -> Result<(), String> {
        if self.buffers.len() != made.buffers.len() || self.images != made.images {
            return Err("it has other images or buffers".into());
        }
        for (new, old) in self.buffers.iter().zip(&made.buffers) {
            let named = |info: &BufferInfo| (info.name.clone(), info.texel_format, info.lifetime);
            if named(new) != named(old) {
                return Err(format!("{} stands where {} was", new.name, old.name));
            }
            if new.bytes > old.bytes {
                return Err(format!("{} needs {} bytes where {} were made", new.name, new.bytes, old.bytes));
            }
        }
        let parts = |graph: &Self| (graph.once_nodes, graph.frame_nodes, graph.nodes.len());
        if parts(self) != parts(made) {
            return Err("it has other nodes".into());
        }
        if let Some((new, _)) = self.nodes.iter().zip(&made.nodes).find(|(new, old)| !same(new, old)) {
            return Err(format!("{} is another pass", new.name));
        }
        self.buffers.clone_from(&made.buffers);
        Ok(())
    }
}

/// The same pipelines and accesses; what is drawn, pushed and dispatched may differ.
fn same(a: &Node, b: &Node) -> bool {
    let work = match (&a.work, &b.work) {
        (
            Work::Dispatch { pipeline: one, push, groups, .. },
            Work::Dispatch { pipeline: other, push: pushed, groups: others, .. },
        ) => {
            let fixed = |groups: &Groups| matches!(groups, Groups::Fixed(_));
            one == other && push.len() == pushed.len() && fixed(groups) == fixed(others)
        }
        (Work::Render(one), Work::Render(other)) => {
            one.pipelines == other.pipelines
                && one.extent == other.extent
                && one.material_bindings.len() == other.material_bindings.len()
        }
        (one, other) => std::mem::discriminant(one) == std::mem::discriminant(other),
    };
    work && a.name == b.name && a.accesses == b.accesses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Lifetime;

    fn graph(bytes: u64, word: u32) -> Graph {
        let mut graph = Graph::new();
        let buffer = graph.buffer("sums", bytes, Lifetime::Transient);
        graph.add("fill", Work::Fill { buffer, word });
        graph.end_frame();
        graph
    }

    #[test]
    fn smaller_contents_fit_and_larger_ones_are_named() {
        let made = graph(64, 0);
        let mut smaller = graph(16, 7);
        assert_eq!(smaller.take_sizes_of(&made), Ok(()));
        assert_eq!(smaller.buffers[0].bytes, 64);
        let refused = graph(128, 0).take_sizes_of(&made).expect_err("too large");
        assert!(refused.contains("sums needs 128 bytes where 64 were made"), "{refused}");
        let mut other = graph(64, 0);
        other.nodes[0].name = "clear".into();
        assert!(other.take_sizes_of(&made).expect_err("another").contains("clear"));
    }
}
