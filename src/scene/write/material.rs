//! Materials, textures, samplers and images of a glTF file.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Map, Value, json};

use super::{File, named, power_of_two_over, wide};
use crate::error::{Error, Result};
use crate::scene::shading::OwnModel;
use crate::scene::{AlphaMode, Height, IDENTITY_UV, Image, Material, Sampler, Texture, Wrap};

/// Relative to the size of the matrix: the rounding of a few f32 operations.
const SKEW_TOLERANCE: f64 = 1e-5;

/// Adds the image as a PNG in the buffer.
pub fn add_image(file: &mut File, image: &Image) -> Result<()> {
    if image.rgba8.len() as u64 != u64::from(image.width) * u64::from(image.height) * 4 {
        let (width, height, bytes) = (image.width, image.height, image.rgba8.len());
        return Err(Error::new(format!("{width}x{height} texels do not take {bytes} bytes")));
    }
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&image.rgba8, image.width, image.height, ExtendedColorType::Rgba8)
        .map_err(|error| Error::new(format!("cannot be encoded as PNG: {error}")))?;
    let view = file.add_view(|bytes| bytes.extend(png), None);
    file.images.push(named(&image.name, json!({ "mimeType": "image/png", "bufferView": view })));
    Ok(())
}

/// Adds a material and the textures it needs.
pub fn add(file: &mut File, material: &Material) -> Result<()> {
    let mut surface = Map::new();
    surface.insert("baseColorFactor".into(), json!(wide(material.base_color)));
    surface.insert("metallicFactor".into(), json!(f64::from(material.metallic)));
    surface.insert("roughnessFactor".into(), json!(f64::from(material.roughness)));
    if let Some(texture) = &material.base_color_texture {
        surface.insert("baseColorTexture".into(), texture_info(file, texture)?);
    }
    if let Some(texture) = &material.metallic_roughness_texture {
        surface.insert("metallicRoughnessTexture".into(), texture_info(file, texture)?);
    }
    let mut object = json!({ "pbrMetallicRoughness": surface });
    if let Some(texture) = &material.normal_texture {
        object["normalTexture"] = texture_info(file, texture)?;
        object["normalTexture"]["scale"] = json!(f64::from(material.normal_scale));
    }
    if let Some(texture) = &material.occlusion_texture {
        object["occlusionTexture"] = texture_info(file, texture)?;
        object["occlusionTexture"]["strength"] = json!(f64::from(material.occlusion_strength));
    }
    if let Some(texture) = &material.emissive_texture {
        object["emissiveTexture"] = texture_info(file, texture)?;
    }
    match material.alpha {
        AlphaMode::Opaque => {}
        AlphaMode::Mask(cutoff) => {
            object["alphaMode"] = json!("MASK");
            object["alphaCutoff"] = json!(f64::from(cutoff));
        }
        AlphaMode::Blend => object["alphaMode"] = json!("BLEND"),
    }
    if material.double_sided {
        object["doubleSided"] = json!(true);
    }
    add_emission(file, material, &mut object);
    if material.unlit {
        file.use_extension("KHR_materials_unlit");
        object["extensions"]["KHR_materials_unlit"] = json!({});
    }
    add_extras(file, material, &mut object)?;
    file.materials.push(named(&material.name, object));
    Ok(())
}

/// `extras.lampyris`: what glTF has no word for.
fn add_extras(file: &mut File, material: &Material, object: &mut Value) -> Result<()> {
    if let Some(OwnModel { model, color, exponent }) = material.model {
        object["extras"]["lampyris"]["model"] = json!(model.name());
        if OwnModel::of(model) != (OwnModel { model, color, exponent }) {
            object["extras"]["lampyris"]["color"] = json!(wide(color));
            object["extras"]["lampyris"]["exponent"] = json!(f64::from(exponent));
        }
    }
    if let Some(Height { texture, channel, scale }) = &material.height {
        let mut info = texture_info(file, texture)?;
        info["channel"] = json!(channel);
        info["scale"] = json!(f64::from(*scale));
        object["extras"]["lampyris"]["heightTexture"] = info;
    }
    Ok(())
}

/// A factor of at most 1, and the rest as `KHR_materials_emissive_strength`.
fn add_emission(file: &mut File, material: &Material, object: &mut Value) {
    let strength = power_of_two_over(material.emissive.into_iter().fold(0.0, f32::max));
    if material.emissive != [0.0; 3] {
        object["emissiveFactor"] = json!(wide(material.emissive).map(|component| component / strength));
    }
    if strength > 1.0 {
        file.use_extension("KHR_materials_emissive_strength");
        object["extensions"]["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": strength });
    }
}

