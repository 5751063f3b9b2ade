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
pub mod deferred_samples;
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
pub mod msaa_resolve;
pub mod msaa_spread;
pub mod octahedral_probe;
pub mod patch_gather;
pub mod patch_light;
pub mod patch_product;
pub mod radix_sort;
pub mod read_back;
mod resources;
pub mod sample_edges;
pub mod scan;
pub mod shadow_map;
pub mod sight;
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
use crate::plan::bounced::Carried;
use crate::plan::{Accumulation, Deferred, DepthBounds, LightPass, Plan, ShadowUpdate, Tiles};
use depth_reduce::Samples;
use transparent::Opaque;

pub use cluster_lists::{NORMAL_CODES, cluster_frame};
pub use gbuffer::gbuffer_frame;
pub use given::{given_bounds_frame, given_depth_frame};
pub use resources::{ClusterHandles, Given, SceneHandles, ShadowHandles, TileHandles};
pub use sample_edges::edges_frame;
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
    let mut scene = SceneHandles::declare(&mut graph, plan);
    if !plan.shows_surfaces() {
        let once = plan.shadow_update == ShadowUpdate::Once;
        // Light that goes on from frame to frame is gathered in each.
        let goes_on = plan.bounced.as_ref().is_some_and(|bounced| bounced.carried == Carried::Light);
        shadow_map::add(&mut graph, plan, &mut scene);
        if once && goes_on && scene.shadows.is_some() {
            graph.end_once();
        }
        patch_gather::add(&mut graph, plan, &mut scene);
        if once && !goes_on && (scene.shadows.is_some() || scene.bounced.is_some()) {
            graph.end_once();
        }
    }
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

/// The frame that leaves the light of patches when all is gathered, as `patch_light`.
pub fn patch_frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let mut scene = SceneHandles::declare(&mut graph, plan);
    shadow_map::add(&mut graph, plan, &mut scene);
    patch_gather::add(&mut graph, plan, &mut scene);
    graph.end_frame();
    let light: Vec<_> = scene.bounced.iter().map(|bounced| ("patch_light", bounced.light)).collect();
    let results = read_back::add_all(&mut graph, &[], &light);
    Frame { graph, scene, results }
}

/// The frame that leaves depths and, where the technique has them, the light lists made from them: for counting and judging.
pub fn list_frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = depth_prepass::add(&mut graph, plan, &scene);
    let blended = merged_depth(&mut graph, plan, &scene, Some(depth));
    let results = add_and_leave_lists(&mut graph, plan, &scene, depth, blended);
    Frame { graph, scene, results }
}

/// Lists of tiles, where there are any, and the end of a frame that leaves them with the depths they were made from.
fn add_and_leave_lists(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    depth: ImageHandle,
    blended: Option<ImageHandle>,
) -> Vec<(&'static str, BufferHandle)> {
    let tiles = plan.tiles.as_ref().zip(scene.tiles.as_ref());
    let made = tiles.map(|(tiles, handles)| tile_lists(graph, tiles, handles, Some(depth), blended));
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
            let MadeLists { bounds, bins, lists } = tile_lists(graph, tiles, handles, prepass, blended);
            // Asked only for positions between samples.
            let bounds = bounds.filter(|_| plan.samples > 1);
            let inputs = tiled_forward::Inputs { tiles, handles, lists, bounds, prepass };
            let target = tiled_forward::add(graph, plan, scene, &inputs);
            (target, Opaque { tiles: Some((bins, lists, bounds)), ..Opaque::default() })
        }
        _ => (forward::add(graph, plan, scene, prepass), Opaque::default()),
    };
    light_markers::add(graph, plan, scene, &target);
    let target = transparent::add(graph, plan, scene, target, opaque);
    msaa_resolve::add(graph, target.radiance)
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
    let mut layers = gbuffer::add(graph, plan, planned, scene, prepass);
    layers.edges = sample_edges::add(graph, plan, planned, scene, &layers);
    let layers = &layers;
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
            let MadeLists { bounds, bins, lists } = tile_lists(graph, tiles, handles, prepass, blended);
            let bounds = bounds.filter(|_| plan.samples > 1);
            opaque.tiles = Some((bins, lists, bounds));
            let inputs = tiled_deferred::Inputs { tiles, handles, lists, bounds, planned, layers, pixels_a_thread };
            tiled_deferred::add(graph, plan, scene, &inputs)
        }
        (light_pass, ..) => {
            let branch = matches!(light_pass, LightPass::Fullscreen { branch: true });
            match layers.edges {
                Some(_) => deferred_samples::add(graph, plan, planned, scene, layers, branch),
                None => deferred_fullscreen::add(graph, plan, planned, scene, layers, branch),
            }
        }
    };
    let radiance = msaa_spread::add(graph, plan, radiance);
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

/// The image, where it has one sample a texel; else one that is not read.
fn one_sample(graph: &Graph, scene: &SceneHandles, image: ImageHandle) -> ImageHandle {
    let white = scene.textures.last().copied().unwrap_or(image);
    if graph.image_info(image).samples == 1 { image } else { white }
}

/// The image, where it has several samples a texel.
fn several_samples(graph: &Graph, image: ImageHandle) -> Option<ImageHandle> {
    (graph.image_info(image).samples > 1).then_some(image)
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
    let plan = &Plan { samples: 1, ..plan.clone() };
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = plan.prepass.then(|| depth_prepass::add(&mut graph, plan, &scene));
    let layers = surface::add(&mut graph, plan, &scene, depth);
    graph.end_frame();
    let results = read_back::add(&mut graph, &layers);
    Frame { graph, scene, results }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Request, Technique};
    use crate::scene::builtin;

    /// Bytes of what a frame draws into and of what lights are given, by the graph.
    fn attachment_bytes(graph: &Graph) -> u64 {
        let counted = ["radiance", "depth", "gbuffer_", "sample_edges", "shadow_atlas"];
        let is_counted = |name: &str| counted.iter().any(|prefix| name.starts_with(prefix));
        let texel = |format: vk::Format| match format {
            vk::Format::R32G32B32A32_SFLOAT => 16,
            vk::Format::R16G16B16A16_SFLOAT | vk::Format::R16G16B16A16_UINT => 8,
            vk::Format::R8G8_UINT => 2,
            _ => 4,
        };
        let images = graph.images.iter().filter(|image| is_counted(&image.name));
        let bytes = |i: &crate::graph::ImageInfo| u64::from(i.width * i.height * i.samples) * texel(i.format);
        images.map(bytes).sum()
    }

    #[test]
    fn attachments_take_what_the_plan_says() {
        let limits = Limits { samples: [1 | 4; 2], float_blend: true, fragment_stores: true, ..Limits::MINIMUM };
        for name in ["cornell", "glass:layers=1"] {
            let scene = builtin::load(name).expect("a built-in scene");
            for technique in [
                Technique::Forward,
                Technique::TiledForward,
                Technique::ClusteredForward,
                Technique::Deferred,
                Technique::TiledDeferred,
                Technique::ClusteredDeferred,
            ] {
                for (msaa, prepass) in [(1, true), (4, true), (4, false)] {
                    let shadows = Some(u32::from(msaa == 1) * 2);
                    let request =
                        Request { width: 40, height: 30, technique, msaa, prepass, shadows, ..Request::default() };
                    let plan = Plan::new(&scene, &request, &limits).expect("a plan");
                    let found = attachment_bytes(&frame(&plan).graph);
                    assert_eq!(found, plan.attachment_bytes(), "{name} {technique:?} {msaa} {prepass}");
                }
            }
        }
    }
}
