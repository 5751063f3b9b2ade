//! What a reader gets back: the container, the geometry bit for bit, every property by its glTF name.

use glam::{DMat4, DQuat, DVec3};

use super::*;
use crate::scene::shading::{Model, OwnModel};
use crate::scene::{
    AlphaMode, Camera, Height, Image, Instance, Light, LightKind, Material, Projection, Sampler, Texture, Wrap, builtin,
};

const SPECS: [&str; 7] = ["cornell", "atrium", "corridor", "corridor:door=0", "terrain", "furnace", "glass"];

fn word(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize
}

fn json_chunk(bytes: &[u8]) -> Value {
    serde_json::from_slice(&bytes[20..20 + word(bytes, 12)]).unwrap()
}

/// Equal but for the last digit, which a reader of decimal numbers may round differently.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2.0 * f64::EPSILON * b.abs()
}

/// One triangle with every attribute, one material with every property, each kind of light and camera.
fn everything() -> Scene {
    let texture = |image: usize, uv_set: usize, sampler: Sampler| {
        Some(Texture { image, sampler, uv_set, uv_transform: [[2.0, 0.0, 0.5], [0.0, -3.0, 0.25]] })
    };
    let plain = Sampler::default();
    let odd = Sampler {
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::MirroredRepeat,
        mag_linear: false,
        min_linear: false,
        mipmapped: true,
        mip_linear: false,
    };
    let material = Material {
        name: "all".into(),
        base_color: [0.1, 0.2, 0.3, 0.4],
        base_color_texture: texture(0, 0, plain),
        metallic: 0.25,
        roughness: 0.75,
        metallic_roughness_texture: texture(0, 1, odd),
        normal_texture: texture(0, 0, plain),
        normal_scale: 0.5,
        occlusion_texture: texture(0, 0, plain),
        occlusion_strength: 0.6,
        emissive: [37.3, 0.1, 0.0],
        emissive_texture: texture(0, 0, plain),
        alpha: AlphaMode::Mask(0.3),
        double_sided: true,
        unlit: true,
        model: Some(OwnModel { model: Model::Rim, color: [0.5, 0.25, 3.0], exponent: 2.5 }),
        height: texture(0, 1, odd).map(|texture| Height { texture, channel: 3, scale: 0.125 }),
    };
    let mesh = Mesh {
        name: "triangle".into(),
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 1.0, -0.7]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        tangents: vec![[1.0, 0.0, 0.0, -1.0]; 3],
        uvs: [vec![[0.0, 0.5]; 3], vec![[0.25, 1.0]; 3]],
        colors: vec![[1.0, 0.5, 0.25, 1.0]; 3],
        indices: vec![0, 1, 2],
        material: 0,
    };
    let light = |name: &str, kind, range| Light {
        name: name.into(),
        kind,
        color: [1.0, 0.5, 3.0],
        intensity: 10.1,
        position: DVec3::new(0.1, 1e7 + 0.3, -2.0),
        direction: DVec3::new(0.3, -0.8, 0.2).normalize(),
        range,
        shadow: name == "bulb",
    };
    let turned = DMat4::from_rotation_translation(DQuat::from_rotation_y(0.7), DVec3::new(0.1, 0.2, 0.3));
    let camera = |name: &str, projection| Camera { name: name.into(), camera_to_world: turned, projection };
    Scene {
        name: "everything".into(),
        meshes: vec![mesh],
        materials: vec![material],
        images: vec![Image { name: "dots".into(), width: 2, height: 1, rgba8: vec![1, 2, 3, 4, 250, 6, 7, 0] }],
        instances: vec![
            Instance { mesh: 0, object_to_world: DMat4::IDENTITY },
            Instance { mesh: 0, object_to_world: turned * DMat4::from_scale(DVec3::new(1.0, -2.0, 0.3)) },
        ],
        lights: vec![
            light("sun", LightKind::Directional, None),
            light("bulb", LightKind::Point, Some(2.5)),
            light("lamp", LightKind::Spot { inner: 0.5, outer: 0.5 }, None),
        ],
        cameras: vec![
            camera("eye", Projection::Perspective { yfov: 0.9, aspect: Some(1.5), znear: 0.1, zfar: Some(50.0) }),
            camera("plan", Projection::Orthographic { xmag: 3.0, ymag: 2.0, znear: 0.0, zfar: 9.0 }),
        ],
        warnings: Vec::new(),
    }
}

