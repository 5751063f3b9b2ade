//! The table of hard cases: numbers and axes in scenes and requests that are none, or past what can be computed with.

use glam::{DVec3, Vec3};
use lampyris::Result;
use lampyris::plan::{CameraChoice, Limits, Plan, Request, Technique};
use lampyris::reference::render::Reference;
use lampyris::reference::shade::Shader;
use lampyris::scene::lighting::{Attenuation, RangeRule};
use lampyris::scene::{
    AlphaMode, IDENTITY_UV, Image, Light, LightKind, Projection, Sampler, Scene, Texture, builtin, gltf,
};

pub fn lamp() -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Spot { inner: 0.2, outer: 0.5 },
        color: [1.0; 3],
        intensity: 100.0,
        position: DVec3::new(0.0, 1.0, 0.0),
        direction: DVec3::NEG_Y,
        range: None,
        shadow: false,
    }
}

/// A room with a spot light and a point light, a texture on everything.
pub fn room() -> Scene {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    scene.lights = vec![lamp(), Light { kind: LightKind::Point, ..lamp() }];
    scene.images.push(Image { name: "white".into(), width: 1, height: 1, rgba8: vec![255; 4] });
    for material in &mut scene.materials {
        material.base_color_texture =
            Some(Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV });
    }
    for mesh in &mut scene.meshes {
        mesh.uvs[0] = vec![[0.25, 0.75]; mesh.positions.len()];
    }
    scene
}

/// A spot light on a node of one scale.
pub fn scaled_lamp(scale: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_lights_punctual"],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","name":"lamp","range":3,"spot":{{}}}}]}}}},
        "nodes":[{{"scale":[{scale},{scale},{scale}],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]}}"#
    )
}

#[test]
fn l1_axes_that_are_no_direction_are_refused_by_name() {
    for axis in [DVec3::ZERO, DVec3::X * 1e-20, DVec3::X * 1e20] {
        let mut scene = room();
        scene.lights[0].direction = axis;
        let said = scene.validate().expect_err("no direction").to_string();
        assert!(said.contains("light 0 \"lamp\"") && said.contains("axis"), "{axis}: {said}");
    }
    // In a file the axis is the node's, so its length is the node's scale.
    for scale in ["1e-20", "1", "1e20"] {
        let scene = gltf::load_slice(scaled_lamp(scale).as_bytes(), None, "lamp.gltf").expect(scale);
        assert!((scene.lights[0].direction - DVec3::NEG_Z).length() < 1e-15, "{scale}");
    }
    let said = gltf::load_slice(scaled_lamp("0").as_bytes(), None, "lamp.gltf").expect_err("no axis").to_string();
    assert!(said.contains("lamp.gltf") && said.contains("\"lamp\"") && said.contains("axis"), "{said}");
}

/// What a request makes of a scene without a device: a sentence, or whether every number is finite.
fn outcome(scene: &Scene, request: &Request) -> Result<bool> {
    scene.validate()?;
    let plan = Plan::new(scene, request, &Limits::UNLIMITED)?;
    // 1 / range^2 may be infinite: that light reaches nothing.
    let lights = plan.lights.texels.iter().enumerate().all(|(i, texel)| {
        let is_place = (i as u32).is_multiple_of(plan.lights.texels_each);
        texel[..3].iter().all(|x| x.is_finite()) && (texel[3].is_finite() || is_place && texel[3] == f32::INFINITY)
    });
    let lens = plan.view.view_to_clip().as_mat4().is_finite();
    let reference = Reference::new(scene, &plan.view)?;
    let picture = reference.render(&Shader::new(&plan.lighting, &plan.view, plan.shading), &|_| {});
    Ok(lights && lens && picture.rgba.iter().flatten().all(|x| x.is_finite()))
}

/// NaN, infinite, negative, denormal in f32, denormal in f64 (and 0 in f32).
const NUMBERS: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 1e-40, 1e-310];

type Spoil = fn(&mut Scene, &mut Request, f64);

