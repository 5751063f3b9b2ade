//! Materials and textures (glTF 2.0, sections 3.8 and 3.9; KHR_texture_transform, KHR_materials_emissive_strength,
//! KHR_materials_unlit).

use ::gltf::json::texture as codes;

use super::Loader;
use super::json::{Value, shorten};
use super::notes::Note;
use crate::error::Result;
use crate::scene::shading::{Model, OwnModel};
use crate::scene::{AlphaMode, Height, IDENTITY_UV, Material, Sampler, Texture, Wrap};

/// What a primitive asks for: its material's number, and whether the normal map can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct MaterialKey {
    /// `None`: glTF's default material.
    pub(super) index: Option<usize>,
    /// False for a primitive without texture coordinates.
    pub(super) normal_map: bool,
}

impl<'a> Loader<'a> {
    /// Index into [`crate::scene::Scene::materials`], built on first use.
    pub(super) fn material(&mut self, key: MaterialKey) -> Result<usize> {
        if let Some(known) = self.materials.get(&key) {
            return Ok(*known);
        }
        self.budget.charge(4 * size_of::<(MaterialKey, Material)>() as u64, 0, &"materials")?;
        let material = match key.index {
            _ if !key.normal_map => {
                let whole = self.material(MaterialKey { normal_map: true, ..key })?;
                Material { normal_texture: None, height: None, ..self.scene.materials[whole].clone() }
            }
            Some(index) => self.read_material(index)?,
            None => Material { name: "default".into(), ..Material::default() },
        };
        self.scene.materials.push(material);
        self.materials.insert(key, self.scene.materials.len() - 1);
        Ok(self.scene.materials.len() - 1)
    }

    fn read_material(&mut self, index: usize) -> Result<Material> {
        let Some(value) = self.document.materials.at(index) else {
            return Ok(Material::default());
        };
        let mut material = Material { name: value.name_or(|| format!("materials[{index}]"))?, ..Material::default() };
        if let Some(pbr) = value.get("pbrMetallicRoughness")? {
            self.read_metallic_roughness(pbr, &mut material)?;
        }
        if let Some(normal) = value.get("normalTexture")? {
            material.normal_texture = self.texture(normal)?;
            material.normal_scale = normal.get("scale")?.map_or(Ok(1.0), Value::float)?;
        }
        if let Some(occlusion) = value.get("occlusionTexture")? {
            material.occlusion_texture = self.texture(occlusion)?;
            material.occlusion_strength = fraction(occlusion, "strength")?;
        }
        if let Some(emissive) = value.get("emissiveTexture")? {
            material.emissive_texture = self.texture(emissive)?;
        }
        material.emissive = emissive(value)?;
        material.alpha = self.alpha_mode(value)?;
        material.double_sided = value.get("doubleSided")?.map_or(Ok(false), Value::boolean)?;
        material.unlit = value.extension("KHR_materials_unlit")?.is_some();
        self.read_extras(value, &mut material)?;
        Ok(material)
    }

    /// `extras.lampyris`: `model` with `color` and `exponent`, and `heightTexture`, a textureInfo with `channel` and `scale`. `extras` of other
    /// programs may be anything.
    fn read_extras(&mut self, material: Value<'a>, read: &mut Material) -> Result<()> {
        let Some(own) = material.own_extras()? else { return Ok(()) };
        let known = ["model", "color", "exponent", "heightTexture"];
        self.notes.add_many(Note::UnknownExtras, own.unknown_members(&known));
        if let Some(name) = own.get("model")? {
            let text = name.text()?;
            let model = Model::ALL.into_iter().find(|model| model.name() == text);
            let model = model.ok_or_else(|| {
                let known = Model::ALL.map(Model::name).join(", ");
                name.error(format_args!("is \"{}\", which is none of {known}", shorten(text)))
            })?;
            read.model = Some(OwnModel {
                model,
                color: own.get("color")?.map_or(Ok(OwnModel::WHITE), non_negative)?,
                exponent: own.get("exponent")?.map_or(Ok(OwnModel::EXPONENT), positive)?,
            });
        } else if let Some(unused) = own.get("color")?.or(own.get("exponent")?) {
            return Err(unused.error("is given without a model"));
        }
        if let Some(height) = own.get("heightTexture")? {
            let channel = height.get("channel")?.map_or(Ok(0), Value::index)?;
            if channel > 3 {
                return Err(height.require("channel")?.error(format_args!("{channel} is not 0, 1, 2 or 3")));
            }
            let scale = height.get("scale")?.map_or(Ok(Height::SCALE), |scale| {
                let value = at_least_zero(scale)?;
                if value <= 1.0 { Ok(value) } else { Err(scale.error(format_args!("{value} is not in 0 to 1"))) }
            })?;
            read.height = self.texture(height)?.map(|texture| Height { texture, channel, scale });
        }
        Ok(())
    }

