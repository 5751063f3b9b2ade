//! One file an effect: each a function from handles to handles that adds nodes. [`frame`] reads as the frame's script.

pub mod ceiling;
pub mod depth_prepass;
pub mod forward;
pub mod layout_probe;
pub mod read_back;
mod resources;
pub mod surface;

use crate::graph::{BufferHandle, Graph, ImageHandle};
use crate::plan::Plan;

pub use resources::SceneHandles;

/// Depth format: 32-bit float, reversed.
pub const DEPTH_FORMAT: ash::vk::Format = ash::vk::Format::D32_SFLOAT;
/// Scene-linear radiance, stored once.
pub const RADIANCE_FORMAT: ash::vk::Format = ash::vk::Format::R32G32B32A32_SFLOAT;

/// A whole frame and where its results are.
pub struct Frame {
    /// Nodes and resources.
    pub graph: Graph,
    /// Static resources, to be filled before the first frame.
    pub scene: SceneHandles,
    /// Results on the host's side, by layer name.
    pub results: Vec<(&'static str, BufferHandle)>,
}

/// The script of a frame: depth, shading, and once at the end the read-back.
pub fn frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = plan.prepass.then(|| depth_prepass::add(&mut graph, plan, &scene));
    let layers: Vec<(&'static str, ImageHandle)> = if plan.debug_view.is_some() {
        surface::add(&mut graph, plan, &scene, depth).to_vec()
    } else {
        vec![("radiance", forward::add(&mut graph, plan, &scene, depth).radiance)]
    };
    graph.end_frame();
    let results = read_back::add(&mut graph, &layers);
    Frame { graph, scene, results }
}

/// The frame that stores what lights see instead of lighting it: same geometry, same depth, same surfaces.
pub fn surface_frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = plan.prepass.then(|| depth_prepass::add(&mut graph, plan, &scene));
    let layers = surface::add(&mut graph, plan, &scene, depth);
    graph.end_frame();
    let results = read_back::add(&mut graph, &layers);
    Frame { graph, scene, results }
}
