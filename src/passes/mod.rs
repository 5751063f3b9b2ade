//! One file an effect: each a function from handles to handles that adds nodes. [`frame`] reads as the frame's script.

pub mod ceiling;
pub mod depth_prepass;
pub mod depth_reduce;
pub mod forward;
pub mod layout_probe;
pub mod radix_sort;
pub mod read_back;
mod resources;
pub mod scan;
pub mod surface;
pub mod tile_bin;
pub mod tile_cull;
pub mod tiled_forward;

use ash::vk;

use crate::graph::program::Program;
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, ImageHandle, SamplerState, Work};
use crate::plan::{DepthBounds, Plan, Tiles};

pub use resources::{SceneHandles, TileHandles};

/// Depth format: 32-bit float, reversed.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;
/// Scene-linear radiance, stored once.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

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
        vec![("radiance", lit(&mut graph, plan, &scene, depth))]
    };
    graph.end_frame();
    let results = read_back::add(&mut graph, &layers);
    Frame { graph, scene, results }
}

/// The frame that makes light lists and leaves them, with the depths they were made from: for counting and judging.
/// `None` where the technique has no lists.
pub fn list_frame(plan: &Plan) -> Option<Frame> {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let (tiles, handles) = (plan.tiles.as_ref()?, scene.tiles?);
    let depth = depth_prepass::add(&mut graph, plan, &scene);
    let made = tile_lists(&mut graph, tiles, &handles, Some(depth));
    graph.end_frame();
    let mut images = vec![("depth", depth)];
    images.extend(made.bounds.map(|bounds| ("tile_bounds", bounds)));
    let buffers = [("bin_lights", made.bins.lights), ("bin_ranges", made.bins.ranges)];
    let lists = [("list_offsets", made.lists.offsets), ("list_lights", made.lists.lights)];
    let results = read_back::add_all(&mut graph, &images, &[buffers, lists].concat());
    Some(Frame { graph, scene, results })
}

/// Everything that list making leaves.
struct MadeLists {
    bounds: Option<ImageHandle>,
    bins: tile_bin::Bins,
    lists: tile_cull::Lists,
}

fn tile_lists(graph: &mut Graph, tiles: &Tiles, handles: &TileHandles, depth: Option<ImageHandle>) -> MadeLists {
    let known = depth.filter(|_| tiles.bounds != DepthBounds::Off);
    let bounds = known.map(|depth| depth_reduce::add(graph, tiles, handles, depth));
    let bins = tile_bin::add(graph, tiles, handles);
    let lists = tile_cull::add(graph, tiles, handles, bins, bounds);
    MadeLists { bounds, bins, lists }
}

/// Lists and shading, as the technique has them; the radiance.
fn lit(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, depth: Option<ImageHandle>) -> ImageHandle {
    let (Some(tiles), Some(handles)) = (&plan.tiles, &scene.tiles) else {
        return forward::add(graph, plan, scene, depth).radiance;
    };
    let lists = tile_lists(graph, tiles, handles, depth).lists;
    let inputs = tiled_forward::Inputs { tiles, handles, lists, prepass: depth };
    tiled_forward::add(graph, plan, scene, &inputs)
}

/// A compute node's work without push constants.
fn dispatch(program: &'static Program, constants: Vec<(u32, u32)>, bindings: Vec<Binding>, groups: [u32; 3]) -> Work {
    Work::Dispatch { pipeline: ComputePipeline { program, constants }, bindings, push: Vec::new(), groups }
}

/// For images that are read texel by texel.
fn nearest_sampler() -> SamplerState {
    SamplerState {
        mag: vk::Filter::NEAREST,
        min: vk::Filter::NEAREST,
        mip: vk::SamplerMipmapMode::NEAREST,
        wrap: [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2],
        mipmapped: false,
    }
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
