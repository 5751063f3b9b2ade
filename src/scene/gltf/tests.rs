//! What a file says and what the scene then holds. Files are made here, in memory.

use glam::{DMat4, DVec3};

use super::*;
use crate::scene::{AlphaMode, LightKind, Projection, Wrap};

/// Grows the binary chunk, the views and the accessors of a GLB file.
#[derive(Default)]
pub(super) struct Builder {
    bin: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

pub(super) fn bytes_of(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A corner of the unit square in the z = 0 plane, its normal +Z.
pub(super) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

impl Builder {
    /// Appends bytes as a view; `extra` holds members such as `,"byteStride":16`.
    pub(super) fn view(&mut self, bytes: &[u8], extra: &str) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let (offset, length) = (self.bin.len(), bytes.len());
        self.bin.extend(bytes);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}{extra}}}"#));
        self.views.len() - 1
    }

    /// Appends an accessor from its members.
    pub(super) fn accessor(&mut self, members: &str) -> usize {
        self.accessors.push(format!("{{{members}}}"));
        self.accessors.len() - 1
    }

    /// Bytes as a view of their own with an accessor over all of it.
    pub(super) fn data(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes, "");
        self.accessor(&format!(r#""bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}""#))
    }

    pub(super) fn floats(&mut self, kind: &str, count: usize, values: &[f32]) -> usize {
        self.data(5126, kind, count, &bytes_of(values))
    }

    /// The file; `rest` holds the other members of its outermost object.
    pub(super) fn glb(&self, rest: &str) -> Vec<u8> {
        let (views, accessors, length) = (self.views.join(","), self.accessors.join(","), self.bin.len());
        let mut json = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{length}}}],"bufferViews":[{views}],"accessors":[{accessors}],{rest}}}"#
        );
        while json.len() % 4 != 0 {
            json.push(' ');
        }
        let mut file = b"glTF".to_vec();
        file.extend(2u32.to_le_bytes());
        file.extend((28 + json.len() as u32 + length as u32).to_le_bytes());
        for (kind, data) in [(b"JSON", json.as_bytes()), (b"BIN\0", self.bin.as_slice())] {
            file.extend((data.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(data);
        }
        file
    }

    /// The scene of one node with one mesh of one primitive; `more` holds other members of the outermost object.
    pub(super) fn draw(&self, primitive: &str, more: &str) -> Result<Scene> {
        let rest = format!(r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{{primitive}}}]}}]{more}"#);
        load_slice(&self.glb(&rest), None, "test.glb")
    }
}

/// A scene of nodes only.
fn nodes(rest: &str) -> Result<Scene> {
    load_slice(&Builder::default().glb(rest), None, "test.glb")
}

fn warned(scene: &Scene, words: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(words))
}

