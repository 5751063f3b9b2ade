//! Transparency: blended surfaces over the picture of any technique, from back to front, lit by the lights that reach them.
//!
//! Reads: what the forward pass of the technique's lists reads; depth, tested and not written. Reads and writes: radiance, by blending
//! (alpha over; alpha of the picture grows to 1). Where 32-bit floats do not blend, surfaces are mixed in a layer of 16-bit floats,
//! cleared to nothing, which `transparent_compose` mixes with the picture. Lists of tiles and clusters of their own are made first. Limits: one
//! pass adds every light (`plan/transparency.rs`). CPU twin: `reference/render.rs`.

use ash::vk;

use super::cluster_assign::{self, Candidates};
use super::cluster_lists::{ClusterLists, Parts};
use super::depth_reduce::Samples;
use super::forward::{self, Io};
use super::light_parts::Part;
use super::resources::blended;
use super::tile_bin::Bins;
use super::tile_cull::Lists;
use super::{
    Frame, SceneHandles, cluster_flags, clustered_forward, depth_prepass, depth_reduce, nearest_sampler,
    radiance_format, read_back, tile_cull, tiled_forward, transparent_compose, transparent_depth,
};
use crate::graph::access::FragmentSampled;
use crate::graph::{ColorAttachment, DepthAttachment, Graph, ImageHandle, Render, Work};
use crate::plan::{Clusters, DepthBounds, Plan, Transparency, TransparentLists};
use crate::shared::{CLUSTER_OF_RANK, CLUSTER_OF_SLICE};

/// Format of the layer that surfaces are mixed in where 32-bit floats do not blend; every driver blends it.
const LAYER_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// What was made for opaque surfaces.
#[derive(Debug, Clone, Copy, Default)]
pub struct Opaque {
    /// Lists of bins and of tiles, and what these know of depths.
    pub tiles: Option<(Bins, Lists, Option<ImageHandle>)>,
    /// Lists of clusters.
    pub clusters: Option<ClusterLists>,
}

/// Where fragments find their lights.
enum Found<'a> {
    All,
    Tiles(tiled_forward::Inputs<'a>),
    Clusters(clustered_forward::Inputs<'a>),
}

/// Format that blended surfaces are drawn into.
pub(super) fn format(plan: &Plan) -> vk::Format {
    let layer = plan.transparency.as_ref().is_some_and(|planned| planned.layer);
    if layer { LAYER_FORMAT } else { radiance_format(plan) }
}

/// Adds the passes; what the picture is in afterwards. Nothing where nothing is blended.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &SceneHandles, target: Io, opaque: Opaque) -> Io {
    let Some(planned) = &plan.transparency else { return target };
    let found = find(graph, plan, scene, planned, target.depth, opaque);
    let extent = [plan.view.width, plan.view.height];
    let layer = planned.layer.then(|| graph.image_of_samples("transparent_layer", LAYER_FORMAT, extent, plan.samples));
    let image = layer.unwrap_or(target.radiance);
    let nothing = FragmentSampled(scene.textures.last().copied().unwrap_or(image), nearest_sampler());
    let part = Part { first: true, last: true, lights: u32::MAX, target: image, before: nothing };
    let (variants, draws) = blended(plan);
    let (bindings, pipelines) = match &found {
        Found::All => {
            let of = |&v: &_| forward::pipeline(plan, v, &part, false);
            (forward::bindings(scene, &part), variants.iter().map(of).collect())
        }
        Found::Tiles(inputs) => {
            let of = |&v: &_| tiled_forward::pipeline(plan, inputs, v, &part);
            (tiled_forward::bindings(scene, inputs, &part), variants.iter().map(of).collect())
        }
        Found::Clusters(inputs) => {
            let of = |&v: &_| clustered_forward::pipeline(plan, inputs, v, &part);
            (clustered_forward::bindings(scene, inputs, &part), variants.iter().map(of).collect())
        }
    };
    let render = Render {
        colors: vec![ColorAttachment { image, clear: layer.map(|_| [0.0; 4]) }],
        depth: Some(DepthAttachment { image: target.depth, clear: None }),
        extent,
        bindings,
        material_bindings: scene.material_bindings.clone(),
        pipelines,
        draws,
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("transparent", Work::Render(render));
    match layer {
        Some(layer) => Io { radiance: transparent_compose::add(graph, plan, scene, target.radiance, layer), ..target },
        None => target,
    }
}

/// The frame that makes bounds of tiles which hold blended fragments, and leaves them with the depths that they were made from. `None`
/// where the plan makes none.
pub fn transparent_bounds_frame(plan: &Plan) -> Option<Frame> {
    let planned = plan.transparency.as_ref().filter(|planned| planned.needs_depth(plan))?;
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let (tiles, handles) = (plan.tiles.as_ref()?, scene.tiles?);
    let depth = depth_prepass::add(&mut graph, plan, &scene);
    let nearest = transparent_depth::add(&mut graph, plan, &scene, depth);
    let merged = matches!(planned.lists, TransparentLists::Shared);
    let samples = if merged { Samples::Both(nearest) } else { Samples::Blended(nearest) };
    let bounds = depth_reduce::add(&mut graph, tiles, &handles, depth, samples);
    graph.end_frame();
    let images = [("depth", depth), ("transparent_depth", nearest), ("tile_bounds", bounds)];
    let results = read_back::add_all(&mut graph, &images, &[]);
    Some(Frame { graph, scene, results })
}

fn find<'a>(
    graph: &mut Graph,
    plan: &'a Plan,
    scene: &'a SceneHandles,
    planned: &'a Transparency,
    depth: ImageHandle,
    opaque: Opaque,
) -> Found<'a> {
    let parts = Parts::of(plan, scene);
    let tiles = plan.tiles.as_ref().zip(scene.tiles.as_ref());
    let Some((tiles, handles)) = tiles else { return Found::All };
    // Lists of bins are made for either kind of cells.
    let bins = opaque.tiles.map(|made| made.0).or_else(|| opaque.clusters.and_then(|made| made.bins));
    let tiled =
        |(lists, bounds)| Found::Tiles(tiled_forward::Inputs { tiles, handles, lists, bounds, prepass: Some(depth) });
    let clustered = |parts, made| Found::Clusters(clustered_forward::Inputs { parts, made, prepass: Some(depth) });
    match (&planned.lists, parts, opaque.clusters, bins) {
        (TransparentLists::Clusters(clusters), Some(parts), Some(made), _) => {
            let parts = Parts { clusters, ..parts };
            let made = of_clusters(graph, plan, scene, &parts, made, depth);
            clustered(parts, made)
        }
        (TransparentLists::Shared, Some(parts), Some(made), _) => clustered(parts, made),
        (&TransparentLists::Tiles { bounds }, _, _, Some(bins)) => {
            tiled(of_tiles_alone(graph, plan, scene, bins, (depth, bounds)))
        }
        _ => opaque.tiles.map_or(Found::All, |(_, lists, bounds)| tiled((lists, bounds))),
    }
}

