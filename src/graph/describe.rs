//! Barrier listings and the DOT drawing of a graph: text that people read and tests compare.

use std::fmt::Write;

use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use super::hazard::{Barrier, Hazard, Producer};
use super::{Graph, Resource};

/// Set bits by name, joined with `|`; "none" without any.
fn flags(bits: u64, names: impl Fn(u64) -> String) -> String {
    let parts: Vec<_> = (0..64).map(|i| 1u64 << i).filter(|b| bits & b != 0).map(names).collect();
    if parts.is_empty() { "none".into() } else { parts.join("|") }
}

/// Stage names as the specification spells them, without the prefix.
pub fn stages(mask: PipelineStageFlags2) -> String {
    flags(mask.as_raw(), |bit| format!("{:?}", PipelineStageFlags2::from_raw(bit)))
}

/// Access names as the specification spells them, without the prefix.
pub fn accesses(mask: AccessFlags2) -> String {
    flags(mask.as_raw(), |bit| format!("{:?}", AccessFlags2::from_raw(bit)))
}

fn layout(l: ImageLayout) -> String {
    format!("{l:?}")
}

fn producer(p: &Producer) -> String {
    let frame = if p.previous_frame { " (previous frame)" } else { "" };
    format!("{} {}{frame}", p.node, p.access.name())
}

/// The table of `plan --barriers`: a block a node, two lines a barrier and one more where the layout changes.
pub fn listing(graph: &Graph, barriers: &[Barrier]) -> String {
    let mut out = String::new();
    for (index, node) in graph.nodes.iter().enumerate() {
        if index == 0 && graph.once_nodes > 0 {
            out.push_str("-- before the first frame, once\n");
        }
        if index == graph.once_nodes && index > 0 {
            out.push_str("-- every frame\n");
        }
        if index == graph.frame_len() {
            out.push_str("-- read-back, once\n");
        }
        writeln!(out, "{}", node.name).unwrap_or_default();
        for b in barriers.iter().filter(|b| b.before == index) {
            let from = if b.producers.is_empty() {
                "(nothing before)".to_string()
            } else {
                b.producers.iter().map(producer).collect::<Vec<_>>().join(" + ")
            };
            let _ = writeln!(
                out,
                "  {:<6} {}: {from} -> {} {}",
                b.hazard.name(),
                graph.name_of(b.resource),
                node.name,
                b.consumer.name()
            );
            let _ = writeln!(
                out,
                "         {} {} -> {} {}",
                stages(b.src_stages),
                accesses(b.src_access),
                stages(b.dst_stages),
                accesses(b.dst_access)
            );
            if matches!(b.resource, Resource::Image(_)) && b.layouts.0 != b.layouts.1 {
                let _ = writeln!(out, "         layout {} -> {}", layout(b.layouts.0), layout(b.layouts.1));
            }
        }
    }
    out
}

/// One barrier as an English sentence.
pub fn sentence(graph: &Graph, barrier: &Barrier) -> String {
    let name = graph.name_of(barrier.resource);
    let node = &graph.nodes[barrier.before].name;
    let from = barrier.producers.iter().map(producer).collect::<Vec<_>>().join(" and ");
    match barrier.hazard {
        Hazard::Raw => format!("{node} reads {name} only after {from} has written it and the writes are visible."),
        Hazard::War => format!("{node} writes {name} only after {from} has read what was there."),
        Hazard::Waw => format!("{node} writes {name} only after {from} has finished writing it."),
        Hazard::Layout if from.is_empty() => format!("{name} takes the layout that {node} needs."),
        Hazard::Layout => format!("{name} changes its layout for {node} after {from}."),
    }
}

/// The graph in DOT: nodes as boxes, hazards as arrows labelled with the resource.
pub fn dot(graph: &Graph, barriers: &[Barrier]) -> String {
    let mut out = String::from("digraph frame {\n  rankdir=LR;\n  node [shape=box, fontname=\"monospace\"];\n");
    for node in &graph.nodes {
        let _ = writeln!(out, "  \"{}\";", node.name);
    }
    for pair in graph.nodes.windows(2) {
        let _ = writeln!(out, "  \"{}\" -> \"{}\" [style=invis];", pair[0].name, pair[1].name);
    }
    for b in barriers {
        for p in &b.producers {
            let style = if p.previous_frame { ", style=dashed, constraint=false" } else { "" };
            let _ = writeln!(
                out,
                "  \"{}\" -> \"{}\" [label=\"{} {}\"{style}];",
                p.node,
                graph.nodes[b.before].name,
                graph.name_of(b.resource),
                b.hazard.name()
            );
        }
    }
    out.push_str("}\n");
    out
}
