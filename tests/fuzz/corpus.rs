//! The files that are damaged: small ones made here, and those of the folder `../shared` where it is there.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::ImageFormat;
use lampyris::math::random::Random;
use lampyris::scene::mutate::Mutator;
use lampyris::scene::{builtin, write};
use serde_json::{Value, json};

/// A file before it is damaged.
pub struct Original {
    /// For reports.
    pub name: String,
    /// Contents.
    pub bytes: Vec<u8>,
    /// Folder in which it may refer to others.
    pub base: Option<PathBuf>,
    /// Bytes of those others.
    pub companion_bytes: usize,
    /// How often it is chosen.
    weight: u64,
}

/// Sides at which the limits of decoders and devices lie.
const SIDES: [u16; 8] = [0, 1, 17, 1000, 4096, 5000, 16384, 65535];

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A corner of the unit square in the z = 0 plane.
pub const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

pub fn all() -> Vec<Original> {
    let mut list = Vec::new();
    let mut add = |name: &str, weight: u64, bytes: Vec<u8>| {
        list.push(Original { name: name.into(), bytes, base: None, companion_bytes: 0, weight });
    };
    for (name, weight) in [("cornell", 32), ("furnace", 32), ("corridor", 16)] {
        let scene = builtin::load(name).expect("a built-in scene");
        add(name, weight, write::glb(&scene).expect("a GLB file"));
    }
    add("rich.glb", 64, rich(false));
    add("rich.gltf", 48, rich(true));
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let helmet = shared.join("assets/FlightHelmet");
    let read = |path: PathBuf| std::fs::read(path).ok();
    for (file, weight) in [("assets/CornellBox.glb", 32), ("assets/Cubes.glb", 32), ("peers/grid-16.glb", 16)] {
        if let Some(bytes) = read(shared.join(file)) {
            add(file, weight, bytes);
        }
    }
    for (map, weight) in [("LensesMat_Normal", 16), ("GlassPlasticMat_BaseColor", 4)] {
        if let Some(bytes) = read(helmet.join(format!("FlightHelmet_Materials_{map}.png"))) {
            add(map, weight, wrapped(&bytes));
        }
    }
    if let Some(bytes) = read(helmet.join("FlightHelmet.gltf")) {
        let sizes = std::fs::read_dir(&helmet).into_iter().flatten().flatten().filter_map(|e| e.metadata().ok());
        let companion_bytes = sizes.map(|m| m.len() as usize).sum::<usize>().saturating_sub(bytes.len());
        list.push(Original { name: "FlightHelmet.gltf".into(), bytes, base: Some(helmet), companion_bytes, weight: 1 });
    }
    list
}

/// Input `index` of the run of `seed`: the original and its damaged copy. It depends on no other input, so that each can be
/// repeated alone.
pub fn damaged(corpus: &[Original], seed: u64, index: u64) -> (&Original, Vec<u8>) {
    let mut random = Random::new(Random::new(seed).next_u64().wrapping_add(index));
    let total: u64 = corpus.iter().map(|o| o.weight).sum();
    let mut ticket = random.next_u64() % total;
    let original = corpus
        .iter()
        .find(|o| {
            let is_drawn = ticket < o.weight;
            ticket = ticket.saturating_sub(o.weight);
            is_drawn
        })
        .expect("a ticket below the sum of the weights");
    let mut bytes = Mutator::new(random.next_u64()).mutate(&original.bytes);
    if random.next_u64().is_multiple_of(8) {
        stretch_pictures(&mut bytes, &mut random);
    }
    // A decoder that checks sums first would otherwise be all that is tested.
    if random.next_u64().is_multiple_of(2) {
        repair_png_checksums(&mut bytes);
    }
    (original, bytes)
}

/// Writes other sides into the header of the first PNG and of the first JPEG.
fn stretch_pictures(bytes: &mut [u8], random: &mut Random) {
    let mut side = || SIDES[(random.next_u64() % SIDES.len() as u64) as usize];
    let (width, height) = (side(), side());
    if let Some(at) = bytes.windows(PNG_MAGIC.len()).position(|w| w == PNG_MAGIC)
        && let Some(sides) = bytes.get_mut(at + 16..at + 24)
    {
        sides[..4].copy_from_slice(&u32::from(width).to_be_bytes());
        sides[4..].copy_from_slice(&u32::from(height).to_be_bytes());
    }
    // A frame header (ITU T.81, B.2.2): marker, length, 8 bits a sample, then height and width.
    let is_frame = |w: &[u8]| w[0] == 0xFF && (0xC0..=0xC2).contains(&w[1]) && w[2] == 0 && w[4] == 8;
    if let Some(at) = bytes.windows(5).position(is_frame)
        && let Some(sides) = bytes.get_mut(at + 5..at + 9)
    {
        sides[..2].copy_from_slice(&height.to_be_bytes());
        sides[2..].copy_from_slice(&width.to_be_bytes());
    }
}