/// The reference from a material to a texture.
fn texture_info(file: &mut File, texture: &Texture) -> Result<Value> {
    let sampler = position_or_push(&mut file.samplers, texture.sampler);
    let index = position_or_push(&mut file.textures, [sampler, texture.image]);
    let mut info = json!({ "index": index });
    if texture.uv_set != 0 {
        info["texCoord"] = json!(texture.uv_set);
    }
    if texture.uv_transform != IDENTITY_UV {
        file.use_extension("KHR_texture_transform");
        info["extensions"] = json!({ "KHR_texture_transform": transform(&texture.uv_transform)? });
    }
    Ok(info)
}

fn position_or_push<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    list.iter().position(|known| *known == item).unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}

/// Offset, rotation and scale with `u' = cos sx u + sin sy v + ox`, `v' = -sin sx u + cos sy v + oy`: counter-clockwise where v
/// points down, as programs read `KHR_texture_transform` (its GLSL listing turns the other way, KhronosGroup/glTF issue 1563).
fn transform(rows: &[[f32; 3]; 2]) -> Result<Value> {
    let [[a, b, offset_u], [c, d, offset_v]] = rows.map(wide);
    let size = [a, b, c, d].into_iter().fold(0.0f64, |size, x| size.max(x.abs()));
    // Without rotation the scale is taken as it is, sign and all, so that nothing is rounded.
    let (sin, cos) = if b == 0.0 && c == 0.0 {
        (0.0, 1.0)
    } else if a.hypot(c) >= b.hypot(d) {
        (-c / a.hypot(c), a / a.hypot(c))
    } else {
        (b / b.hypot(d), d / b.hypot(d))
    };
    let (scale_u, scale_v) = (cos * a - sin * c, sin * b + cos * d);
    let rebuilt = [cos * scale_u, sin * scale_v, -sin * scale_u, cos * scale_v];
    if rebuilt.into_iter().zip([a, b, c, d]).any(|(x, y)| (x - y).abs() > SKEW_TOLERANCE * size) {
        return Err(Error::new(format!(
            "the texture transform [{a}, {b}; {c}, {d}] is skewed, glTF has rotation and scale only"
        )));
    }
    Ok(json!({ "offset": [offset_u, offset_v], "rotation": sin.atan2(cos), "scale": [scale_u, scale_v] }))
}

/// A sampler in glTF's (OpenGL's) numbers.
pub fn sampler(sampler: &Sampler) -> Value {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    };
    let min_filter = match (sampler.mipmapped, sampler.min_linear, sampler.mip_linear) {
        (false, false, _) => 9728,
        (false, true, _) => 9729,
        (true, false, false) => 9984,
        (true, true, false) => 9985,
        (true, false, true) => 9986,
        (true, true, true) => 9987,
    };
    json!({
        "magFilter": if sampler.mag_linear { 9729 } else { 9728 },
        "minFilter": min_filter,
        "wrapS": wrap(sampler.wrap_u),
        "wrapT": wrap(sampler.wrap_v),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows that a reader makes of what was written.
    fn rows(value: &Value) -> [[f64; 3]; 2] {
        let number = |key: &str, index: usize| value[key][index].as_f64().unwrap();
        let (sin, cos) = value["rotation"].as_f64().unwrap().sin_cos();
        let (u, v) = (number("scale", 0), number("scale", 1));
        [[cos * u, sin * v, number("offset", 0)], [-sin * u, cos * v, number("offset", 1)]]
    }

    #[test]
    fn a_texture_transform_comes_back() {
        for (angle, u, v) in [(0.3f64, 2.0, 0.5), (-2.5, 1.0, -3.0), (1.6, 0.0, 4.0), (0.0, -2.0, 7.0), (3.0, 5.0, 0.0)]
        {
            let (sin, cos) = angle.sin_cos();
            let given = [[cos * u, sin * v, 0.25], [-sin * u, cos * v, -8.0]].map(|row| row.map(|x| x as f32));
            let read = rows(&transform(&given).unwrap());
            for (row, expected) in read.iter().zip(given) {
                for (x, y) in row.iter().zip(expected) {
                    assert!((x - f64::from(y)).abs() < 1e-6, "{given:?} came back as {read:?}");
                }
            }
        }
    }

    #[test]
    fn a_skewed_texture_transform_is_refused() {
        let error = transform(&[[1.0, 0.5, 0.0], [0.0, 1.0, 0.0]]).unwrap_err();
        assert!(error.to_string().contains("skewed"), "{error}");
    }
}
