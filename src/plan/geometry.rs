//! Meshes in device form: one vertex buffer of separate attribute streams, one index buffer, instances sorted into draws.

mod blended;

use std::collections::BTreeMap;

use glam::{DMat3, DMat4, DVec3};

use super::Limits;
use super::materials::{Materials, Variant};
use super::request::TransparentSort;
use crate::error::{Error, Result};
use crate::scene::view::View;
use crate::scene::{Mesh, Scene};
use crate::shared::{InstanceData, MaterialData};

/// Bytes of one element by attribute location: position, normal, tangent, uv0, uv1, colour.
pub const ATTRIBUTE_BYTES: [u64; 6] = [12, 12, 16, 8, 8, 16];
/// Bytes in front of the first mesh: one element of zeros, one of ones, for attributes that a mesh lacks.
pub const DEFAULT_ELEMENTS_BYTES: u64 = 32;
/// Zeros for everything but colour, which is one.
const DEFAULT_STREAMS: [(u64, u64); 6] = [(0, 0), (0, 0), (0, 0), (0, 0), (0, 0), (16, 0)];

/// Where a mesh lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshPlace {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// (first byte, bytes a vertex) of each stream; stride 0 where one default element stands for what the mesh lacks.
    pub streams: [(u64, u64); 6],
    /// First index.
    pub index_offset: u32,
    /// Indices.
    pub index_count: u32,
}

/// Which faces of a surface are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Faces {
    /// Those wound counter-clockwise.
    Front,
    /// The others.
    Back,
    /// All.
    Both,
}

/// One draw: a mesh, some instances of one winding, one material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedDraw {
    /// Index into [`Geometry::places`].
    pub place: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Pipeline variant.
    pub variant: Variant,
    /// First instance.
    pub instance_offset: u32,
    /// Instances.
    pub instance_count: u32,
    /// Winding turned round.
    pub mirrored: bool,
    /// Which faces.
    pub faces: Faces,
    /// First index.
    pub index_offset: u32,
    /// Indices.
    pub index_count: u32,
}

/// All geometry of a picture.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    /// Meshes that are drawn.
    pub places: Vec<MeshPlace>,
    /// Opaque and masked surfaces in draw order: by variant, material, mesh.
    pub draws: Vec<PlannedDraw>,
    /// Blended surfaces from back to front.
    pub blended: Vec<PlannedDraw>,
    /// Indices behind those of meshes: triangles of blended surfaces in the order in which they are drawn.
    pub sorted_indices: Vec<u32>,
    /// In the order that draws refer to.
    pub instances: Vec<InstanceData>,
    /// Size of the vertex buffer.
    pub vertex_bytes: u64,
    /// Number of indices.
    pub index_count: u64,
    /// Index into `places` by mesh.
    place_of: BTreeMap<usize, usize>,
}

/// What pipelines of a mesh are specialised for.
fn variant_of(mesh: &Mesh, materials: &Materials) -> Variant {
    Variant { vertex_colors: !mesh.colors.is_empty(), ..materials.variants[mesh.material] }
}

fn streams(mesh: &Mesh) -> [&[u8]; 6] {
    [
        bytemuck::cast_slice(&mesh.positions),
        bytemuck::cast_slice(&mesh.normals),
        bytemuck::cast_slice(&mesh.tangents),
        bytemuck::cast_slice(&mesh.uvs[0]),
        bytemuck::cast_slice(&mesh.uvs[1]),
        bytemuck::cast_slice(&mesh.colors),
    ]
}

/// Instance data in view space, made in f64 so that a camera far from the origin costs nothing.
fn instance(object_to_view: DMat4, mirrors: bool, material: usize) -> InstanceData {
    let linear = DMat3::from_mat4(object_to_view);
    let sign = if mirrors { -1.0 } else { 1.0 };
    // Cofactors: the inverse transpose times the determinant; scaled so that f32 holds any scale.
    let cofactors =
        [linear.y_axis.cross(linear.z_axis), linear.z_axis.cross(linear.x_axis), linear.x_axis.cross(linear.y_axis)];
    let largest = cofactors.iter().fold(0.0f64, |m, c| m.max(c.abs().max_element())).max(f64::MIN_POSITIVE);
    let normal = cofactors.map(|c| (c * (sign / largest)).as_vec3().to_array());
    let column = |v: DVec3| v.as_vec3().to_array();
    InstanceData {
        object_to_view_x: column(linear.x_axis),
        object_to_view_y: column(linear.y_axis),
        object_to_view_z: column(linear.z_axis),
        object_to_view_w: column(object_to_view.w_axis.truncate()),
        normal_x: normal[0],
        normal_y: normal[1],
        normal_z: normal[2],
        material: material as u32,
        handedness: sign as f32,
    }
}