/// Makes the checksum of every chunk right again, as far as the chunks can be followed.
fn repair_png_checksums(bytes: &mut [u8]) {
    let starts: Vec<usize> =
        bytes.windows(PNG_MAGIC.len()).enumerate().filter(|(_, w)| *w == PNG_MAGIC).map(|(at, _)| at).collect();
    for start in starts {
        let mut at = start + PNG_MAGIC.len();
        while let Some(length) = bytes.get(at..at + 4) {
            let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
            let end = at + 8 + length;
            let Some(sum) = bytes.get(at + 4..end).map(crc32) else { break };
            let Some(place) = bytes.get_mut(end..end + 4) else { break };
            place.copy_from_slice(&sum.to_be_bytes());
            at = end + 4;
        }
    }
}

/// PNG specification, annex D.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, &byte: &u8| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xEDB8_8320 } else { c >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// A GLB file of a document and its one buffer.
pub fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = binary.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend((28 + text.len() as u32 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &data)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// A buffer and the views into it.
#[derive(Default)]
pub struct Binary {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// Bytes of one view with an accessor over all of it.
    pub fn data(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    pub fn floats(&mut self, kind: &str, count: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.data(5126, kind, count, &bytes)
    }

    /// The document with this buffer in the GLB file's chunk.
    pub fn document(&self, mut rest: Value) -> Value {
        rest["asset"] = json!({ "version": "2.0" });
        rest["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        rest["bufferViews"] = json!(self.views);
        rest["accessors"] = json!(self.accessors);
        rest
    }
}

/// A triangle that shows the picture.
fn wrapped(picture: &[u8]) -> Vec<u8> {
    let mut b = Binary::default();
    let position = b.floats("VEC3", 3, &TRIANGLE);
    let uv = b.floats("VEC2", 3, &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    let view = b.view(picture);
    let document = b.document(json!({
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": position, "TEXCOORD_0": uv }, "material": 0 }] }],
        "materials": [{ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }],
        "textures": [{ "source": 0 }], "images": [{ "bufferView": view }],
    }));
    glb(&document, &b.bytes)
}

/// PNG of RGBA, PNG of 16-bit grey, JPEG.
fn pictures() -> [Vec<u8>; 3] {
    let mut files = [(); 3].map(|()| Cursor::new(Vec::new()));
    let color = image::RgbaImage::from_fn(24, 16, |x, y| image::Rgba([x as u8 * 9, y as u8 * 15, 77, 255 - x as u8]));
    let grey = image::ImageBuffer::from_fn(9, 7, |x, y| image::Luma([(x * 7000 + y) as u16]));
    let bumps =
        image::RgbImage::from_fn(32, 32, |x, y| image::Rgb([118 + (x % 4) as u8 * 5, 118 + (y % 4) as u8 * 5, 250]));
    color.write_to(&mut files[0], ImageFormat::Png).expect("a PNG");
    grey.write_to(&mut files[1], ImageFormat::Png).expect("a PNG");
    bumps.write_to(&mut files[2], ImageFormat::Jpeg).expect("a JPEG");
    files.map(Cursor::into_inner)
}

/// Most of what the loader reads: as a GLB file, or as a document with data URIs.
fn rich(inline: bool) -> Vec<u8> {
    let mut b = Binary::default();
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let position = b.floats("VEC3", 4, &square);
    let normal = b.floats("VEC3", 4, &[0.0f32, 0.0, 1.0].repeat(4));
    let uv = b.data(5121, "VEC2", 4, &[0, 255, 255, 255, 255, 0, 0, 0]);
    b.accessors[uv]["normalized"] = json!(true);
    let color = b.data(5121, "VEC4", 4, &[200; 16]);
    b.accessors[color]["normalized"] = json!(true);
    let bytes_of = |values: &[u16]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let indices = b.data(5123, "SCALAR", 6, &bytes_of(&[0, 1, 2, 0, 2, 3]));
    let places = b.view(&[1, 3]);
    let values = b.view(&[1.5f32, 0.0, 0.25, 0.0, 1.5, 0.25].map(f32::to_le_bytes).concat());
    b.accessors.push(json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
        "count": 2, "indices": { "bufferView": places, "componentType": 5121 }, "values": { "bufferView": values } } }));
    let bent = b.accessors.len() - 1;
    let view = b.view(&[0.5f32; 32].map(f32::to_le_bytes).concat());
    b.views[view]["byteStride"] = json!(32);
    b.accessors.push(json!({ "bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 4, "type": "VEC2" }));
    let strided = b.accessors.len() - 1;
    let images: Vec<Value> = pictures()
        .iter()
        .map(|p| if inline { json!({ "uri": data_uri("image/x", p) }) } else { json!({ "bufferView": b.view(p) }) })
        .collect();
    let mut document = b.document(scenery());
    document["images"] = json!(images);
    document["meshes"] = json!([
        { "primitives": [{ "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "COLOR_0": color },
            "indices": indices, "material": 0 }] },
        { "primitives": [{ "attributes": { "POSITION": bent, "TEXCOORD_0": uv, "TEXCOORD_1": strided },
            "mode": 5, "material": 1 }, { "attributes": { "POSITION": position }, "mode": 6, "material": 2 }] },
    ]);
    if inline {
        document["buffers"][0]["uri"] = json!(data_uri("application/octet-stream", &b.bytes));
        return document.to_string().into_bytes();
    }
    glb(&document, &b.bytes)
}

/// Nodes, cameras, lights, materials and textures of [`rich`].
fn scenery() -> Value {
    let moved =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 0.3, "scale": [2, -1], "texCoord": 0 } });
    json!({
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_unlit",
            "KHR_materials_emissive_strength", "EXT_unheard_of"],
        "scene": 0, "scenes": [{ "nodes": [0, 4] }],
        "nodes": [
            { "children": [1, 2, 3], "scale": [-1, 1, 2], "rotation": [0, 0.6, 0, 0.8] },
            { "mesh": 0, "name": "square" },
            { "mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1] },
            { "translation": [0, 2, 1], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "camera": 0, "translation": [0.5, 0.5, 4], "children": [5, 6] },
            { "camera": 1, "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 2 } } },
        ],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "zfar": 50, "aspectRatio": 1.5 } },
            { "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 1, "znear": 0, "zfar": 10 } },
        ],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 40, "range": 9 },
            { "type": "spot", "color": [1, 0.5, 0.25], "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.7 } },
            { "type": "directional", "name": "sun", "intensity": 2 },
        ] } },
        "materials": [
            { "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "extensions": moved }, "metallicFactor": 0.5,
                "metallicRoughnessTexture": { "index": 1 } }, "normalTexture": { "index": 2, "scale": 0.8 },
                "occlusionTexture": { "index": 1, "strength": 0.7 }, "alphaMode": "MASK", "alphaCutoff": 0.4 },
            { "normalTexture": { "index": 2, "texCoord": 1 }, "emissiveFactor": [1, 0.5, 0], "doubleSided": true,
                "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 3 } } },
            { "extensions": { "KHR_materials_unlit": {} }, "alphaMode": "BLEND" },
        ],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 1 }, { "source": 2, "sampler": 1 }],
        "samplers": [{ "minFilter": 9984, "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }, { "minFilter": 9987 }],
    })
}