#[test]
fn every_form_of_accessor() {
    let mut b = Builder::default();
    let strided = b.view(&bytes_of(&[9.0, 1.0, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0]), r#","byteStride":16"#);
    b.accessor(&format!(r#""bufferView":{strided},"byteOffset":4,"componentType":5126,"count":2,"type":"VEC3""#));
    let small = b.view(&[0, 255, 51, 128, 0, 128, 255, 127], "");
    let typed = |component: u32, count: usize, kind: &str| {
        format!(r#""bufferView":{small},"componentType":{component},"count":{count},"type":"{kind}""#)
    };
    b.accessor(&format!(r#"{},"normalized":true"#, typed(5121, 2, "VEC4")));
    b.accessor(&format!(r#"{},"normalized":true"#, typed(5122, 2, "VEC2")));
    b.accessor(&format!(r#"{},"normalized":true"#, typed(5120, 8, "SCALAR")));
    b.accessor(&typed(5123, 4, "SCALAR"));
    b.accessor(&typed(5125, 2, "SCALAR"));
    let places = b.view(&[1, 0, 3, 0], "");
    let values = b.view(&bytes_of(&[7.0, 8.0, 9.0, 10.0]), "");
    let sparse = format!(
        r#""componentType":5126,"count":4,"type":"VEC2","sparse":{{"count":2,"indices":{{"bufferView":{places},"componentType":5123}},"values":{{"bufferView":{values}}}}}"#
    );
    b.accessor(&sparse);
    b.accessor(r#""componentType":5126,"count":3,"type":"VEC3""#);
    let file = b.glb(r#""refs":[0,1,2,3,4,5,6,7]"#);
    let (text, chunk) = glb::split(&file).unwrap();
    let json = Json::parse(text).unwrap();
    let document = Document::new(&json).unwrap();
    let mut budget = Budget::new(file.len());
    let buffers = Buffers::load(&document, chunk, None, &mut budget).unwrap();
    let mut accessors = Accessors::new(&document, &buffers);
    let references = json.root().require("refs").unwrap();
    let r: Vec<_> = references.elements().unwrap().map(|v| accessors.reader(v, &mut budget).unwrap()).collect();

    assert_eq!(r[0].gather::<3>(&[0, 1]), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(r[0].element::<4>(1), [4.0, 5.0, 6.0, 1.0]);
    assert_eq!(r[1].element::<4>(0), [0.0, 1.0, 0.2, 128.0 / 255.0]);
    assert_eq!(r[2].element::<2>(0), [-256.0 / 32767.0, -32717.0 / 32767.0]);
    assert_eq!(r[2].element::<2>(1), [-1.0, 1.0]);
    assert_eq!([r[3].element::<1>(3), r[3].element::<1>(5), r[3].element::<1>(7)], [[-1.0], [-1.0], [1.0]]);
    assert_eq!([r[4].index(0), r[4].index(3)], [0xFF00, 0x7FFF]);
    assert_eq!(r[5].index(1), 0x7FFF_8000);
    assert_eq!(r[6].gather::<2>(&[0, 1, 2, 3]), [[0.0; 2], [7.0, 8.0], [0.0; 2], [9.0, 10.0]]);
    assert_eq!(r[7].element::<3>(2), [0.0; 3]);
}

#[test]
fn indices_of_each_width_strips_and_fans() {
    let square: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let normals = [0.0f32, 0.0, 2.0].repeat(4);
    let indices: [u32; 4] = [0, 1, 2, 3];
    for (component, bytes) in [
        (5121, indices.map(|i| i as u8).to_vec()),
        (5123, indices.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect()),
        (5125, indices.iter().flat_map(|i| i.to_le_bytes()).collect()),
    ] {
        let mut b = Builder::default();
        let (p, n) = (b.floats("VEC3", 4, &square), b.floats("VEC3", 4, &normals));
        let i = b.data(component, "SCALAR", 4, &bytes);
        let primitive = format!(r#""attributes":{{"POSITION":{p},"NORMAL":{n}}},"indices":{i},"mode":5"#);
        let scene = b.draw(&primitive, "").unwrap();
        assert_eq!(scene.meshes[0].indices, [0, 1, 2, 1, 3, 2]);
        assert_eq!(scene.meshes[0].normals, [[0.0, 0.0, 1.0]; 4]);
        let scene = b.draw(&primitive.replace("\"mode\":5", "\"mode\":6"), "").unwrap();
        assert_eq!(scene.meshes[0].indices, [1, 2, 0, 2, 3, 0]);
        assert_eq!(scene.triangle_count(), 2);
    }
}

#[test]
fn only_used_vertices_stay_and_flat_normals_are_made() {
    let mut b = Builder::default();
    let mut positions = vec![f32::NAN; 9];
    positions.extend(TRIANGLE);
    let p = b.floats("VEC3", 6, &positions);
    let i = b.data(5121, "SCALAR", 6, &[3, 4, 5, 3, 3, 5]);
    let scene = b.draw(&format!(r#""attributes":{{"POSITION":{p}}},"indices":{i}"#), "").unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.indices.as_slice()), (3, [0, 1, 2].as_slice()));
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    assert!(warned(&scene, "1 triangle of zero area"), "{:?}", scene.warnings);
    assert_eq!(scene.materials[mesh.material].name, "default");
}

#[test]
fn zero_normals_are_replaced_and_counted() {
    let mut b = Builder::default();
    let p = b.floats("VEC3", 3, &TRIANGLE);
    let n = b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 3.0, 0.0, 4.0, f32::NAN, 0.0, 0.0]);
    let scene = b.draw(&format!(r#""attributes":{{"POSITION":{p},"NORMAL":{n}}}"#), "").unwrap();
    assert_eq!(scene.meshes[0].normals, [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]]);
    assert!(warned(&scene, "2 normals"), "{:?}", scene.warnings);
}

#[test]
fn materials_textures_and_what_they_need() {
    let mut picture = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 1, image::Rgb([10, 20, 30]))
        .write_to(&mut picture, image::ImageFormat::Png)
        .unwrap();
    let mut b = Builder::default();
    let p = b.floats("VEC3", 3, &TRIANGLE);
    let uv = b.floats("VEC2", 3, &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    let view = b.view(picture.get_ref(), "");
    let color = b.data(5121, "VEC3", 3, &[255; 9]);
    let more = format!(
        r#","images":[{{"bufferView":{view}}},{{"bufferView":{view},"mimeType":"image/png"}}],
        "samplers":[{{"minFilter":9984,"magFilter":9728,"wrapS":33071,"wrapT":33648}}],
        "textures":[{{"source":0}},{{"source":1,"sampler":0}},{{"extensions":{{"KHR_texture_basisu":{{"source":0}}}}}}],
        "materials":[{{"alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true,"emissiveFactor":[1,0.5,0],
        "extensions":{{"KHR_materials_unlit":{{}},"KHR_materials_emissive_strength":{{"emissiveStrength":4}}}},
        "pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0.125,"baseColorTexture":{{"index":1,
        "texCoord":3,"extensions":{{"KHR_texture_transform":{{"offset":[0,1],"rotation":1.5707963267948966,"scale":[0.5,0.25]}}}}}}}},
        "normalTexture":{{"index":0,"scale":2}},"occlusionTexture":{{"index":2,"strength":0.5}}}}]"#
    );
    let primitive = format!(
        r#""attributes":{{"POSITION":{p},"TEXCOORD_0":{uv},"TEXCOORD_1":{uv},"COLOR_0":{color}}},"material":0"#
    );
    let scene = b.draw(&primitive, &more).unwrap();
    let (mesh, material) = (&scene.meshes[0], &scene.materials[scene.meshes[0].material]);
    assert_eq!(scene.images.len(), 1, "one picture behind two images is decoded once");
    assert_eq!(scene.images[0].rgba8, [10, 20, 30, 255, 10, 20, 30, 255]);
    let base = material.base_color_texture.as_ref().unwrap();
    let expected = [[0.0, 0.25, 0.0], [-0.5, 0.0, 1.0]];
    for (row, expected) in base.uv_transform.iter().zip(expected) {
        assert!(row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{row:?}");
    }
    assert_eq!((base.uv_set, base.sampler.wrap_u, base.sampler.wrap_v), (0, Wrap::ClampToEdge, Wrap::MirroredRepeat));
    assert!(base.sampler.mipmapped && !base.sampler.mip_linear && !base.sampler.min_linear && !base.sampler.mag_linear);
    assert_eq!((material.alpha, material.double_sided, material.unlit), (AlphaMode::Mask(0.25), true, true));
    assert_eq!((material.emissive, material.metallic, material.normal_scale), ([4.0, 2.0, 0.0], 0.125, 2.0));
    assert!(material.occlusion_texture.is_none() && warned(&scene, "1 texture in WebP, KTX2"));
    assert!(warned(&scene, "coordinate set other than 0 and 1"));
    assert_eq!((mesh.uvs[0].len(), mesh.uvs[1].len()), (3, 0), "a set that no texture reads is dropped");
    assert_eq!(mesh.colors, [[255.0, 255.0, 255.0, 1.0]; 3]);
    assert!(mesh.tangents.iter().all(|t| (t[0] - 1.0).abs() < 1e-6 && t[3] == 1.0), "{:?}", mesh.tangents);
    assert_eq!(mesh.tangents.len(), 3);

    let bare = format!(r#""attributes":{{"POSITION":{p}}},"material":0"#);
    let scene = b.draw(&bare, &more).unwrap();
    assert!(scene.materials[scene.meshes[0].material].normal_texture.is_none());
    assert!(warned(&scene, "drawn without either map") && warned(&scene, "sampled at (0, 0)"), "{:?}", scene.warnings);
}

#[test]
fn node_transforms_are_multiplied_in_f64() {
    let mut b = Builder::default();
    let p = b.floats("VEC3", 3, &TRIANGLE);
    let rest = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p}}}}}]}}],"scene":1,"scenes":[{{}},{{"nodes":[0]}}],
        "nodes":[{{"children":[1,2,3],"translation":[1e7,0,0],"scale":[-2,1,1]}},{{"mesh":0,"translation":[0.25,0,0]}},
        {{"mesh":0,"scale":[0,1,1]}},{{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1],"skin":0}}]"#
    );
    let scene = load_slice(&b.glb(&rest), None, "test.glb").unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2), "the flat node is dropped");
    let at = |i: usize| scene.instances[i].object_to_world.transform_point3(DVec3::ZERO);
    assert_eq!([at(0), at(1)], [DVec3::new(1e7 - 0.5, 0.0, 0.0), DVec3::new(1e7 - 10.0, 6.0, 7.0)]);
    assert!(scene.instances[0].object_to_world.determinant() < 0.0);
    assert!(warned(&scene, "scale of zero") && warned(&scene, "1 skinned node"), "{:?}", scene.warnings);
}