/// Lists of tiles for blended surfaces.
fn of_tiles_alone(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    bins: Bins,
    (depth, known): (ImageHandle, DepthBounds),
) -> (Lists, Option<ImageHandle>) {
    let (Some(tiles), Some(handles)) = (&plan.tiles, &scene.tiles) else { unreachable!("lists of tiles were planned") };
    let bounds = (known != DepthBounds::Off).then(|| {
        let nearest = transparent_depth::add(graph, plan, scene, depth);
        depth_reduce::add(graph, tiles, handles, depth, Samples::Blended(nearest))
    });
    (tile_cull::add(graph, "transparent_tile", tiles, handles, bins, bounds), bounds.filter(|_| plan.samples > 1))
}

/// Lists of clusters for blended surfaces: of the flagged ones, or of all.
fn of_clusters(
    graph: &mut Graph,
    plan: &Plan,
    scene: &SceneHandles,
    parts: &Parts,
    opaque: ClusterLists,
    depth: ImageHandle,
) -> ClusterLists {
    let clusters: &Clusters = parts.clusters;
    let known = if clusters.keyed { parts.tiles.bounds } else { DepthBounds::Off };
    let candidates = match (&clusters.tree, opaque.tree, opaque.bins) {
        (Some(source), Some(texels), _) => Candidates::Tree(source, texels),
        (_, _, Some(bins)) => Candidates::Tiles(of_tiles_alone(graph, plan, scene, bins, (depth, known)).0),
        _ => unreachable!("clusters have candidates"),
    };
    let flagged = clusters.keyed.then(|| cluster_flags::add(graph, plan, scene, parts, depth));
    let (keyed, index) = flagged.unzip();
    let inputs = cluster_assign::Inputs {
        name: "transparent_cluster",
        tiles: parts.tiles,
        tile_handles: parts.tile_handles,
        clusters,
        handles: parts.handles,
        candidates,
        keyed,
    };
    let lists = cluster_assign::add(graph, &inputs);
    let lookup = if index.is_some() { CLUSTER_OF_RANK } else { CLUSTER_OF_SLICE };
    ClusterLists { lists, lookup, index, tile_lists: candidates.lists(), tile_bounds: None, keyed, ..opaque }
}
