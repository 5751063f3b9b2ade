//! Files that are wrong, by mistake or by intent: each ends in a sentence that says what and where.

use super::tests::{Builder, TRIANGLE, bytes_of};
use super::*;
use crate::scene::mutate::Mutator;

fn refusal(result: Result<Scene>) -> String {
    match result {
        Ok(scene) => format!("accepted, with {:?}", scene.warnings),
        Err(e) => e.to_string(),
    }
}

/// A builder with the triangle as accessor 0, and the primitive that draws it.
fn triangle() -> (Builder, &'static str) {
    let mut b = Builder::default();
    b.floats("VEC3", 3, &TRIANGLE);
    (b, r#""attributes":{"POSITION":0}"#)
}

#[test]
fn accessors_that_pass_an_end() {
    let view = r#""bufferView":1,"componentType":5126,"type":"VEC3""#;
    for (members, words) in [
        (
            format!(r#"{view},"count":3,"byteOffset":4"#),
            "accessors[1]: byteOffset 4 + 36 bytes pass the end of bufferViews[1]",
        ),
        (format!(r#"{view},"count":4"#), "byteOffset 0 + 48 bytes pass the end of bufferViews[1] (36 bytes)"),
        (format!(r#"{view},"count":18446744073709551615"#), "pass the end of bufferViews[1]"),
        (format!(r#"{view},"count":3,"byteOffset":18446744073709551615"#), "pass the end of bufferViews[1]"),
        (format!(r#"{view},"count":-1"#), "accessors[1].count: -1 is not a whole number"),
        (format!(r#"{view},"count":1e999"#), "accessors[1].count: number out of range at line 1"),
        (view.to_owned(), "accessors[1]: has no count"),
        (r#""bufferView":9,"componentType":5126,"type":"VEC3","count":1"#.to_owned(), "9 is out of range"),
        (r#""bufferView":1,"componentType":5127,"type":"VEC3","count":1"#.to_owned(), "5127 is not a component type"),
        (r#""bufferView":1,"componentType":5126,"type":"MAT4","count":1"#.to_owned(), "accessors[1].type: MAT4"),
        (r#""componentType":5126,"type":"VEC3","count":1048577"#.to_owned(), "at most 1048576 such elements"),
        (
            format!(
                r#"{view},"count":3,"sparse":{{"count":4,"indices":{{"bufferView":1,"componentType":5121}},"values":{{"bufferView":1}}}}"#
            ),
            "accessors[1].sparse: count 4 is more than",
        ),
        (
            format!(
                r#"{view},"count":3,"sparse":{{"count":2,"indices":{{"bufferView":1,"componentType":5121}},"values":{{"bufferView":1}}}}"#
            ),
            "accessors[1].sparse.indices: index 1 is not greater",
        ),
    ] {
        let (mut b, _) = triangle();
        b.view(&bytes_of(&TRIANGLE), "");
        b.accessor(&members);
        let said = refusal(b.draw(r#""attributes":{"POSITION":1}"#, ""));
        assert!(said.starts_with("test.glb: ") && said.contains(words), "{members}: {said}");
    }
}

#[test]
fn views_and_strides_that_are_wrong() {
    for (extra, words) in [
        (r#","byteStride":8"#, "an element has 12 bytes, but bufferViews[1].byteStride is 8"),
        (r#","byteStride":200"#, "pass the end"),
    ] {
        let (mut b, _) = triangle();
        let view = b.view(&bytes_of(&TRIANGLE), extra);
        b.accessor(&format!(r#""bufferView":{view},"componentType":5126,"count":3,"type":"VEC3""#));
        let said = refusal(b.draw(r#""attributes":{"POSITION":1}"#, ""));
        assert!(said.contains(words), "{said}");
    }
    let json = |buffer: &str, view: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{{buffer}}}],"bufferViews":[{{"buffer":0,{view}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]}}"#
        )
    };
    for (buffer, view, words) in [
        (r#""byteLength":36"#, r#""byteLength":36"#, "buffers[0]: has no uri"),
        (r#""byteLength":9,"uri":"data:;base64,AAAA""#, r#""byteLength":36"#, "byteLength is 9, but there are 3 bytes"),
        (r#""byteLength":3,"uri":"data:;base64,AAAA""#, r#""byteLength":36"#, "pass the end of buffers[0] (3 bytes)"),
        (
            r#""byteLength":3,"uri":"data:;base64,A?""#,
            r#""byteLength":36"#,
            "buffers[0].uri: the data URI has a character",
        ),
        (r#""byteLength":3,"uri":"http://x/y.bin""#, r#""byteLength":36"#, "buffers[0].uri"),
        (r#""byteLength":3,"uri":"other.bin""#, r#""byteLength":36"#, "only data inside the file"),
    ] {
        let said = refusal(load_slice(json(buffer, view).as_bytes(), None, "test.gltf"));
        assert!(said.contains(words), "{said}");
    }
    let said = refusal(load_slice(
        json(r#""byteLength":3,"uri":"none.bin""#, r#""byteLength":3"#).as_bytes(),
        Some(Path::new(".")),
        "t",
    ));
    assert!(said.contains("buffers[0].uri") && said.contains("cannot be read"), "{said}");
}

#[test]
fn mesh_data_that_is_wrong() {
    let (mut b, _) = triangle();
    b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, f32::INFINITY, 0.0, 0.0, 1.0, 0.0]);
    b.data(5121, "SCALAR", 3, &[0, 1, 3]);
    b.floats("VEC2", 2, &[0.0; 4]);
    b.floats("VEC3", 3, &[f32::NAN; 9]);
    let textured = r#","materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],
        "images":[{"uri":"data:;base64,AAAA"}]"#;
    for (primitive, more, words) in [
        (
            r#""attributes":{"POSITION":1}"#,
            "",
            "meshes[0].primitives[0].attributes.POSITION: accessors[1]: element 1 is not",
        ),
        (r#""attributes":{"POSITION":0},"indices":2"#, "", "accessors[2]: index 2 is 3, but POSITION has 3 elements"),
        (r#""attributes":{"POSITION":0},"indices":0"#, "", "not a list of unsigned integers"),
        (r#""attributes":{"POSITION":0,"NORMAL":3}"#, "", "NORMAL: accessors[3] has 2 components instead of 3"),
        (r#""attributes":{"POSITION":0,"COLOR_0":3}"#, "", "COLOR_0: accessors[3] has 2 components"),
        (r#""attributes":{"POSITION":0,"COLOR_0":4}"#, "", "COLOR_0: accessors[4]: element 0 is not a finite"),
        (r#""attributes":{"POSITION":0},"mode":7"#, "", "primitives[0].mode: 7 is not a primitive mode"),
        (r#""attributes":{"POSITION":0},"material":1"#, "", "primitives[0].material: 1 is out of range"),
        (r#""attributes":{"POSITION":0},"material":0"#, textured, "images[0]: the picture is neither PNG nor JPEG"),
        (
            r#""attributes":{"POSITION":0},"material":0"#,
            r#","materials":[{"emissiveFactor":[0,-1,0]}]"#,
            "number 1 is -1",
        ),
        (
            r#""attributes":{"POSITION":0},"material":0"#,
            r#","materials":[{"pbrMetallicRoughness":{"roughnessFactor":1e39}}]"#,
            "roughnessFactor: 1e39 is not a finite number",
        ),
        (r#""attributes":[]"#, "", "primitives[0].attributes: is not an object"),
    ] {
        let said = refusal(b.draw(primitive, more));
        assert!(said.contains(words), "{primitive}: {said}");
    }
}

#[test]
fn nodes_lights_and_cameras_that_are_wrong() {
    let light = |members: &str| {
        format!(
            r#""extensions":{{"KHR_lights_punctual":{{"lights":[{{"name":"lamp",{members}}}]}}}},
            "nodes":[{{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#
        )
    };
    let camera = |members: &str| format!(r#""cameras":[{{{members}}}],"nodes":[{{"camera":0}}]"#);
    for (rest, words) in [
        (
            r#""scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}]"#.to_owned(),
            "nodes[0]: is reached twice",
        ),
        (r#""scenes":[{"nodes":[0]}],"nodes":[{"children":[1,1]},{}]"#.to_owned(), "nodes[1]: is reached twice"),
        (r#""nodes":[{"children":[5]}]"#.to_owned(), "nodes[0].children[0]: 5 is out of range"),
        (r#""nodes":[{"rotation":[0,0,0,0]}]"#.to_owned(), "nodes[0].rotation: the quaternion"),
        (r#""nodes":[{"scale":[1,1]}]"#.to_owned(), "nodes[0].scale: has 2 numbers instead of 3"),
        (r#""nodes":[{"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]"#.to_owned(), "last row"),
        (
            light(r#""type":"point","range":0"#),
            "light \"lamp\": extensions.KHR_lights_punctual.lights[0].range: 0 is not",
        ),
        (light(r#""type":"spot","spot":{"innerConeAngle":1,"outerConeAngle":0.5}"#), "lamp"),
        (light(r#""type":"spot","spot":{"outerConeAngle":3.2}"#), "greater than pi"),
        (light(r#""type":"area""#), "is not directional"),
        (light(r#""type":"point","intensity":-1"#), "intensity: -1 is negative"),
        (camera(r#""type":"perspective","perspective":{"yfov":4,"znear":1}"#), "yfov: 4 is not between"),
        (camera(r#""type":"perspective","perspective":{"yfov":1,"znear":0}"#), "znear: 0 is not positive"),
        (
            camera(r#""type":"orthographic","orthographic":{"xmag":0,"ymag":1,"znear":0,"zfar":1}"#),
            "xmag: must not be 0",
        ),
    ] {
        let said = refusal(load_slice(&Builder::default().glb(&rest), None, "test.glb"));
        assert!(said.contains(words), "{rest}: {said}");
    }
}

#[test]
fn memory_is_bounded_by_the_file() {
    // 64 primitives of a million vertices that no byte stands for, and one small list of triangles drawn a thousand
    // times.
    let (mut b, primitive) = triangle();
    b.accessor(r#""componentType":5126,"count":1000000,"type":"VEC3""#);
    let zeros = vec![r#"{"attributes":{"POSITION":1}}"#; 64].join(",");
    let rest = format!(r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{zeros}]}}]"#);
    let said = refusal(load_slice(&b.glb(&rest), None, "test.glb"));
    assert!(said.contains("meshes[0].primitives[") && said.contains("unpacking needs more than"), "{said}");

    let many = vec![format!("{{{primitive}}}"); 2000].join(",");
    let nodes = vec![r#"{"mesh":0}"#; 600].join(",");
    let rest = format!(r#""nodes":[{nodes}],"meshes":[{{"primitives":[{many}]}}]"#);
    let said = refusal(load_slice(&b.glb(&rest), None, "test.glb"));
    assert!(said.contains("more than 1048576 primitives"), "{said}");

    let lists = format!("[{}]", vec!["[]"; 300_000].join(","));
    let said = refusal(load_slice(lists.as_bytes(), None, "test.gltf"));
    assert!(said.starts_with("test.gltf: the JSON text: unpacking needs more than"), "{said}");
}

#[test]
fn pictures_larger_than_their_bytes_are_refused() {
    let mut header = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    header.extend(16384u32.to_be_bytes());
    header.extend(16384u32.to_be_bytes());
    header.extend([8, 6, 0, 0, 0, 0, 0, 0, 0]);
    let (mut b, primitive) = triangle();
    let view = b.view(&header, "");
    let more = format!(
        r#","materials":[{{"emissiveTexture":{{"index":0}}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":{view}}}]"#
    );
    let primitive = format!(r#"{primitive},"material":0"#);
    let said = refusal(b.draw(&primitive, &more));
    assert!(said.contains("images[0]: 33 bytes cannot hold a picture of 16384x16384"), "{said}");
    header[16..20].copy_from_slice(&20000u32.to_be_bytes());
    let mut b = triangle().0;
    b.view(&header, "");
    let said = refusal(b.draw(&primitive, &more));
    assert!(said.contains("each side may be 1 to 16384"), "{said}");
}

#[test]
fn texts_that_are_no_gltf() {
    for (text, words) in [
        ("", "the file is empty"),
        ("{", "ends too early"),
        ("[]", "is not an object"),
        ("{}", "has no asset"),
        (r#"{"asset":{"version":"1.0"}}"#, "only glTF 2"),
        (r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_audio"]}"#, "requires KHR_audio"),
        ("glTF", "GLB header"),
    ] {
        let said = refusal(load_slice(text.as_bytes(), None, "test.gltf"));
        assert!(said.starts_with("test.gltf: ") && said.contains(words), "{text}: {said}");
    }
    assert!(load_slice(br#"{"asset":{"version":"2.0"}}"#, None, "t").unwrap().instances.is_empty());
}

/// A file that uses most of what the loader reads.
fn rich() -> Vec<u8> {
    let mut picture = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(4, 4, image::Luma([99])).write_to(&mut picture, image::ImageFormat::Png).unwrap();
    let (mut b, _) = triangle();
    b.floats("VEC2", 3, &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    b.data(5121, "SCALAR", 5, &[0, 1, 2, 0, 1]);
    let view = b.view(picture.get_ref(), "");
    b.accessor(
        r#""componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":0}}"#,
    );
    b.glb(&format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"children":[1,2],"scale":[1,2,3]}},{{"camera":0}},
        {{"rotation":[0,0,0,1],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.1}}}}],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","spot":{{"outerConeAngle":0.5}},"range":9}}]}}}},
        "images":[{{"bufferView":{view}}}],"textures":[{{"source":0}}],
        "materials":[{{"normalTexture":{{"index":0}},"alphaMode":"BLEND"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}},
        {{"attributes":{{"POSITION":0,"NORMAL":3}},"indices":2,"mode":5}}]}}]"#
    ))
}

#[test]
fn two_thousand_mutations_end_in_a_scene_or_a_sentence() {
    let original = rich();
    let scene = load_slice(&original, None, "rich.glb").unwrap();
    assert_eq!((scene.meshes.len(), scene.cameras.len(), scene.lights.len(), scene.images.len()), (2, 1, 1, 1));
    let (mut drawn, mut refused) = (0, 0);
    for seed in [1, 2] {
        let mut mutator = Mutator::new(seed);
        for _ in 0..1000 {
            match load_slice(&mutator.mutate(&original), None, "rich.glb") {
                Ok(scene) => {
                    scene.validate().unwrap();
                    drawn += 1;
                }
                Err(e) => {
                    assert!(e.to_string().starts_with("rich.glb: "), "{e}");
                    refused += 1;
                }
            }
        }
    }
    assert!(drawn > 30 && refused > 300, "the mutations are too weak or too strong: {drawn} drawn, {refused} refused");
}