#[test]
fn cameras_lose_scale_and_mirroring() {
    let rest = r#""cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1,"zfar":50}},
        {"type":"orthographic","orthographic":{"xmag":2,"ymag":1,"znear":-1,"zfar":1}}],
        "nodes":[{"camera":0,"name":"eye","scale":[-3,2,5],"translation":[1,2,3]},{"camera":1}]"#;
    let scene = nodes(rest).unwrap();
    let eye = &scene.cameras[0];
    assert_eq!(eye.name, "eye");
    assert!(eye.camera_to_world.abs_diff_eq(DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)), 1e-12));
    assert_eq!(eye.projection, Projection::Perspective { yfov: 1.0, aspect: None, znear: 0.1, zfar: Some(50.0) });
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { xmag: 2.0, ymag: 1.0, znear: -1.0, zfar: 1.0 });
    assert!(warned(&scene, "1 camera in a mirrored node"));
}

#[test]
fn lights_keep_range_and_intensity_under_scale() {
    let rest = r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","name":"lamp","range":4,"intensity":7},
        {"type":"spot","color":[1,0.5,0.25],"spot":{"innerConeAngle":1,"outerConeAngle":3}},{"type":"directional"}]}},
        "nodes":[{"scale":[10,10,10],"translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}},
        {"rotation":[1,0,0,1],"extensions":{"KHR_lights_punctual":{"light":1}}},
        {"extensions":{"KHR_lights_punctual":{"light":2}}}]"#;
    let lights = nodes(rest).unwrap().lights;
    assert_eq!((lights[0].range, lights[0].intensity, lights[0].name.as_str()), (Some(4.0), 7.0, "lamp"));
    assert_eq!(lights[0].position, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(lights[1].kind, LightKind::Spot { inner: 1.0, outer: 3.0 });
    assert!(lights[1].direction.abs_diff_eq(DVec3::Y, 1e-12), "a quarter turn about x: {}", lights[1].direction);
    assert_eq!((lights[2].kind, lights[2].direction, lights[2].range), (LightKind::Directional, DVec3::NEG_Z, None));
}

#[test]
fn lights_ask_for_shadows_in_their_extras() {
    let of = |extras: &str| {
        let rest = format!(
            r#""extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","name":"lamp","extras":{extras}}}]}}}},
            "nodes":[{{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#
        );
        nodes(&rest)
    };
    for (extras, asks) in [
        (r#"{"lampyris":{"shadow":true}}"#, true),
        (r#"{"lampyris":{"shadow":false}}"#, false),
        (r#"{"lampyris":{}}"#, false),
        (r#"{"other":{"shadow":true}}"#, false),
        (r#""text""#, false),
    ] {
        assert_eq!(of(extras).expect("a scene").lights[0].shadow, asks, "{extras}");
    }
    let refused = of(r#"{"lampyris":{"shadow":1}}"#).expect_err("a number").to_string();
    assert!(refused.contains("light \"lamp\"") && refused.contains("lampyris.shadow"), "{refused}");
    let noted = of(r#"{"lampyris":{"shadows":true}}"#).expect("a scene");
    assert!(!noted.lights[0].shadow && warned(&noted, "1 member of extras.lampyris that is not known: ignored"));
}

#[test]
fn own_extras_name_the_member_that_is_wrong() {
    let refused = |own: &str| {
        let mut b = Builder::default();
        let p = b.floats("VEC3", 3, &TRIANGLE);
        let more = format!(r#","materials":[{{"extras":{{"lampyris":{{{own}}}}}}}]"#);
        let drawn = b.draw(&format!(r#""attributes":{{"POSITION":{p}}},"material":0"#), &more);
        drawn.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for (own, member, why) in [
        (r#""color":[1,0,0]"#, "lampyris.color", "without a model"),
        (r#""exponent":2"#, "lampyris.exponent", "without a model"),
        (r#""model":"toon""#, "lampyris.model", "none of lambert"),
        (r#""heightTexture":{"index":0,"scale":1.5}"#, "lampyris.heightTexture.scale", "1.5 is not in 0 to 1"),
        (r#""heightTexture":{"index":0,"channel":4}"#, "lampyris.heightTexture.channel", "4 is not"),
    ] {
        let sentence = refused(own);
        assert!(sentence.contains(member) && sentence.contains(why), "{own}: {sentence}");
    }
    assert_eq!(refused(r#""model":"rim","color":[1,0,0]"#), "");
}
