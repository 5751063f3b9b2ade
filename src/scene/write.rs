//! Scene to binary glTF 2.0 (GLB), so that a scene made by code can be opened by any other program.
//!
//! Numbers survive: f32 as the f64 of the same value, f64 in the digits that name it, and factors that glTF limits to 1 are
//! split by a power of two. What the format forbids is refused, never bent.

mod material;
mod node;

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{Mesh, Scene};
use crate::error::{Error, Result};

/// glTF's numbers for what a buffer view holds.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// glTF's numbers for component types.
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// `glTF`, `JSON` and `BIN\0` in little-endian order.
const MAGIC: u32 = 0x4654_6C67;
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;

/// A GLB file with everything in one buffer: meshes of one primitive, materials, PNG images, lights and cameras.
///
/// # Errors
/// What glTF cannot hold: a mesh without triangles, a node with shear, a skewed texture transform, a spot wider than a half
/// space, an orthographic camera that sees behind itself, a file of 4 GiB and more. The message names it.
pub fn glb(scene: &Scene) -> Result<Vec<u8>> {
    let mut file = File::default();
    for (index, image) in scene.images.iter().enumerate() {
        material::add_image(&mut file, image).map_err(|e| e.within(format!("image {index} \"{}\"", image.name)))?;
    }
    for (index, surface) in scene.materials.iter().enumerate() {
        material::add(&mut file, surface).map_err(|e| e.within(format!("material {index} \"{}\"", surface.name)))?;
    }
    for (index, mesh) in scene.meshes.iter().enumerate() {
        file.add_mesh(mesh).map_err(|e| e.within(format!("mesh {index} \"{}\"", mesh.name)))?;
    }
    let nodes = node::Nodes::new(scene)?;
    let binary = std::mem::take(&mut file.bytes);
    pack(&document(scene, file, nodes, binary.len())?, &binary)
}

/// The arrays of the document so far and the bytes they point into.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    buffer_views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<super::Sampler>,
    /// Sampler and image of each texture.
    textures: Vec<[usize; 2]>,
    /// Material extensions in use.
    extensions: Vec<&'static str>,
}

impl File {
    fn use_extension(&mut self, name: &'static str) {
        if !self.extensions.contains(&name) {
            self.extensions.push(name);
        }
    }

    /// Pads to four bytes after the data, which aligns what follows.
    fn add_view(&mut self, data: impl FnOnce(&mut Vec<u8>), target: Option<u32>) -> usize {
        let offset = self.bytes.len();
        data(&mut self.bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": self.bytes.len() - offset });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.buffer_views.push(view);
        self.buffer_views.len() - 1
    }

    /// Vertex data of `N` floats each; `kind` is glTF's name for that shape.
    fn add_floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let write = |bytes: &mut Vec<u8>| bytes.extend(values.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        let view = self.add_view(write, Some(ARRAY_BUFFER));
        self.accessors.push(json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind }));
        self.accessors.len() - 1
    }

    fn add_positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32, start: f32| {
            let corner = positions.iter().fold([start; 3], |a, p| [0, 1, 2].map(|axis| pick(a[axis], p[axis])));
            json!(wide(corner))
        };
        let (min, max) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        let accessor = self.add_floats(positions, "VEC3");
        self.accessors[accessor]["min"] = min;
        self.accessors[accessor]["max"] = max;
        accessor
    }

    /// 16 bits where they hold every index; 65535 is left out, since it restarts a primitive.
    fn add_indices(&mut self, indices: &[u32], vertex_count: usize) -> usize {
        let short = vertex_count <= 65_535;
        let write = |bytes: &mut Vec<u8>| {
            if short {
                bytes.extend(indices.iter().flat_map(|&index| (index as u16).to_le_bytes()));
            } else {
                bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
            }
        };
        let view = self.add_view(write, Some(ELEMENT_ARRAY_BUFFER));
        let component = if short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        self.accessors
            .push(json!({ "bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR" }));
        self.accessors.len() - 1
    }

    fn add_mesh(&mut self, mesh: &Mesh) -> Result<()> {
        if mesh.indices.is_empty() || mesh.positions.is_empty() {
            return Err(Error::new("it has no triangle, and glTF has no empty accessor"));
        }
        let mut attributes = Map::new();
        attributes.insert("POSITION".into(), json!(self.add_positions(&mesh.positions)));
        if !mesh.normals.is_empty() {
            attributes.insert("NORMAL".into(), json!(self.add_floats(&mesh.normals, "VEC3")));
        }
        if !mesh.tangents.is_empty() {
            attributes.insert("TANGENT".into(), json!(self.add_floats(&mesh.tangents, "VEC4")));
        }
        let [first, second] = &mesh.uvs;
        if !first.is_empty() {
            attributes.insert("TEXCOORD_0".into(), json!(self.add_floats(first, "VEC2")));
        } else if !second.is_empty() {
            // Sets are numbered without gaps (glTF 2.0, section 3.7.2.1); absent coordinates read as 0.
            let zeros = vec![[0.0f32; 2]; mesh.positions.len()];
            attributes.insert("TEXCOORD_0".into(), json!(self.add_floats(&zeros, "VEC2")));
        }
        if !second.is_empty() {
            attributes.insert("TEXCOORD_1".into(), json!(self.add_floats(second, "VEC2")));
        }
        if !mesh.colors.is_empty() {
            attributes.insert("COLOR_0".into(), json!(self.add_floats(&mesh.colors, "VEC4")));
        }
        let indices = self.add_indices(&mesh.indices, mesh.positions.len());
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": mesh.material });
        self.meshes.push(named(&mesh.name, json!({ "primitives": [primitive] })));
        Ok(())
    }
}

