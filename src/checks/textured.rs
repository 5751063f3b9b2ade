//! Textured and otherwise not plain materials on the device against rays; `judge` says how far the two may be apart.
//!
//! Derivatives are differences within a 2x2 quad, so where an edge crosses a quad they depend on lanes outside the triangle. Wrong
//! ones choose another level in single pixels along edges, which a mean over a picture hides. So triangles are 2 to 4 pixels wide,
//! texels contrast, and every pixel off by a fifth counts: linear filters have none, and nearest ones have those that a moved vertex
//! brings to another texel.

mod parallax;

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3, Vec3};

use super::Row;
use super::judge::judge;
use super::oracle::{SHADING_BOUND, shading_error};
use crate::error::Result;
use crate::math::random::Random;
use crate::plan::Request;
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::shading::{Model, OwnModel, Shading};
use crate::scene::{
    AlphaMode, Camera, IDENTITY_UV, Image, Instance, Light, LightKind, Material, Mesh, Sampler, Scene, Texture, Wrap,
};

pub use parallax::parallax;

/// Pixels.
const SIZE: [u32; 2] = [96, 72];

/// Texels along each side of a map.
const SIDE: u32 = 64;

const TRILINEAR: Sampler = Sampler {
    wrap_u: Wrap::Repeat,
    wrap_v: Wrap::Repeat,
    mag_linear: true,
    min_linear: true,
    mipmapped: true,
    mip_linear: true,
};

const LEVEL_0: Sampler = Sampler { mipmapped: false, mip_linear: false, ..TRILINEAR };

/// The nearest texel of the nearest level.
const NEAREST: Sampler = Sampler { mag_linear: false, min_linear: false, mip_linear: false, ..TRILINEAR };

/// Low and high codes of colours, bright so that an error is a small part of a value.
const COLORS: [[u8; 4]; 2] = [[188, 188, 188, 255], [255; 4]];

/// A picture that is judged.
struct Case {
    name: &'static str,
    scene: Scene,
    shading: Shading,
    ambient: f32,
}

/// Triangles over a rectangle of parameters from 0 to 1; `place` gives position, normal and tangent. UV set 0 repeats the
/// parameters, set 1 is turned by a quarter and coarser.
fn woven([columns, rows]: [u32; 2], repeats: DVec2, place: impl Fn(DVec2) -> [DVec3; 3]) -> Mesh {
    let mut mesh = Mesh { name: "woven".into(), ..Mesh::default() };
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let at = DVec2::new(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
        let [position, normal, tangent] = place(at);
        let uv = at * repeats;
        mesh.positions.push(position.as_vec3().to_array());
        mesh.normals.push(normal.as_vec3().to_array());
        mesh.tangents.push(tangent.extend(1.0).as_vec4().to_array());
        mesh.uvs[0].push(uv.as_vec2().to_array());
        mesh.uvs[1].push((DVec2::new(uv.y, -uv.x) * 0.7).as_vec2().to_array());
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let a = row * (columns + 1) + column;
        let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
        mesh.indices.extend([c, d, b, c, b, a]);
    }
    mesh
}

/// A square in the plane z = 0, seen from +z, with 61 texels of level 0 to a metre.
fn sheet(half: f64) -> Mesh {
    let place = |at: DVec2| [DVec3::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0) * half, DVec3::Z, DVec3::X];
    woven([(18.0 * half) as u32; 2], DVec2::splat(1.9 * half), place)
}

fn ball() -> Mesh {
    woven([48, 24], DVec2::new(4.0, 2.0), |at| {
        let ((sin, cos), (z, x)) = ((PI * at.y).sin_cos(), (TAU * at.x).sin_cos());
        let normal = DVec3::new(sin * x, cos, -sin * z);
        [normal, normal, DVec3::new(-z, 0.0, -x)]
    })
}

/// The map runs the other way along u.
fn mirrored(mut mesh: Mesh) -> Mesh {
    mesh.uvs[0].iter_mut().for_each(|uv| uv[0] = -uv[0]);
    mesh.tangents.iter_mut().for_each(|t| *t = [-t[0], -t[1], -t[2], -t[3]]);
    mesh
}

