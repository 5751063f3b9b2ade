//! Static resources of a scene, declared in a graph: buffers, textures, and the descriptor bindings of every material.

use ash::vk;

use super::nearest_sampler;
use crate::graph::access::{
    ComputeSampled, ComputeStorageRead, ComputeTexel, FragmentSampled, FragmentStorageRead, FragmentTexel,
};
use crate::graph::{
    Binding, BufferHandle, Cull, Draw, Geometry, Graph, ImageHandle, ImageInfo, Lifetime, MeshRange, SamplerState,
    Stream,
};
use crate::plan::geometry::{Faces, PlannedDraw};
use crate::plan::materials::{MAPS, Map, Variant, level_count};
use crate::plan::{Deferred, GbufferLayout, Plan};
use crate::scene::{Sampler, Wrap};
use crate::shaders::shade::forward;
use crate::shared::{
    ClusterGrid, Frame, ICOSPHERE_CORNERS, InstanceData, LightMarker, LightVolume, MaterialData, TileGrid,
};

/// Handles of what light lists are made from.
#[derive(Debug, Clone, Copy)]
pub struct TileHandles {
    /// One `TileGrid`.
    pub grid: BufferHandle,
    /// `CULL_TEXELS` a light.
    pub lights: BufferHandle,
    /// Edges of columns, then of rows.
    pub edges: BufferHandle,
    /// One texel, bound where nothing is known of depths.
    pub no_bounds: ImageHandle,
}

/// Handles of what clusters are made from, beside those of tiles.
#[derive(Debug, Clone, Copy)]
pub struct ClusterHandles {
    /// One `ClusterGrid`.
    pub grid: BufferHandle,
    /// A texel a slice: its distances.
    pub slices: BufferHandle,
}

/// Handles of the shadows that shading reads.
#[derive(Debug, Clone, Copy)]
pub struct ShadowHandles {
    /// Depths of all maps.
    pub atlas: ImageHandle,
    /// Where maps lie and how positions come to them (`SHADOW_*_TEXELS`).
    pub maps: BufferHandle,
}

/// Handles of bounced light that shading reads, and of what it is made from.
#[derive(Debug, Clone, Copy)]
pub struct BouncedHandles {
    /// The grid and patches in it (`BOUNCED_HEAD_TEXELS`).
    pub places: BufferHandle,
    /// Cells and lists.
    pub words: BufferHandle,
    /// Array of `PatchData`.
    pub patches: BufferHandle,
    /// Points of patches.
    pub points: BufferHandle,
    /// The exchange matrix.
    pub matrix: BufferHandle,
    /// What of it is sampled.
    pub matrix_image: Option<ImageHandle>,
    /// Array of `PatchLight`, when all light is gathered.
    pub light: BufferHandle,
}

/// What is uploaded instead of drawn: tile bounds, or depths.
pub struct Given {
    /// A texel a tile, or a pixel.
    pub image: ImageHandle,
    /// Its texels.
    pub size: [u32; 2],
    /// As the device would have stored them, row-major.
    pub bytes: Vec<u8>,
}

/// Handles of everything that is filled before the first frame.
pub struct SceneHandles {
    /// One `Frame`.
    pub frame: BufferHandle,
    /// Array of `InstanceData`.
    pub instances: BufferHandle,
    /// Array of `MaterialData`.
    pub materials: BufferHandle,
    /// Light texels.
    pub lights: BufferHandle,
    /// Attribute streams.
    pub vertices: BufferHandle,
    /// u32 indices.
    pub indices: BufferHandle,
    /// By index into the plan's textures; last a white texel for maps that a material lacks.
    pub textures: Vec<ImageHandle>,
    /// Set 1 by material.
    pub material_bindings: Vec<Vec<Binding>>,
    /// Where the plan has tiles.
    pub tiles: Option<TileHandles>,
    /// Where the plan has clusters.
    pub clusters: Option<ClusterHandles>,
    /// Where the plan has shadows and the frame draws them.
    pub shadows: Option<ShadowHandles>,
    /// Where the plan has bounced light and the frame gathers it.
    pub bounced: Option<BouncedHandles>,
    /// Where lists are made from what is given.
    pub given: Option<Given>,
    /// Corners of the mesh that light volumes and markers are made of.
    pub corners: Option<BufferHandle>,
    /// Array of `LightVolume`, where the plan has volumes.
    pub light_volumes: Option<BufferHandle>,
    /// Array of `LightMarker`, where the plan has markers.
    pub light_markers: Option<BufferHandle>,
    /// One texel, bound where the G-buffer has no codes of normals.
    pub no_normals: Option<ImageHandle>,
}

fn wrap(mode: Wrap) -> vk::SamplerAddressMode {
    match mode {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    }
}

