//! Parallax mapping against rays that take the same steps.

use std::f64::consts::{PI, TAU};

use glam::DMat4;

use super::{
    COLORS, Case, SIDE, TRILINEAR, dielectric, holed, image, leaning, mirrored, pair, rows, scene, sheet, texture,
    tilt, turned,
};
use crate::checks::Row;
use crate::error::Result;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::{AlphaMode, Height, Image, Material, Projection, Scene};

/// Waves of two widths in every channel, one after the other a little further.
fn waves() -> Image {
    let mut rgba8 = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        let (u, v) = (TAU * f64::from(x) / f64::from(SIDE), TAU * f64::from(y) / f64::from(SIDE));
        for channel in 0..4 {
            let wave = 0.5 + 0.3 * (u + f64::from(channel)).sin() * v.cos() + 0.15 * (2.0 * v).sin();
            rgba8.push((wave * 255.0 + 0.5) as u8);
        }
    }
    Image { name: "waves".into(), width: SIDE, height: SIDE, rgba8 }
}

/// A painted and bent sheet that seems to have a depth of `scale` widths of its map, in the alpha of the waves.
pub(super) fn deep(scale: f32) -> Scene {
    let height = Height { texture: turned(texture(2, TRILINEAR)), channel: 3, scale };
    let material = Material {
        base_color_texture: Some(texture(0, TRILINEAR)),
        normal_texture: Some(texture(1, TRILINEAR)),
        height: Some(height),
        ..dielectric()
    };
    scene(sheet(1.3), material, vec![image(COLORS, 7), leaning(), waves()])
}

/// Parallax mapping: on either side, with mirrored coordinates, on the other coordinate set, under a mask.
pub fn parallax(renderer: &Renderer) -> Result<Vec<Row>> {
    let alone = |mut scene: Scene| {
        scene.materials[0].normal_texture = None;
        scene
    };
    let flat = alone(deep(0.0));
    let two = pair(Scene { meshes: vec![sheet(0.65)], ..alone(deep(0.06)) }, mirrored(sheet(0.65)));
    let mut back = alone(deep(0.06));
    back.materials[0].double_sided = true;
    back.instances[0].object_to_world = tilt() * DMat4::from_rotation_y(PI);
    let mut other = alone(deep(0.06));
    other.materials[0].height.iter_mut().for_each(|height| height.texture.uv_set = 1);
    let mut both = other.clone();
    both.materials[0].base_color_texture.iter_mut().for_each(|texture| texture.uv_set = 1);
    let mut masked = alone(deep(0.03));
    masked.images[0] = holed().images[0].clone();
    // Corners of the holes have alpha 0.5 to the last bit, which filters do not share.
    masked.materials[0].alpha = AlphaMode::Mask(0.4);
    let mut flat_lens = alone(deep(0.06));
    let (xmag, ymag) = (1.2, 0.9);
    flat_lens.cameras[0].projection = Projection::Orthographic { xmag, ymag, znear: 0.1, zfar: 10.0 };
    let cases = [
        ("parallax of no depth", flat),
        ("parallax", alone(deep(0.06))),
        ("parallax under a normal map", deep(0.06)),
        ("parallax, mirrored coordinates", two),
        ("parallax, back of a sheet", back),
        ("parallax, colours on the other set", other),
        ("parallax on UV set 1", both),
        ("parallax under a mask", masked),
        ("parallax, orthographic", flat_lens),
    ];
    let case = |(name, scene)| Case { name, scene, shading: Shading::Gltf, ambient: 0.0 };
    rows(renderer, cases.into_iter().map(case).collect())
}