/// Checks of 8, 2 and 1 texels and noise, each channel from its low to its high code.
fn image([low, high]: [[u8; 4]; 2], seed: u64) -> Image {
    let mut random = Random::new(seed);
    let mut rgba8 = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        for channel in 0..4 {
            let check = |size: u32, shift: u32| f64::from((x / size + y / size + shift) % 2);
            let noise = random.unit_f64();
            let part = 0.4 * check(8, channel) + 0.2 * check(2, 0) + 0.15 * check(1, 0) + 0.25 * noise;
            let (low, high) = (f64::from(low[channel as usize]), f64::from(high[channel as usize]));
            rgba8.push((low + (high - low) * part + 0.5) as u8);
        }
    }
    Image { name: "checks and noise".into(), width: SIDE, height: SIDE, rgba8 }
}

fn texture(image: usize, sampler: Sampler) -> Texture {
    Texture { image, sampler, uv_set: 0, uv_transform: IDENTITY_UV }
}

/// The same through a `KHR_texture_transform` that turns by 0.5 rad, stretches and moves.
fn turned(texture: Texture) -> Texture {
    let (sin, cos) = 0.5f32.sin_cos();
    Texture { uv_transform: [[1.3 * cos, 0.8 * sin, 0.3], [-1.3 * sin, 0.8 * cos, 0.1]], ..texture }
}

fn tilt() -> DMat4 {
    DMat4::from_rotation_x(-0.9) * DMat4::from_rotation_y(0.3)
}

fn dielectric() -> Material {
    Material { metallic: 0.0, roughness: 0.5, ..Material::default() }
}

/// One tilted mesh under a light close to the camera.
fn scene(mesh: Mesh, material: Material, images: Vec<Image>) -> Scene {
    let light = Light {
        name: "lamp".into(),
        kind: LightKind::Point,
        color: [1.0; 3],
        intensity: 40.0,
        position: DVec3::new(0.5, 1.0, 4.0),
        direction: DVec3::NEG_Z,
        range: None,
        shadow: false,
    };
    Scene {
        name: "textured".into(),
        meshes: vec![mesh],
        materials: vec![material],
        images,
        instances: vec![Instance { mesh: 0, object_to_world: tilt() }],
        lights: vec![light],
        cameras: vec![Camera::looking(DVec3::Z * 3.2, DVec3::ZERO, 40f64.to_radians())],
        ..Scene::default()
    }
}

/// Two small sheets side by side, the second given.
fn pair(mut scene: Scene, second: Mesh) -> Scene {
    scene.meshes.push(second);
    let beside =
        |mesh: usize, x: f64| Instance { mesh, object_to_world: tilt() * DMat4::from_translation(DVec3::X * x) };
    scene.instances = vec![beside(0, -0.7), beside(1, 0.7)];
    scene
}

fn painted(mesh: Mesh, texture: Texture) -> Scene {
    let material = Material { base_color_texture: Some(texture), ..dielectric() };
    scene(mesh, material, vec![image(COLORS, 7)])
}

fn rows(renderer: &Renderer, cases: Vec<Case>) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let (mut misplaced, mut not_finite, mut blind) = (0, 0, 0);
    for Case { name, scene, shading, ambient } in cases {
        let rules = LightRules { ambient: Vec3::splat(ambient), range: RangeRule::Infinite, ..LightRules::default() };
        let request = Request { width: SIZE[0], height: SIZE[1], shading, rules, ..crate::checks::forward() };
        let judged = judge(renderer, &scene, &request)?;
        misplaced += judged.misplaced;
        not_finite += judged.not_finite;
        // A sixteenth of the picture: the holes of a mask leave the least.
        blind += usize::from(judged.interior < (SIZE[0] * SIZE[1] / 16) as usize);
        rows.push(Row::at_most(format!("{name}, mean"), judged.error, judged.bound));
        rows.push(Row {
            name: format!("{name}, pixels off by a fifth"),
            passed: judged.outliers <= judged.outlier_bound,
            detail: format!("{} of {}, at most {}", judged.outliers, judged.interior, judged.outlier_bound),
        });
    }
    rows.push(Row::none("textured, covered where rays hit", misplaced, "pixels that are not, away from edges"));
    rows.push(Row::none("textured, finite", not_finite, "pixels that are not"));
    rows.push(Row::none("textured, pictures that show too little", blind, "pictures"));
    Ok(rows)
}