#[test]
fn the_container_is_consistent_and_an_independent_reader_accepts_it() {
    let scenes = SPECS.map(|spec| builtin::load(spec).unwrap());
    for scene in scenes.iter().chain([&everything(), &Scene::default()]) {
        let bytes = glb(scene).unwrap();
        assert_eq!((&bytes[..4], word(&bytes, 4), word(&bytes, 8)), (&b"glTF"[..], 2, bytes.len()), "{}", scene.name);
        let json_length = word(&bytes, 12);
        assert_eq!((&bytes[16..20], json_length % 4), (&b"JSON"[..], 0));
        let binary = 20 + json_length;
        if binary < bytes.len() {
            assert_eq!((&bytes[binary + 4..binary + 8], word(&bytes, binary) % 4), (&b"BIN\0"[..], 0));
            assert_eq!(binary + 8 + word(&bytes, binary), bytes.len());
            assert_eq!(json_chunk(&bytes)["buffers"][0]["byteLength"], word(&bytes, binary));
        }
        let file = ::gltf::Gltf::from_slice(&bytes).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        assert_eq!(file.nodes().count(), scene.instances.len() + scene.lights.len() + scene.cameras.len());
    }
}

#[test]
fn geometry_comes_back_bit_for_bit() {
    for scene in [builtin::load("cornell").unwrap(), builtin::load("atrium").unwrap(), everything()] {
        let bytes = glb(&scene).unwrap();
        let file = ::gltf::Gltf::from_slice(&bytes).unwrap();
        let blob = file.blob.as_deref();
        assert_eq!(file.meshes().count(), scene.meshes.len());
        for (read, mesh) in file.meshes().zip(&scene.meshes) {
            let primitive = read.primitives().next().unwrap();
            let reader = primitive.reader(|_| blob);
            assert_eq!(reader.read_positions().unwrap().collect::<Vec<_>>(), mesh.positions);
            assert_eq!(reader.read_normals().unwrap().collect::<Vec<_>>(), mesh.normals);
            assert_eq!(reader.read_indices().unwrap().into_u32().collect::<Vec<_>>(), mesh.indices);
            if !mesh.tangents.is_empty() {
                assert_eq!(reader.read_tangents().unwrap().collect::<Vec<_>>(), mesh.tangents);
                assert_eq!(reader.read_tex_coords(1).unwrap().into_f32().collect::<Vec<_>>(), mesh.uvs[1]);
                assert_eq!(reader.read_colors(0).unwrap().into_rgba_f32().collect::<Vec<_>>(), mesh.colors);
            }
            assert_eq!((read.name(), primitive.material().index()), (Some(mesh.name.as_str()), Some(mesh.material)));
        }
        let json = json_chunk(&bytes);
        for (index, instance) in scene.instances.iter().enumerate() {
            let node = &json["nodes"][index];
            assert_eq!(node["mesh"], instance.mesh);
            let expected = instance.object_to_world.to_cols_array();
            match node["matrix"].as_array() {
                Some(read) => {
                    let same = read.iter().zip(expected).all(|(a, b)| near(a.as_f64().unwrap(), b));
                    assert!(read.len() == 16 && same, "instance {index}");
                }
                None => assert_eq!(instance.object_to_world, DMat4::IDENTITY, "instance {index}"),
            }
        }
    }
}

