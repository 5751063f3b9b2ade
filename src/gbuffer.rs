//! The G-buffer as a device stores it, read back and decoded: what lights are given, beside what the surfaces are.

use crate::error::{Error, Result};
use crate::graph::checker::Violation;
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::{Gbuffer, GbufferLayout, Plan};
use crate::reference::octahedral;
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::shared::MIN_ROUGHNESS;

/// Layer of linear base colours.
pub const ALBEDO: &str = "gbuffer_albedo";
/// Layer of view-space normals.
pub const NORMAL: &str = "gbuffer_normal";
/// Layer of roughness, metalness and occlusion.
pub const MATERIAL: &str = "gbuffer_material";
/// Layer of emission, nits; in the fat layout with the ambient light that the surface reflects.
pub const EMISSION: &str = "gbuffer_emission";

/// What the G-buffer holds of one pixel.
#[derive(Debug, Clone, Copy)]
struct Texel {
    albedo: [f32; 3],
    normal: [f32; 3],
    material: [f32; 3],
    emission: [f32; 3],
}

/// Makes the G-buffer of a plan on the device and reads it back: the four layers above, whose fourth number is 1 where a lit surface is
/// stored (all four are 0 elsewhere), and what the checker found in the recorded frames.
///
/// # Errors
/// A technique without a G-buffer, out of memory, a lost device, or a pipeline that the driver refuses.
pub fn make(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<(Picture, Vec<Violation>)> {
    let planned = plan.deferred.as_ref().map(|deferred| deferred.gbuffer);
    let (Some(planned), Some(frame)) = (planned, passes::gbuffer_frame(plan)) else {
        return Err(Error::new(format!("{} makes no G-buffer", plan.technique.name())));
    };
    let mut prepared = renderer.prepare_frame(scene, plan, frame)?;
    // The second frame meets what the first one left.
    prepared.draw(2)?;
    let (stored, violations) = prepared.finish()?;
    let decoded = decode(&planned, &stored).ok_or_else(|| Error::new("the frame left no G-buffer"))?;
    Ok((decoded, violations))
}

/// What a layer shows of a texel.
type Shown = fn(&Texel) -> [f32; 3];

/// `None` where an image of the layout is not there.
fn decode(planned: &Gbuffer, stored: &Picture) -> Option<Picture> {
    let texels = match planned.layout {
        GbufferLayout::Compact => compact(planned, stored)?,
        GbufferLayout::Fat => fat(stored)?,
    };
    let mut picture = Picture::new(stored.width, stored.height);
    let layers: [(&str, Shown); 4] = [
        (ALBEDO, |texel| texel.albedo),
        (NORMAL, |texel| texel.normal),
        (MATERIAL, |texel| texel.material),
        (EMISSION, |texel| texel.emission),
    ];
    for (name, of) in layers {
        let rgba = |texel: &Option<Texel>| {
            texel.as_ref().map_or([0.0; 4], |texel| {
                let [x, y, z] = of(texel);
                [x, y, z, 1.0]
            })
        };
        picture.add_layer(name, texels.iter().flat_map(rgba).collect());
    }
    Some(picture)
}

/// The inverse of `glsl/inc/gbuffer.glsl`.
fn compact(planned: &Gbuffer, stored: &Picture) -> Option<Vec<Option<Texel>>> {
    let (base, material) = (words(stored, "gbuffer_base_color")?, words(stored, "gbuffer_material")?);
    let normals = codes(&words(stored, "gbuffer_normals")?, planned);
    let emission = stored.rgba("gbuffer_emission");
    let of = |((pixel, &base), (&material, &code)): ((usize, &u32), (&u32, &[u32; 2]))| {
        // Alpha.
        if base >> 30 == 0 {
            return None;
        }
        let root = |shift: u32| ((base >> shift) & 1023) as f32 / 1023.0;
        let byte = |place: u32| (material >> (8 * place)) & 255;
        let roughness = (byte(0) * 256 + byte(1)) as f32 / 65535.0;
        Some(Texel {
            albedo: [0, 10, 20].map(|shift| root(shift) * root(shift)),
            normal: octahedral::decode(code, planned.normal_bits).as_vec3().to_array(),
            material: [roughness.max(MIN_ROUGHNESS), byte(2) as f32 / 255.0, byte(3) as f32 / 255.0],
            emission: emission.and_then(|texels| texels.get(pixel)).map_or([0.0; 3], |&texel| xyz(texel)),
        })
    };
    Some(base.iter().enumerate().zip(material.iter().zip(&normals)).map(of).collect())
}

/// Both codes of each normal, as many as the words hold.
pub(crate) fn codes(words: &[u32], planned: &Gbuffer) -> Vec<[u32; 2]> {
    let bits = planned.normal_bits;
    let pair = |word: u32, width: u32| [word, word >> width].map(|code| code & ((1 << width) - 1));
    match bits {
        // Four numbers of 16 bits, of which two are codes.
        _ if planned.material => words.iter().step_by(2).map(|&word| pair(word, 16)).collect(),
        // Two pixels a word.
        8 => words.iter().flat_map(|&word| [pair(word, 8), pair(word >> 16, 8)]).collect(),
        _ => words.iter().map(|&word| pair(word, bits)).collect(),
    }
}

fn fat(stored: &Picture) -> Option<Vec<Option<Texel>>> {
    let position_roughness = stored.rgba("gbuffer_position_roughness")?;
    let normal_occlusion = stored.rgba("gbuffer_normal_occlusion")?;
    let base_metallic = stored.rgba("gbuffer_base_metallic")?;
    let specular_flag = stored.rgba("gbuffer_specular_flag")?;
    let ambient_emission = stored.rgba("gbuffer_ambient_emission")?;
    let of = |pixel: usize| {
        (specular_flag[pixel][3] > 0.5).then(|| Texel {
            albedo: xyz(base_metallic[pixel]),
            normal: xyz(normal_occlusion[pixel]),
            material: [position_roughness[pixel][3], base_metallic[pixel][3], normal_occlusion[pixel][3]],
            emission: xyz(ambient_emission[pixel]),
        })
    };
    // Every layer has a texel a pixel.
    Some((0..specular_flag.len()).map(of).collect())
}

fn xyz([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    [x, y, z]
}

/// Words that came back as the bits of floats.
fn words(stored: &Picture, layer: &str) -> Option<Vec<u32>> {
    Some(stored.layer(layer)?.iter().map(|x| x.to_bits()).collect())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn picture(layers: &[(&str, Vec<u32>)]) -> Picture {
        let mut picture = Picture::new(3, 1);
        for (name, words) in layers {
            picture.add_layer(name, words.iter().map(|&word| f32::from_bits(word)).collect());
        }
        picture
    }

    fn layer(picture: &Picture, name: &str) -> Vec<[f32; 4]> {
        picture.rgba(name).expect("a layer of four").to_vec()
    }

    /// Nothing, then two surfaces; the words of their normals.
    fn stored(normals: Vec<u32>) -> Picture {
        let material = 0xFF_80_FF_FF;
        picture(&[
            ("gbuffer_base_color", vec![1023, 3 << 30 | 1023, 3 << 30 | 1023 << 20]),
            ("gbuffer_normals", normals),
            ("gbuffer_material", vec![material, material, 0x01_00_00_00]),
        ])
    }

    #[test]
    fn compact_texels_are_decoded_where_a_surface_is() {
        let planned = Gbuffer { layout: GbufferLayout::Compact, normal_bits: 16, emission: false, material: false };
        let decoded = decode(&planned, &stored(vec![0; 3])).expect("every image is there");
        assert_eq!(layer(&decoded, ALBEDO), [[0.0; 4], [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
        let [_, first, second] = layer(&decoded, MATERIAL)[..] else { panic!("three pixels") };
        assert_eq!(first, [1.0, 128.0 / 255.0, 1.0, 1.0]);
        assert_eq!(second, [MIN_ROUGHNESS, 0.0, 1.0 / 255.0, 1.0]);
        assert_eq!(layer(&decoded, EMISSION)[1], [0.0, 0.0, 0.0, 1.0], "nothing emits");
        assert!(decode(&planned, &picture(&[])).is_none());
    }

    #[test]
    fn normals_come_back_from_codes_of_every_width() {
        let axes = [DVec3::Z, DVec3::X, DVec3::NEG_Y];
        for bits in [8, 10, 16] {
            let codes = axes.map(|axis| octahedral::encode(axis, bits)).map(|[x, y]| x | y << bits);
            let words = if bits == 8 { vec![codes[0] | codes[1] << 16, codes[2]] } else { codes.to_vec() };
            let planned =
                Gbuffer { layout: GbufferLayout::Compact, normal_bits: bits, emission: false, material: false };
            let decoded = decode(&planned, &stored(words)).expect("every image is there");
            let normals = layer(&decoded, NORMAL);
            assert_eq!(normals, [[0.0; 4], [1.0, 0.0, 0.0, 1.0], [0.0, -1.0, 0.0, 1.0]], "{bits} bits");
        }
    }

    #[test]
    fn fat_texels_are_numbers_already() {
        let floats = |texel: [f32; 4]| [[0.0; 4], texel, [0.0; 4]].concat().iter().map(|x| x.to_bits()).collect();
        let stored = picture(&[
            ("gbuffer_position_roughness", floats([1.0, 2.0, 3.0, 0.25])),
            ("gbuffer_normal_occlusion", floats([0.0, 0.0, 1.0, 0.5])),
            ("gbuffer_base_metallic", floats([0.1, 0.2, 0.3, 0.75])),
            ("gbuffer_specular_flag", floats([0.04, 0.04, 0.04, 1.0])),
            ("gbuffer_ambient_emission", floats([7.0, 8.0, 9.0, 0.0])),
        ]);
        let planned = Gbuffer { layout: GbufferLayout::Fat, normal_bits: 16, emission: false, material: false };
        let decoded = decode(&planned, &stored).expect("every image is there");
        let second = |name| layer(&decoded, name)[1];
        assert_eq!([second(ALBEDO), second(NORMAL)], [[0.1, 0.2, 0.3, 1.0], [0.0, 0.0, 1.0, 1.0]]);
        assert_eq!([second(MATERIAL), second(EMISSION)], [[0.25, 0.75, 0.5, 1.0], [7.0, 8.0, 9.0, 1.0]]);
        assert_eq!(layer(&decoded, ALBEDO)[0], [0.0; 4]);
    }
}