fn sampler_state(sampler: Sampler) -> SamplerState {
    let filter = |linear| if linear { vk::Filter::LINEAR } else { vk::Filter::NEAREST };
    SamplerState {
        mag: filter(sampler.mag_linear),
        min: filter(sampler.min_linear),
        // Level 0 alone: a linear mode would mix a quarter of level 1 into what is above it.
        mip: if sampler.mipmapped && sampler.mip_linear {
            vk::SamplerMipmapMode::LINEAR
        } else {
            vk::SamplerMipmapMode::NEAREST
        },
        wrap: [wrap(sampler.wrap_u), wrap(sampler.wrap_v)],
        mipmapped: sampler.mipmapped,
    }
}

fn bytes_of<T>(count: usize) -> u64 {
    (count.max(1) * size_of::<T>()) as u64
}

impl SceneHandles {
    /// Declares the plan's static resources.
    pub fn declare(graph: &mut Graph, plan: &Plan) -> Self {
        let (geometry, materials) = (&plan.geometry, &plan.materials);
        let fixed = Lifetime::Static;
        let volumes = plan.deferred.as_ref().and_then(Deferred::volumes);
        let markers = plan.markers.len();
        let fat = plan.deferred.as_ref().is_some_and(|d| d.gbuffer.layout == GbufferLayout::Fat);
        let mut textures = Vec::new();
        for (index, &(key, [width, height], mipmapped)) in materials.textures.iter().enumerate() {
            let format = if key.srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM };
            let levels = if mipmapped { level_count([width, height]) } else { 1 };
            textures.push(graph.add_image(ImageInfo {
                name: format!("texture {index}"),
                format,
                width,
                height,
                levels,
                samples: 1,
                lifetime: fixed,
            }));
        }
        textures.push(graph.image("white texel", vk::Format::R8G8B8A8_UNORM, [1, 1], fixed));
        let material_bindings = materials.maps.iter().map(|maps| bindings(maps, &textures)).collect();
        Self {
            frame: graph.buffer("frame", size_of::<Frame>() as u64, fixed),
            instances: graph.buffer("instances", bytes_of::<InstanceData>(geometry.instances.len()), fixed),
            materials: graph.buffer("materials", bytes_of::<MaterialData>(materials.data.len()), fixed),
            lights: graph.buffer("lights", plan.lights.bytes().max(16), fixed),
            vertices: graph.buffer("vertices", geometry.vertex_bytes, fixed),
            indices: graph.buffer("indices", (geometry.index_count * 4).max(4), fixed),
            textures,
            material_bindings,
            tiles: plan.tiles.as_ref().map(|tiles| TileHandles {
                grid: graph.buffer("tile_grid", size_of::<TileGrid>() as u64, fixed),
                lights: graph.buffer("cull_lights", (tiles.cull_data().len() as u64 * 16).max(16), fixed),
                edges: graph.buffer("tile_edges", tiles.edges.len() as u64 * 16, fixed),
                no_bounds: graph.image("no bounds", vk::Format::R32G32B32A32_UINT, [1, 1], fixed),
            }),
            clusters: plan.clusters.as_ref().map(|clusters| ClusterHandles {
                grid: graph.buffer("cluster_grid", size_of::<ClusterGrid>() as u64, fixed),
                slices: graph.buffer("cluster_slices", clusters.slice_texels().len() as u64 * 16, fixed),
            }),
            shadows: None,
            bounced: None,
            given: None,
            corners: (volumes.is_some() || markers > 0)
                .then(|| graph.buffer("corners", u64::from(ICOSPHERE_CORNERS) * 16, fixed)),
            light_volumes: volumes
                .map(|v| graph.buffer("light_volumes", bytes_of::<LightVolume>(v.volumes.len()), fixed)),
            light_markers: (markers > 0)
                .then(|| graph.buffer("light_markers", bytes_of::<LightMarker>(markers), fixed)),
            no_normals: (fat || (plan.samples > 1 && plan.deferred.is_some()))
                .then(|| graph.image("no normals", vk::Format::R16G16_UINT, [1, 1], fixed)),
        }
    }
}

impl SceneHandles {
    /// Shadow maps for fragments.
    pub fn shadow_atlas_of_fragments(&self) -> Option<FragmentSampled> {
        self.shadows.map(|shadows| FragmentSampled(shadows.atlas, nearest_sampler()))
    }

    /// What fragments are told of them.
    pub fn shadow_maps_of_fragments(&self) -> Option<FragmentTexel> {
        self.shadows.map(|shadows| FragmentTexel(shadows.maps))
    }

    /// Shadow maps for compute passes.
    pub fn shadow_atlas_of_compute(&self) -> Option<ComputeSampled> {
        self.shadows.map(|shadows| ComputeSampled(shadows.atlas, nearest_sampler()))
    }

    /// What compute passes are told of them.
    pub fn shadow_maps_of_compute(&self) -> Option<ComputeTexel> {
        self.shadows.map(|shadows| ComputeTexel(shadows.maps))
    }
}