/// Base colours through every wrapping and filter, transform and UV set.
pub fn samplers(renderer: &Renderer) -> Result<Vec<Row>> {
    let wrapped = |wrap: Wrap| turned(texture(0, Sampler { wrap_u: wrap, wrap_v: wrap, ..TRILINEAR }));
    let level_nearest = Sampler { mip_linear: false, ..TRILINEAR };
    let level_0_nearest = Sampler { mipmapped: false, ..NEAREST };
    let second_set = Texture { uv_set: 1, ..turned(texture(0, TRILINEAR)) };
    // The other sheet's sampler gives the image levels, which this one must not read, whatever its filter between levels is.
    let mut beside = pair(painted(sheet(0.65), texture(0, Sampler { mip_linear: true, ..LEVEL_0 })), sheet(0.65));
    beside.materials.push(Material { base_color_texture: Some(texture(0, TRILINEAR)), ..dielectric() });
    beside.meshes[1].material = 1;
    let cases = [
        ("sheet", painted(sheet(1.3), texture(0, TRILINEAR))),
        ("sheet, transformed", painted(sheet(1.3), wrapped(Wrap::Repeat))),
        ("ball, transformed", painted(ball(), wrapped(Wrap::Repeat))),
        ("sheet, mirrored repeat", painted(sheet(1.3), wrapped(Wrap::MirroredRepeat))),
        ("sheet, clamped", painted(sheet(1.3), wrapped(Wrap::ClampToEdge))),
        ("sheet, UV set 1", painted(sheet(1.3), second_set)),
        ("sheet, nearest level", painted(sheet(1.3), turned(texture(0, level_nearest)))),
        ("sheet, nearest texel", painted(sheet(1.3), turned(texture(0, NEAREST)))),
        ("ball, nearest texel", painted(ball(), turned(texture(0, NEAREST)))),
        ("sheet, level 0", painted(sheet(1.3), turned(texture(0, LEVEL_0)))),
        ("sheet, level 0, nearest texel", painted(sheet(1.3), turned(texture(0, level_0_nearest)))),
        ("sheet, level 0 of several", beside),
    ];
    let case = |(name, scene)| Case { name, scene, shading: Shading::Lambert, ambient: 0.0 };
    rows(renderer, cases.into_iter().map(case).collect())
}

/// Metallic-roughness, occlusion, emissive and normal maps, the last with mirrored coordinates too.
pub fn maps(renderer: &Renderer) -> Result<Vec<Row>> {
    let map = |image: usize| Some(turned(texture(image, TRILINEAR)));
    let metal = Material { metallic_roughness_texture: map(0), ..Material::default() };
    let shaded = Material { occlusion_texture: map(0), ..dielectric() };
    let glowing = Material { emissive: [1.0, 0.5, 0.25], emissive_texture: map(0), ..dielectric() };
    let bent = || Material { normal_texture: map(0), ..dielectric() };
    let (all, four) = every_map();
    let two = pair(scene(sheet(0.65), bent(), vec![leaning()]), mirrored(sheet(0.65)));
    let case = |name, scene, shading, ambient| Case { name, scene, shading, ambient };
    let cases = vec![
        case("metallic-roughness, gltf", scene(sheet(1.3), metal.clone(), vec![rough()]), Shading::Gltf, 0.0),
        case("metallic-roughness, phong", scene(sheet(1.3), metal, vec![rough()]), Shading::Phong, 0.0),
        case("occlusion", scene(sheet(1.3), shaded, vec![dark()]), Shading::Lambert, 2.0),
        case("emissive", scene(sheet(1.3), glowing, vec![image(COLORS, 10)]), Shading::Lambert, 0.0),
        case("normal map", scene(sheet(1.3), bent(), vec![leaning()]), Shading::Gltf, 0.0),
        case("normal map, mirrored coordinates", two, Shading::Gltf, 0.0),
        case("all five maps", scene(sheet(1.3), all, four), Shading::Gltf, 1.0),
    ];
    rows(renderer, cases)
}

/// A material with every map, and the pictures that they are.
fn every_map() -> (Material, Vec<Image>) {
    let map = |image: usize| Some(turned(texture(image, TRILINEAR)));
    let material = Material {
        base_color_texture: map(0),
        metallic_roughness_texture: map(1),
        occlusion_texture: Some(Texture { uv_set: 1, ..texture(2, TRILINEAR) }),
        emissive_texture: Some(texture(0, NEAREST)),
        emissive: [0.5; 3],
        normal_texture: map(3),
        normal_scale: 0.7,
        occlusion_strength: 0.6,
        ..Material::default()
    };
    (material, vec![image(COLORS, 7), rough(), dark(), leaning()])
}

