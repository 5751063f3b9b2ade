//! One file an effect: each a function from handles to handles that adds nodes. [`frame`] reads as the frame's script.

pub mod ceiling;
pub mod cluster_assign;
pub mod cluster_flags;
pub mod cluster_index;
pub mod cluster_keys;
pub mod cluster_lists;
pub mod cluster_unique;
pub mod cluster_walk;
pub mod clustered_deferred;
pub mod clustered_forward;
pub mod deferred_base;
pub mod deferred_fullscreen;
pub mod depth_prepass;
pub mod depth_reduce;
pub mod forward;
pub mod gbuffer;
pub mod given;
pub mod group_count;
pub mod layout_probe;
pub mod light_markers;
pub mod light_parts;
pub mod light_tree;
pub mod light_volumes;
pub mod list_sort;
pub mod octahedral_probe;
pub mod radix_sort;
pub mod read_back;
mod resources;
pub mod scan;
pub mod surface;
pub mod tile_bin;
pub mod tile_cull;
pub mod tiled_deferred;
pub mod tiled_forward;
pub mod transparent;
pub mod transparent_compose;
pub mod transparent_depth;
pub mod unlit;

use ash::vk;

use crate::graph::program::Program;
use crate::graph::{Binding, BufferHandle, ComputePipeline, Graph, Groups, ImageHandle, SamplerState, Work};
use crate::plan::{Accumulation, Deferred, DepthBounds, LightPass, Plan, Tiles};
use depth_reduce::Samples;
use transparent::Opaque;

pub use cluster_lists::{NORMAL_CODES, cluster_frame};
pub use gbuffer::gbuffer_frame;
pub use given::{given_bounds_frame, given_depth_frame};
pub use resources::{ClusterHandles, Given, SceneHandles, TileHandles};
pub use transparent::transparent_bounds_frame;

/// Depth format: 32-bit float, reversed.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;
/// Scene-linear radiance, stored once.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Format of a lit picture: [`RADIANCE_FORMAT`], but where volumes add in fewer bits.
pub fn radiance_format(plan: &Plan) -> vk::Format {
    match plan.deferred.as_ref().map(|deferred| deferred.accumulation) {
        Some(Accumulation::F16) => vk::Format::R16G16B16A16_SFLOAT,
        _ => RADIANCE_FORMAT,
    }
}

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
    let layers: Vec<(&'static str, ImageHandle)> = if plan.shows_surfaces() {
        surface::add(&mut graph, plan, &scene, depth).to_vec()
    } else {
        vec![("radiance", lit(&mut graph, plan, &scene, depth))]
    };
    graph.end_frame();
    let results = read_back::add_pictures(&mut graph, &layers);
    Frame { graph, scene, results }
}

/// The frame that leaves depths and, where the technique has them, the light lists made from them: for counting and judging.
pub fn list_frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = depth_prepass::add(&mut graph, plan, &scene);
    let results = add_and_leave_lists(&mut graph, plan, &scene, depth);
    Frame { graph, scene, results }
}

/// Lists of tiles, where there are any, and the end of a frame that leaves them with the depths they were made from.
fn add_and_leave_lists(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    depth: ImageHandle,
) -> Vec<(&'static str, BufferHandle)> {
    let tiles = plan.tiles.as_ref().zip(scene.tiles.as_ref());
    let made = tiles.map(|(tiles, handles)| tile_lists(graph, tiles, handles, Some(depth), None));
    graph.end_frame();
    let (mut images, mut buffers) = (vec![("depth", depth)], Vec::new());
    if let Some(made) = made {
        images.extend(made.bounds.map(|bounds| ("tile_bounds", bounds)));
        buffers.extend([("bin_lights", made.bins.lights), ("bin_ranges", made.bins.ranges)]);
        buffers.extend([("list_offsets", made.lists.offsets), ("list_lights", made.lists.lights)]);
    }
    read_back::add_all(graph, &images, &buffers)
}

/// Everything that list making leaves.
struct MadeLists {
    bounds: Option<ImageHandle>,
    bins: tile_bin::Bins,
    lists: tile_cull::Lists,
}

/// `blended` are the nearest blended fragments, where bounds hold them as well.
fn tile_lists(
    graph: &mut Graph,
    tiles: &Tiles,
    handles: &TileHandles,
    depth: Option<ImageHandle>,
    blended: Option<ImageHandle>,
) -> MadeLists {
    let known = depth.filter(|_| tiles.bounds != DepthBounds::Off);
    let samples = blended.map_or(Samples::Opaque, Samples::Both);
    let bounds = known.map(|depth| depth_reduce::add(graph, tiles, handles, depth, samples));
    let bins = tile_bin::add(graph, tiles, handles);
    let lists = tile_cull::add(graph, "tile", tiles, handles, bins, bounds);
    MadeLists { bounds, bins, lists }
}