/// RFC 2397 with the first alphabet of RFC 4648.
fn data_uri(kind: &str, bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = format!("data:{kind};base64,");
    for group in bytes.chunks(3) {
        let byte = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let is_padding = digit > group.len();
            uri.push(if is_padding { '=' } else { char::from(DIGITS[(bits >> (18 - 6 * digit)) as usize & 63]) });
        }
    }
    uri
}

#[test]
fn originals_are_drawn_as_they_are() {
    for original in all() {
        let scene = lampyris::scene::gltf::load_slice(&original.bytes, original.base.as_deref(), &original.name);
        let scene = scene.unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.triangle_count() > 0, "{}", original.name);
        if original.name.starts_with("rich") {
            let counts = (scene.images.len(), scene.lights.len(), scene.cameras.len());
            assert_eq!(counts, (3, 3, 2), "{}: {:?}", original.name, scene.warnings);
        }
    }
}

#[test]
fn an_input_repeats_alone() {
    let corpus = all();
    assert_eq!(damaged(&corpus, 3, 70).1, damaged(&corpus, 3, 70).1);
    assert_ne!(damaged(&corpus, 3, 70).1, damaged(&corpus, 3, 71).1);
    let mut picture = pictures()[0].clone();
    let whole = picture.clone();
    picture[20] ^= 1;
    repair_png_checksums(&mut picture);
    assert_ne!(picture, whole);
    picture[20] ^= 1;
    repair_png_checksums(&mut picture);
    assert_eq!(picture, whole, "the sums are those of the encoder");
}