impl SceneHandles {
    /// The grid of bounced light for fragments.
    pub fn bounced_places_of_fragments(&self) -> Option<FragmentTexel> {
        self.bounced.map(|bounced| FragmentTexel(bounced.places))
    }

    /// Its cells and lists.
    pub fn bounced_words_of_fragments(&self) -> Option<FragmentTexel> {
        self.bounced.map(|bounced| FragmentTexel(bounced.words))
    }

    /// The same as a storage buffer.
    pub fn bounced_word_storage_of_fragments(&self) -> Option<FragmentStorageRead> {
        self.bounced.map(|bounced| FragmentStorageRead(bounced.words))
    }

    /// Light of its patches.
    pub fn bounced_light_of_fragments(&self) -> Option<FragmentTexel> {
        self.bounced.map(|bounced| FragmentTexel(bounced.light))
    }

    /// The grid of bounced light for compute passes.
    pub fn bounced_places_of_compute(&self) -> Option<ComputeTexel> {
        self.bounced.map(|bounced| ComputeTexel(bounced.places))
    }

    /// Its cells and lists.
    pub fn bounced_words_of_compute(&self) -> Option<ComputeTexel> {
        self.bounced.map(|bounced| ComputeTexel(bounced.words))
    }

    /// The same as a storage buffer.
    pub fn bounced_word_storage_of_compute(&self) -> Option<ComputeStorageRead> {
        self.bounced.map(|bounced| ComputeStorageRead(bounced.words))
    }

    /// Light of its patches.
    pub fn bounced_light_of_compute(&self) -> Option<ComputeTexel> {
        self.bounced.map(|bounced| ComputeTexel(bounced.light))
    }
}

fn bindings(maps: &[Option<Map>; MAPS], textures: &[ImageHandle]) -> Vec<Binding> {
    let white = textures[textures.len() - 1];
    let of = |map: Option<Map>| match map {
        Some(map) => FragmentSampled(textures[map.texture], sampler_state(map.sampler)),
        None => FragmentSampled(white, sampler_state(Sampler::default())),
    };
    let set = forward::Bindings1 {
        base_color_map: of(maps[0]),
        metallic_roughness_map: of(maps[1]),
        normal_map: of(maps[2]),
        occlusion_map: of(maps[3]),
        emissive_map: of(maps[4]),
        height_map: of(maps[5]),
    };
    set.list()
}

/// Distinct variants of the plan's draws under `simplify`, and each draw's index among them.
pub fn variants(plan: &Plan, simplify: impl Fn(Variant) -> Variant) -> (Vec<Variant>, Vec<usize>) {
    let mut distinct = Vec::new();
    let of_draw = plan
        .geometry
        .draws
        .iter()
        .map(|draw| {
            let variant = simplify(draw.variant);
            distinct.iter().position(|v| *v == variant).unwrap_or_else(|| {
                distinct.push(variant);
                distinct.len() - 1
            })
        })
        .collect();
    (distinct, of_draw)
}

/// Distinct variants of the opaque draws that `wanted` takes, and these draws with the index of their variant as pipeline.
pub fn chosen(plan: &Plan, wanted: impl Fn(Variant) -> bool) -> (Vec<Variant>, Vec<Draw>) {
    with_variants(plan, plan.geometry.draws.iter().filter(|d| wanted(d.variant)))
}

/// The same of blended draws, from back to front.
pub fn blended(plan: &Plan) -> (Vec<Variant>, Vec<Draw>) {
    with_variants(plan, plan.geometry.blended.iter())
}

fn with_variants<'a>(plan: &Plan, wanted: impl Iterator<Item = &'a PlannedDraw>) -> (Vec<Variant>, Vec<Draw>) {
    let mut distinct: Vec<Variant> = Vec::new();
    let mut draws = Vec::new();
    for planned in wanted {
        let known = distinct.iter().position(|v| *v == planned.variant);
        if known.is_none() {
            distinct.push(planned.variant);
        }
        draws.push(draw(plan, planned, known.unwrap_or(distinct.len() - 1)));
    }
    (distinct, draws)
}

/// A planned draw as a command.
pub fn draw(plan: &Plan, planned: &PlannedDraw, pipeline: usize) -> Draw {
    let place = &plan.geometry.places[planned.place];
    let streams = place.streams.map(|(offset, stride)| Stream { offset, stride });
    let mesh = MeshRange { streams, index_offset: planned.index_offset, index_count: planned.index_count };
    Draw {
        pipeline,
        material: Some(planned.material),
        geometry: Geometry::Mesh(mesh),
        instance_offset: planned.instance_offset,
        instance_count: planned.instance_count,
        mirrored: planned.mirrored,
        cull: match planned.faces {
            Faces::Both => Cull::None,
            Faces::Front => Cull::Back,
            Faces::Back => Cull::Front,
        },
        view: None,
    }
}