/// The nearest blended fragments, where lists of tiles are made for them and opaque surfaces alike.
fn merged_depth(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    prepass: Option<ImageHandle>,
) -> Option<ImageHandle> {
    let merged = plan.tiles.as_ref().is_some_and(|tiles| tiles.merged);
    prepass.filter(|_| merged).map(|depth| transparent_depth::add(graph, plan, scene, depth))
}

/// Shading as the technique has it, what is drawn over the picture, and blended surfaces at the end; the radiance.
fn lit(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, prepass: Option<ImageHandle>) -> ImageHandle {
    let clusters = cluster_lists::Parts::of(plan, scene);
    let (target, opaque) = match (&plan.deferred, clusters, &plan.tiles, &scene.tiles) {
        (Some(planned), ..) => deferred(graph, plan, planned, scene, prepass),
        (None, Some(parts), ..) => {
            let made = cluster_lists::add(graph, &parts, prepass, None);
            let inputs = clustered_forward::Inputs { parts, made, prepass };
            let target = clustered_forward::add(graph, plan, scene, &inputs);
            (target, Opaque { clusters: Some(made), ..Opaque::default() })
        }
        (None, None, Some(tiles), Some(handles)) => {
            let blended = merged_depth(graph, plan, scene, prepass);
            let MadeLists { bins, lists, .. } = tile_lists(graph, tiles, handles, prepass, blended);
            let inputs = tiled_forward::Inputs { tiles, handles, lists, prepass };
            let target = tiled_forward::add(graph, plan, scene, &inputs);
            (target, Opaque { tiles: Some((bins, lists)), ..Opaque::default() })
        }
        _ => (forward::add(graph, plan, scene, prepass), Opaque::default()),
    };
    light_markers::add(graph, plan, scene, &target);
    transparent::add(graph, plan, scene, target, opaque).radiance
}

/// G-buffer, the lights over it, and the surfaces that no light changes; with what was made to list lights.
fn deferred(
    graph: &mut Graph,
    plan: &Plan,
    deferred: &Deferred,
    scene: &SceneHandles,
    prepass: Option<ImageHandle>,
) -> (forward::Io, Opaque) {
    let planned = &deferred.gbuffer;
    let layers = &gbuffer::add(graph, plan, planned, scene, prepass);
    let clusters = cluster_lists::Parts::of(plan, scene);
    let mut opaque = Opaque::default();
    let radiance = match (&deferred.light_pass, clusters, &plan.tiles, &scene.tiles) {
        (LightPass::Volumes(volumes), ..) => {
            let radiance = deferred_base::add(graph, plan, planned, scene, layers);
            let inputs = light_volumes::Inputs { volumes, planned, layers, radiance };
            light_volumes::add(graph, plan, scene, &inputs);
            radiance
        }
        (LightPass::Clusters, Some(parts), ..) => {
            let made = cluster_lists::add(graph, &parts, prepass, Some(layers.normals));
            opaque.clusters = Some(made);
            clustered_deferred::add(graph, plan, scene, &clustered_deferred::Inputs { parts, made, planned, layers })
        }
        (&LightPass::Tiles { pixels_a_thread }, _, Some(tiles), Some(handles)) => {
            let blended = merged_depth(graph, plan, scene, prepass);
            let MadeLists { bins, lists, .. } = tile_lists(graph, tiles, handles, prepass, blended);
            opaque.tiles = Some((bins, lists));
            let inputs = tiled_deferred::Inputs { tiles, handles, lists, planned, layers, pixels_a_thread };
            tiled_deferred::add(graph, plan, scene, &inputs)
        }
        (light_pass, ..) => {
            let branch = matches!(light_pass, LightPass::Fullscreen { branch: true });
            deferred_fullscreen::add(graph, plan, planned, scene, layers, branch)
        }
    };
    let target = forward::Io { radiance, depth: layers.depth };
    unlit::add(graph, plan, scene, &target);
    (target, opaque)
}

/// A compute node's work without push constants.
fn dispatch(program: &'static Program, constants: Vec<(u32, u32)>, bindings: Vec<Binding>, groups: [u32; 3]) -> Work {
    dispatch_groups(program, constants, bindings, Groups::Fixed(groups))
}

/// The same over any groups.
fn dispatch_groups(
    program: &'static Program,
    constants: Vec<(u32, u32)>,
    bindings: Vec<Binding>,
    groups: Groups,
) -> Work {
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