#[test]
fn position_bounds_are_exact() {
    let scene = everything();
    let json = json_chunk(&glb(&scene).unwrap());
    let accessor =
        &json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize];
    assert_eq!(accessor["min"], json!([0.0, 0.0, f64::from(-0.7f32)]));
    assert_eq!(accessor["max"], json!([1.0, 1.0, 0.0]));
    assert_eq!(json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize]["target"], ARRAY_BUFFER);
}

#[test]
fn material_properties_come_back() {
    let scene = everything();
    let bytes = glb(&scene).unwrap();
    let file = ::gltf::Gltf::from_slice(&bytes).unwrap();
    let (read, given) = (file.materials().next().unwrap(), &scene.materials[0]);
    let surface = read.pbr_metallic_roughness();
    assert_eq!(surface.base_color_factor(), given.base_color);
    assert_eq!((surface.metallic_factor(), surface.roughness_factor()), (given.metallic, given.roughness));
    let strength = read.emissive_strength().unwrap();
    assert_eq!(read.emissive_factor().map(|factor| factor * strength), given.emissive);
    assert!(read.emissive_factor().into_iter().all(|factor| factor <= 1.0));
    assert_eq!((read.alpha_cutoff(), read.double_sided(), read.unlit()), (Some(0.3), true, true));
    assert_eq!(read.normal_texture().unwrap().scale(), given.normal_scale);
    assert_eq!(read.occlusion_texture().unwrap().strength(), given.occlusion_strength);
    let transform = surface.base_color_texture().unwrap().texture_transform().unwrap();
    assert_eq!((transform.offset(), transform.rotation(), transform.scale()), ([0.5, 0.25], 0.0, [2.0, -3.0]));
    let odd = surface.metallic_roughness_texture().unwrap();
    assert_eq!(odd.tex_coord(), 1);
    let json = json_chunk(&bytes);
    assert_eq!(json["textures"].as_array().unwrap().len(), 2);
    let sampler = json!({ "magFilter": 9728, "minFilter": 9984, "wrapS": 33071, "wrapT": 33648 });
    assert_eq!(json["samplers"][1], sampler);
    let used =
        ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit", "KHR_texture_transform"];
    assert_eq!(json["extensionsUsed"], json!(used));
}