    fn read_metallic_roughness(&mut self, pbr: Value<'a>, material: &mut Material) -> Result<()> {
        if let Some(factor) = pbr.get("baseColorFactor")? {
            material.base_color = non_negative(factor)?;
        }
        if let Some(texture) = pbr.get("baseColorTexture")? {
            material.base_color_texture = self.texture(texture)?;
        }
        if let Some(texture) = pbr.get("metallicRoughnessTexture")? {
            material.metallic_roughness_texture = self.texture(texture)?;
        }
        material.metallic = fraction(pbr, "metallicFactor")?;
        material.roughness = fraction(pbr, "roughnessFactor")?;
        Ok(())
    }

    fn alpha_mode(&mut self, material: Value<'a>) -> Result<AlphaMode> {
        let cutoff = match material.get("alphaCutoff")? {
            Some(cutoff) => at_least_zero(cutoff)?,
            None => 0.5,
        };
        let Some(mode) = material.get("alphaMode")? else {
            return Ok(AlphaMode::Opaque);
        };
        match mode.text()? {
            "OPAQUE" => Ok(AlphaMode::Opaque),
            "MASK" => Ok(AlphaMode::Mask(cutoff)),
            "BLEND" => Ok(AlphaMode::Blend),
            _ => Err(mode.error("is not OPAQUE, MASK or BLEND")),
        }
    }

    /// The texture of a textureInfo; `None` where its image cannot be used.
    fn texture(&mut self, info: Value<'a>) -> Result<Option<Texture>> {
        let (index, texture) = self.document.textures.referred(info.require("index")?)?;
        let (image, sampler) = match self.textures.get(&index) {
            Some(known) => *known,
            None => {
                let image = match texture.get("source")? {
                    Some(source) => {
                        let image = self.picture(source)?;
                        self.notes.add_many(Note::OtherImageFormat, image.is_none().into());
                        image
                    }
                    None => {
                        // Formats of extensions are named there, beside a missing plain source.
                        let other = texture.get("extensions")?.is_some();
                        self.notes.add(if other { Note::OtherImageFormat } else { Note::TextureWithoutImage });
                        None
                    }
                };
                let sampler = match texture.get("sampler")? {
                    Some(sampler) => read_sampler(self.document.samplers.referred(sampler)?.1)?,
                    None => Sampler::default(),
                };
                self.budget.charge(4 * size_of::<(usize, Texture)>() as u64, 0, &"textures")?;
                self.textures.insert(index, (image, sampler));
                (image, sampler)
            }
        };
        let transform = info.extension("KHR_texture_transform")?;
        let mut uv_set = info.get("texCoord")?;
        let mut uv_transform = IDENTITY_UV;
        if let Some(transform) = transform {
            uv_set = transform.get("texCoord")?.or(uv_set);
            uv_transform = read_transform(transform)?;
        }
        let mut uv_set = uv_set.map_or(Ok(0), Value::index)?;
        if uv_set > 1 {
            self.notes.add(Note::OtherUvSet);
            uv_set = 0;
        }
        Ok(image.map(|image| Texture { image, sampler, uv_set, uv_transform }))
    }
}

/// `emissiveFactor * emissiveStrength`, in nits.
fn emissive(material: Value<'_>) -> Result<[f32; 3]> {
    let Some(factor) = material.get("emissiveFactor")? else {
        return Ok([0.0; 3]);
    };
    let mut emissive = non_negative::<3>(factor)?;
    let extension = material.extension("KHR_materials_emissive_strength")?;
    if let Some(extension) = extension
        && let Some(strength) = extension.get("emissiveStrength")?
    {
        let scale = at_least_zero(strength)?;
        emissive = emissive.map(|e| e * scale);
        if emissive.iter().any(|e| !e.is_finite()) {
            return Err(strength.error("times emissiveFactor is not a finite number"));
        }
    }
    Ok(emissive)
}