impl Geometry {
    /// Places every mesh that is drawn and sorts instances into draws.
    ///
    /// # Errors
    /// Buffers past the device's limits, in one sentence.
    pub fn new(
        scene: &Scene,
        view: &View,
        materials: &Materials,
        sort: TransparentSort,
        limits: &Limits,
    ) -> Result<Self> {
        let mut geometry = Self { vertex_bytes: DEFAULT_ELEMENTS_BYTES, ..Self::default() };
        let mut blended = Vec::new();
        let mut groups: BTreeMap<(Variant, usize, usize, bool), Vec<usize>> = BTreeMap::new();
        for (index, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh];
            if mesh.indices.is_empty() {
                continue;
            }
            let variant = variant_of(mesh, materials);
            if variant.blended {
                blended.push(index);
                continue;
            }
            let mirrored = (instance.object_to_world.determinant() < 0.0) != view.lens.mirrors();
            let key = (variant, mesh.material, instance.mesh, mirrored);
            groups.entry(key).or_default().push(index);
        }
        for ((variant, material, mesh, mirrored), members) in groups {
            let place = geometry.place_once(mesh, &scene.meshes[mesh]);
            let MeshPlace { index_offset, index_count, .. } = geometry.places[place];
            geometry.draws.push(PlannedDraw {
                place,
                material,
                variant,
                instance_offset: geometry.instances.len() as u32,
                instance_count: members.len() as u32,
                mirrored,
                faces: if materials.double_sided[material] { Faces::Both } else { Faces::Front },
                index_offset,
                index_count,
            });
            for index in members {
                let object_to_view = view.world_to_view * scene.instances[index].object_to_world;
                geometry.instances.push(instance(object_to_view, mirrored != view.lens.mirrors(), material));
            }
        }
        blended::add(&mut geometry, scene, view, materials, (&blended, sort), limits)?;
        geometry.check(scene, limits)?;
        Ok(geometry)
    }

    /// Where a mesh lies, placed on first use.
    fn place_once(&mut self, index: usize, mesh: &Mesh) -> usize {
        match self.place_of.get(&index) {
            Some(&known) => known,
            None => {
                let place = self.place(index, mesh);
                self.place_of.insert(index, place);
                place
            }
        }
    }

    fn place(&mut self, index: usize, mesh: &Mesh) -> usize {
        let mut offsets = DEFAULT_STREAMS;
        for ((place, stream), stride) in offsets.iter_mut().zip(streams(mesh)).zip(ATTRIBUTE_BYTES) {
            if !stream.is_empty() {
                *place = (self.vertex_bytes, stride);
                self.vertex_bytes += stream.len() as u64;
            }
        }
        let (index_offset, index_count) = (self.index_count as u32, mesh.indices.len() as u32);
        self.places.push(MeshPlace { mesh: index, streams: offsets, index_offset, index_count });
        self.index_count += mesh.indices.len() as u64;
        self.places.len() - 1
    }

    fn check(&self, scene: &Scene, limits: &Limits) -> Result<()> {
        let instance_bytes = (self.instances.len() * size_of::<InstanceData>()) as u64;
        let buffers = [
            ("vertices", self.vertex_bytes, limits.max_buffer_bytes),
            ("indices", self.index_count * 4, limits.max_buffer_bytes.min(u64::from(u32::MAX) * 4)),
            ("instances", instance_bytes, limits.max_storage_bytes),
            ("materials", (scene.materials.len() * size_of::<MaterialData>()) as u64, limits.max_storage_bytes),
        ];
        let vertices = self.places.iter().map(|p| scene.meshes[p.mesh].positions.len()).max().unwrap_or(0);
        if vertices as u64 > u64::from(limits.max_index) + 1 {
            let most = limits.max_index;
            return Err(Error::new(format!(
                "{}: a mesh has {vertices} vertices, this device draws indices to {most}",
                scene.name
            )));
        }
        match buffers.iter().find(|b| b.1 > b.2) {
            Some((what, bytes, most)) => {
                Err(Error::new(format!("{}: {what} need {bytes} bytes, this device takes at most {most}", scene.name)))
            }
            None => Ok(()),
        }
    }

    /// Bytes of vertex, index and instance buffers.
    pub fn bytes(&self) -> u64 {
        self.vertex_bytes + self.index_count * 4 + (self.instances.len() * size_of::<InstanceData>()) as u64
    }

    /// Contents of the vertex buffer.
    pub fn vertex_data(&self, scene: &Scene) -> Vec<u8> {
        let mut data = Vec::with_capacity(self.vertex_bytes as usize);
        data.extend_from_slice(bytemuck::bytes_of(&[0f32; 4]));
        data.extend_from_slice(bytemuck::bytes_of(&[1f32; 4]));
        for place in &self.places {
            for stream in streams(&scene.meshes[place.mesh]) {
                data.extend_from_slice(stream);
            }
        }
        data
    }

    /// Contents of the index buffer.
    pub fn index_data(&self, scene: &Scene) -> Vec<u32> {
        let of_meshes = self.places.iter().flat_map(|p| scene.meshes[p.mesh].indices.iter().copied());
        of_meshes.chain(self.sorted_indices.iter().copied()).collect()
    }
}