/// Each number in each field: the refusal has one of the field's words, or the picture is finite.
fn refused_or_finite(fields: &[(&str, Spoil)]) {
    let mut wrong = Vec::new();
    for (words, spoil) in fields {
        for number in NUMBERS {
            let (mut scene, mut request) =
                (room(), Request { width: 8, height: 6, technique: Technique::Forward, ..Request::default() });
            spoil(&mut scene, &mut request, number);
            match outcome(&scene, &request) {
                Ok(true) => {}
                Ok(false) => wrong.push(format!("{words} = {number:e}: accepted, and not finite")),
                Err(error) if words.split('|').any(|word| error.to_string().contains(word)) => {}
                Err(error) => wrong.push(format!("{words} = {number:e}: not named: {error}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn l8_numbers_of_lights() {
    refused_or_finite(&[
        ("color", |s, _, x| s.lights[0].color[1] = x as f32),
        ("intensity", |s, _, x| s.lights[0].intensity = x as f32),
        ("position", |s, _, x| s.lights[1].position.y = x),
        ("axis", |s, _, x| s.lights[0].direction.x = x),
        ("axis", |s, _, x| s.lights[1].direction.x = x),
        ("range", |s, _, x| s.lights[0].range = Some(x as f32)),
        ("cone", |s, _, x| s.lights[0].kind = LightKind::Spot { inner: x as f32, outer: 0.5 }),
        ("cone", |s, _, x| s.lights[0].kind = LightKind::Spot { inner: 0.0, outer: x as f32 }),
    ]);
}

#[test]
fn l8_numbers_of_materials() {
    refused_or_finite(&[
        ("base_color", |s, _, x| s.materials[0].base_color[2] = x as f32),
        ("metallic", |s, _, x| s.materials[0].metallic = x as f32),
        ("roughness", |s, _, x| s.materials[0].roughness = x as f32),
        ("normal_scale", |s, _, x| s.materials[0].normal_scale = x as f32),
        ("occlusion_strength", |s, _, x| s.materials[0].occlusion_strength = x as f32),
        ("emissive", |s, _, x| s.materials[0].emissive[0] = x as f32),
        ("alpha cut-off", |s, _, x| s.materials[0].alpha = AlphaMode::Mask(x as f32)),
        ("uv_transform", |s, _, x| {
            if let Some(texture) = &mut s.materials[0].base_color_texture {
                texture.uv_transform[0][2] = x as f32;
            }
        }),
    ]);
}

fn perspective(scene: &mut Scene, yfov: f64, aspect: Option<f64>, znear: f64, zfar: Option<f64>) {
    scene.cameras[0].projection = Projection::Perspective { yfov, aspect, znear, zfar };
}

fn orthographic(scene: &mut Scene, xmag: f64, ymag: f64, znear: f64, zfar: f64) {
    scene.cameras[0].projection = Projection::Orthographic { xmag, ymag, znear, zfar };
}

#[test]
fn l8_numbers_of_cameras() {
    refused_or_finite(&[
        ("yfov|field of view", |s, _, x| perspective(s, x, None, 0.1, None)),
        ("aspect", |s, _, x| perspective(s, 1.0, Some(x), 0.1, None)),
        ("znear", |s, _, x| perspective(s, 1.0, None, x, None)),
        ("zfar", |s, _, x| perspective(s, 1.0, None, 0.1, Some(x))),
        ("xmag", |s, _, x| orthographic(s, x, 1.0, 0.1, 9.0)),
        ("ymag", |s, _, x| orthographic(s, 1.0, x, 0.1, 9.0)),
        ("znear", |s, _, x| orthographic(s, 1.0, 1.0, x, 9.0)),
        ("zfar", |s, _, x| orthographic(s, 1.0, 1.0, 0.1, x)),
        ("matrix", |s, _, x| s.cameras[0].camera_to_world.w_axis.x = x),
        ("matrix", |s, _, x| s.cameras[0].camera_to_world.x_axis.x = x),
    ]);
}

#[test]
fn l8_numbers_of_requests() {
    fn law(request: &mut Request, constant: f64, linear: f64, quadratic: f64) {
        request.rules.attenuation = Attenuation { constant, linear, quadratic };
    }
    refused_or_finite(&[
        ("--light-range", |_, r, x| r.rules.range = RangeRule::Fixed(x)),
        ("--light-cutoff", |_, r, x| r.rules.range = RangeRule::Cutoff(x)),
        ("--ambient", |_, r, x| r.rules.ambient = Vec3::new(0.0, x as f32, 0.0)),
        ("--attenuation", |_, r, x| law(r, x, 0.0, 0.0)),
        ("--attenuation", |_, r, x| law(r, 0.0, x, 0.0)),
        ("--attenuation", |_, r, x| law(r, 0.0, 0.0, x)),
        ("--look-from", |_, r, x| r.camera = CameraChoice::LookAt(DVec3::new(x, 0.0, 1.0), DVec3::ZERO, 1.0)),
        ("--look-at", |_, r, x| r.camera = CameraChoice::LookAt(DVec3::ONE, DVec3::new(x, 0.0, 0.0), 1.0)),
        ("--fov|field of view", |_, r, x| r.camera = CameraChoice::LookAt(DVec3::ONE, DVec3::ZERO, x)),
    ]);
}

#[test]
fn l9_intensities_past_f32_are_refused() {
    let mut scene = room();
    (scene.lights[0].color, scene.lights[0].intensity) = ([1e30; 3], 1e8);
    Plan::new(&scene, &Request::default(), &Limits::UNLIMITED).expect("1e38 fits f32");
    scene.lights[0].intensity = 1e9;
    let said = Plan::new(&scene, &Request::default(), &Limits::UNLIMITED).expect_err("1e39 does not").to_string();
    assert!(said.contains("intensity"), "{said}");
}