/// `object` with a `name`, unless that is empty.
fn named(name: &str, mut object: Value) -> Value {
    if !name.is_empty() {
        object["name"] = json!(name);
    }
    object
}

/// The same values in f64, whose decimal digits read back as the same f32.
fn wide<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// The smallest power of two from 1 on that makes `value` at most 1 when divided by it. Both parts of such a split are
/// exact, so their product is too.
fn power_of_two_over(value: f32) -> f64 {
    let mut power = 1.0f64;
    while power < f64::from(value) && power.is_finite() {
        power *= 2.0;
    }
    power
}

/// The JSON chunk. Empty arrays are left out, as glTF demands.
fn document(scene: &Scene, file: File, nodes: node::Nodes, binary_bytes: usize) -> Result<Vec<u8>> {
    #[derive(Serialize)]
    struct Root<'a> {
        asset: Value,
        #[serde(rename = "extensionsUsed", skip_serializing_if = "Vec::is_empty")]
        extensions_used: Vec<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        extensions: Option<node::RootExtensions<'a>>,
        #[serde(skip_serializing_if = "Option::is_none")]
        scene: Option<usize>,
        #[serde(skip_serializing_if = "Option::is_none")]
        scenes: Option<[Value; 1]>,
        #[serde(skip_serializing_if = "Option::is_none")]
        nodes: Option<&'a [node::Node<'a>]>,
        #[serde(flatten)]
        arrays: Map<String, Value>,
    }
    let mut extensions_used = file.extensions;
    if !nodes.lights.is_empty() {
        extensions_used.push(node::LIGHTS);
    }
    extensions_used.sort_unstable();
    let mut arrays = Map::new();
    let samplers = file.samplers.iter().map(material::sampler).collect();
    let textures =
        file.textures.iter().map(|[sampler, image]| json!({ "sampler": sampler, "source": image })).collect();
    for (key, array) in [
        ("cameras", nodes.cameras),
        ("meshes", file.meshes),
        ("materials", file.materials),
        ("textures", textures),
        ("samplers", samplers),
        ("images", file.images),
        ("accessors", file.accessors),
        ("bufferViews", file.buffer_views),
    ] {
        if !array.is_empty() {
            arrays.insert(key.into(), Value::Array(array));
        }
    }
    if binary_bytes > 0 {
        arrays.insert("buffers".into(), json!([{ "byteLength": binary_bytes }]));
    }
    // Every node is a root; some readers refuse a scene without any.
    let roots: Vec<usize> = (0..nodes.nodes.len()).collect();
    let scenes = (!roots.is_empty()).then(|| [named(&scene.name, json!({ "nodes": roots }))]);
    let root = Root {
        asset: json!({ "version": "2.0", "generator": concat!("lampyris ", env!("CARGO_PKG_VERSION")) }),
        extensions_used,
        extensions: node::RootExtensions::new(&nodes.lights),
        scene: scenes.as_ref().map(|_| 0),
        scenes,
        nodes: (!nodes.nodes.is_empty()).then_some(nodes.nodes.as_slice()),
        arrays,
    };
    serde_json::to_vec(&root).map_err(|error| Error::new(format!("the scene cannot be written as JSON: {error}")))
}

/// Header and chunks (glTF 2.0, section 4.4): JSON padded with spaces, the buffer already padded with zeros.
fn pack(json: &[u8], binary: &[u8]) -> Result<Vec<u8>> {
    let json_length = json.len().next_multiple_of(4);
    let binary_chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let total = 12 + 8 + json_length + binary_chunk;
    let length = |bytes: usize| {
        u32::try_from(bytes)
            .map_err(|_| Error::new(format!("the file would have {bytes} bytes, a GLB holds under 4 GiB")))
    };
    let mut bytes = Vec::with_capacity(total);
    for word in [MAGIC, 2, length(total)?, length(json_length)?, JSON_CHUNK] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(json);
    bytes.resize(12 + 8 + json_length, b' ');
    if !binary.is_empty() {
        for word in [length(binary.len())?, BIN_CHUNK] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(binary);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;