pub(super) fn at_least_zero(value: Value<'_>) -> Result<f32> {
    let number = value.float()?;
    if number < 0.0 { Err(value.error(format_args!("{number} is negative"))) } else { Ok(number) }
}

pub(super) fn non_negative<const N: usize>(value: Value<'_>) -> Result<[f32; N]> {
    let numbers = value.floats::<N>()?;
    match numbers.iter().position(|n| *n < 0.0) {
        Some(at) => Err(value.error(format_args!("number {at} is {}, which is negative", numbers[at]))),
        None => Ok(numbers),
    }
}

fn positive(value: Value<'_>) -> Result<f32> {
    let number = value.float()?;
    if number > 0.0 && number <= 1024.0 {
        Ok(number)
    } else {
        Err(value.error(format_args!("{number} is not a number above 0, at most 1024")))
    }
}

/// A factor from 0 to 1, 1 where it is absent; exporters overshoot 1 by rounding.
fn fraction(holder: Value<'_>, key: &str) -> Result<f32> {
    holder.get(key)?.map_or(Ok(1.0), |value| Ok(at_least_zero(value)?.min(1.0)))
}

fn read_sampler(sampler: Value<'_>) -> Result<Sampler> {
    let wrap = |key: &str| -> Result<Wrap> {
        let Some(value) = sampler.get(key)? else {
            return Ok(Wrap::Repeat);
        };
        match value.code()? {
            codes::REPEAT => Ok(Wrap::Repeat),
            codes::CLAMP_TO_EDGE => Ok(Wrap::ClampToEdge),
            codes::MIRRORED_REPEAT => Ok(Wrap::MirroredRepeat),
            other => Err(value.error(format_args!("{other} is not a wrapping mode"))),
        }
    };
    let filter = |key: &str, valid: &[u32], default: u32| -> Result<u32> {
        let Some(value) = sampler.get(key)? else {
            return Ok(default);
        };
        let filter = value.code()?;
        if valid.contains(&filter) { Ok(filter) } else { Err(value.error(format_args!("{filter} is not a filter"))) }
    };
    let min = filter("minFilter", codes::VALID_MIN_FILTERS, codes::LINEAR_MIPMAP_LINEAR)?;
    let mag = filter("magFilter", codes::VALID_MAG_FILTERS, codes::LINEAR)?;
    Ok(Sampler {
        wrap_u: wrap("wrapS")?,
        wrap_v: wrap("wrapT")?,
        mag_linear: mag == codes::LINEAR,
        min_linear: matches!(min, codes::LINEAR | codes::LINEAR_MIPMAP_NEAREST | codes::LINEAR_MIPMAP_LINEAR),
        mipmapped: !matches!(min, codes::NEAREST | codes::LINEAR),
        mip_linear: matches!(min, codes::NEAREST_MIPMAP_LINEAR | codes::LINEAR_MIPMAP_LINEAR),
    })
}

/// Offset after rotation after scale. A positive angle turns coordinates counter-clockwise as seen with v upwards,
/// though v points down: the extension's own example (offset (0, 1), a quarter turn, scale 0.5 shows the lower left
/// quadrant) and Khronos' sample viewer agree on that sign.
fn read_transform(transform: Value<'_>) -> Result<[[f32; 3]; 2]> {
    let offset = transform.get("offset")?.map_or(Ok([0.0; 2]), Value::floats::<2>)?;
    let scale = transform.get("scale")?.map_or(Ok([1.0; 2]), Value::floats::<2>)?;
    let angle = transform.get("rotation")?.map_or(Ok(0.0), Value::number)?;
    let (sin, cos) = angle.sin_cos();
    let (su, sv) = (f64::from(scale[0]), f64::from(scale[1]));
    Ok([[(cos * su) as f32, (sin * sv) as f32, offset[0]], [(-sin * su) as f32, (cos * sv) as f32, offset[1]]])
}