// Red, and for the first map alpha, are far from what is read, so that a channel taken for another shows.
fn rough() -> Image {
    image([[20, 150, 60, 255], [60, 190, 120, 255]], 8)
}

fn dark() -> Image {
    image([[100; 4], [255; 4]], 9)
}

fn leaning() -> Image {
    image([[96, 96, 235, 255], [160, 160, 255, 255]], 11)
}

/// A painted sheet whose texture has holes in its alpha.
fn holed() -> Scene {
    let mut holes = painted(sheet(1.3), texture(0, TRILINEAR));
    for (texel, rgba) in holes.images[0].rgba8.chunks_exact_mut(4).enumerate() {
        let (x, y) = (texel as u32 % SIDE, texel as u32 / SIDE);
        rgba[3] = if (x / 16 + y / 16).is_multiple_of(2) { 255 } else { 0 };
    }
    holes
}

/// A sheet with every map beside one that no light changes, and one with a mask: for techniques to agree on.
pub(super) fn mixed() -> [(&'static str, Scene); 4] {
    let (all, images) = every_map();
    let mut lit = pair(scene(sheet(0.65), Material { double_sided: true, ..all }, images), sheet(0.65));
    let unlit = Some(turned(texture(0, TRILINEAR)));
    lit.materials.push(Material { unlit: true, base_color_texture: unlit, ..dielectric() });
    lit.meshes[1].material = 1;
    let mut masked = holed();
    masked.materials[0].alpha = AlphaMode::Mask(0.5);
    [("maps and unlit", lit), ("mask", masked), ("models", models()), ("parallax", parallax::deep(0.06))]
}

/// A row of balls, each with a shading model of its own.
fn models() -> Scene {
    let mut row = scene(ball(), dielectric(), Vec::new());
    row.materials.clear();
    row.meshes.clear();
    row.instances.clear();
    for (index, model) in Model::ALL.into_iter().enumerate() {
        let own = OwnModel { model, color: [0.1, 0.4, 0.9], exponent: 2.5 };
        row.materials.push(Material {
            base_color: [0.9, 0.3, 0.2, 1.0],
            metallic: 0.3,
            model: Some(own),
            ..dielectric()
        });
        row.meshes.push(Mesh { material: index, ..ball() });
        let place = DVec3::new((index as f64 - 2.0) * 0.55, 0.0, 0.0);
        let object_to_world = DMat4::from_translation(place) * DMat4::from_scale(DVec3::splat(0.26));
        row.instances.push(Instance { mesh: index, object_to_world });
    }
    row
}

/// Materials with shading models of their own: shading against f64 and pictures against rays.
pub fn material_models(renderer: &Renderer) -> Result<Vec<Row>> {
    let request = Request { width: SIZE[0], height: SIZE[1], ..crate::checks::forward() };
    let error = shading_error(renderer, &models(), &request)?;
    let mut found = vec![Row::at_most("shading of materials' own models against f64", error, SHADING_BOUND)];
    let case = Case { name: "materials' own models", scene: models(), shading: Shading::Lambert, ambient: 0.5 };
    found.extend(rows(renderer, vec![case])?);
    Ok(found)
}

/// Alpha masks, blending, vertex colours, unlit and double-sided materials.
pub fn modes(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut holes = holed();
    let mut blended = holes.clone();
    holes.materials[0].alpha = AlphaMode::Mask(0.5);
    blended.materials[0].alpha = AlphaMode::Blend;
    let mut colored = painted(sheet(1.3), texture(0, TRILINEAR));
    let mut random = Random::new(3);
    let mut color = || random.range(0.5, 1.0) as f32;
    colored.meshes[0].colors = colored.meshes[0].positions.iter().map(|_| [color(), color(), color(), 1.0]).collect();
    let mut unlit = colored.clone();
    unlit.materials[0].unlit = true;
    let mut back = painted(sheet(1.3), turned(texture(0, TRILINEAR)));
    back.materials[0].double_sided = true;
    back.instances[0].object_to_world = tilt() * DMat4::from_rotation_y(PI);
    let cases = [
        ("alpha mask", holes),
        ("blended", blended),
        ("vertex colours", colored),
        ("unlit", unlit),
        ("back of a double-sided sheet", back),
    ];
    let case = |(name, scene)| Case { name, scene, shading: Shading::Gltf, ambient: 0.0 };
    rows(renderer, cases.into_iter().map(case).collect())
}