#[test]
fn images_come_back() {
    let scene = everything();
    let bytes = glb(&scene).unwrap();
    let json = json_chunk(&bytes);
    let view = &json["bufferViews"][json["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let start = 20 + word(&bytes, 12) + 8 + view["byteOffset"].as_u64().unwrap() as usize;
    let png = &bytes[start..start + view["byteLength"].as_u64().unwrap() as usize];
    let read = image::load_from_memory(png).unwrap().to_rgba8();
    assert_eq!((read.dimensions(), read.as_raw()), ((2, 1), &scene.images[0].rgba8));
}

#[test]
fn lights_come_back_with_place_direction_and_intensity() {
    let scene = everything();
    let bytes = glb(&scene).unwrap();
    let json = json_chunk(&bytes);
    let file = ::gltf::Gltf::from_slice(&bytes).unwrap();
    for ((index, given), read) in scene.lights.iter().enumerate().zip(file.lights().unwrap()) {
        assert_eq!(read.name(), Some(given.name.as_str()));
        // Colour and intensity are split by a power of two, so that their product is exact.
        let product = |color: [f32; 3], intensity: f32| color.map(|c| c * intensity);
        assert_eq!(product(read.color(), read.intensity()), product(given.color, given.intensity));
        assert!(read.color().into_iter().all(|c| c <= 1.0));
        assert_eq!(read.range(), given.range);
        let node = &json["nodes"][scene.instances.len() + index];
        assert_eq!(node["extensions"]["KHR_lights_punctual"]["light"], index);
        let expected = given.position.to_array();
        if given.kind == LightKind::Point {
            assert!((0..3).all(|axis| near(node["translation"][axis].as_f64().unwrap(), expected[axis])));
        } else {
            let matrix: Vec<f64> = node["matrix"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
            let matrix = DMat4::from_cols_slice(&matrix);
            assert!((-matrix.z_axis.truncate() - given.direction).length() < 1e-15);
            assert!((matrix.determinant() - 1.0).abs() < 1e-12);
            assert!((0..3).all(|axis| near(matrix.w_axis[axis], expected[axis])));
        }
    }
    let spot = &json["extensions"]["KHR_lights_punctual"]["lights"][2]["spot"];
    let angles = ["innerConeAngle", "outerConeAngle"].map(|key| spot[key].as_f64().unwrap());
    assert!(angles[0] < angles[1] && angles[1] - angles[0] < 1e-7, "{angles:?}");
}

#[test]
fn cameras_come_back() {
    let scene = everything();
    let json = json_chunk(&glb(&scene).unwrap());
    let lens = json!({ "yfov": 0.9, "znear": 0.1, "aspectRatio": 1.5, "zfar": 50.0 });
    assert_eq!(json["cameras"][0], json!({ "type": "perspective", "perspective": lens, "name": "eye" }));
    let lens = json!({ "xmag": 3.0, "ymag": 2.0, "znear": 0.0, "zfar": 9.0 });
    assert_eq!(json["cameras"][1], json!({ "type": "orthographic", "orthographic": lens, "name": "plan" }));
    let last = json["nodes"].as_array().unwrap().last().unwrap();
    assert_eq!((&last["camera"], &last["name"]), (&json!(1), &json!("plan")));
}

#[test]
fn indices_take_16_bits_up_to_65535_vertices() {
    for (count, component) in [(65_535usize, UNSIGNED_SHORT), (65_536, UNSIGNED_INT)] {
        let mut scene = everything();
        let mesh = &mut scene.meshes[0];
        *mesh = Mesh {
            positions: (0..count).map(|i| [i as f32, 0.0, (i % 2) as f32]).collect(),
            normals: vec![[0.0, 1.0, 0.0]; count],
            indices: vec![0, 1, count as u32 - 1],
            ..Mesh::default()
        };
        let bytes = glb(&scene).unwrap();
        let json = json_chunk(&bytes);
        let accessor = json["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize;
        assert_eq!(json["accessors"][accessor]["componentType"], component);
        let file = ::gltf::Gltf::from_slice(&bytes).unwrap();
        let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
        let indices: Vec<u32> = primitive.reader(|_| file.blob.as_deref()).read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, [0, 1, count as u32 - 1]);
    }
}

#[test]
fn a_second_texture_coordinate_set_alone_keeps_its_number() {
    let mut scene = everything();
    scene.meshes[0].uvs[0].clear();
    let json = json_chunk(&glb(&scene).unwrap());
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    assert!(attributes["TEXCOORD_0"].is_u64() && attributes["TEXCOORD_1"].is_u64());
}

#[test]
fn what_gltf_cannot_hold_is_refused_by_name() {
    type Spoil = fn(&mut Scene);
    let cases: [(Spoil, &str); 6] = [
        (|s| s.meshes[0].indices.clear(), "mesh 0 \"triangle\""),
        (|s| s.instances[1].object_to_world.x_axis.y += 0.5, "instance 1: its transform is sheared"),
        (|s| s.lights[2].kind = LightKind::Spot { inner: 0.1, outer: 2.0 }, "light 2 \"lamp\""),
        (|s| s.lights[1].range = Some(0.0), "light 1 \"bulb\""),
        (
            |s| s.cameras[1].projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0, znear: -1.0, zfar: 1.0 },
            "camera 1 \"plan\"",
        ),
        (|s| s.images[0].width = 3, "image 0 \"dots\""),
    ];
    for (spoil, part) in cases {
        let mut scene = everything();
        spoil(&mut scene);
        let error = glb(&scene).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    let mut scene = everything();
    scene.lights[2].kind = LightKind::Spot { inner: 0.0, outer: std::f32::consts::FRAC_PI_2 };
    let file = ::gltf::Gltf::from_slice(&glb(&scene).unwrap()).unwrap();
    assert!(file.lights().unwrap().count() == 3);
}
