//! Materials in device form and the textures they need, each (image, encoding) once.

use super::Limits;
use crate::error::{Error, Result};
use crate::scene::shading::{Model, OwnModel, Shading};
use crate::scene::{AlphaMode, IDENTITY_UV, Material, Sampler, Scene, Texture};
use crate::shared::{self, MaterialData};

/// A texture on the device: an image in one encoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TextureKey {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Decoded from sRGB by the sampler.
    pub srgb: bool,
}

/// One map of a material: which texture, how sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Map {
    /// Index into [`Materials::textures`].
    pub texture: usize,
    /// Filtering and wrapping.
    pub sampler: Sampler,
}

/// What a pipeline is specialised for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variant {
    /// Alpha is tested.
    pub masked: bool,
    /// It is mixed with what lies behind it, by alpha.
    pub blended: bool,
    /// The base colour is the picture.
    pub unlit: bool,
    /// Bits `TEXTURE_*`.
    pub textures: u32,
    /// Bit t set: texture t reads UV set 1.
    pub uv_sets: u32,
    /// Some map has a transform.
    pub uv_transforms: bool,
    /// The mesh has vertex colours; decided with the mesh.
    pub vertex_colors: bool,
    /// Value of SHADING.
    pub model: u32,
}

/// All materials of a scene.
#[derive(Debug, Clone, Default)]
pub struct Materials {
    /// By material.
    pub data: Vec<MaterialData>,
    /// Maps by material, in the order of the `TEXTURE_*` bits.
    pub maps: Vec<[Option<Map>; MAPS]>,
    /// By material.
    pub variants: Vec<Variant>,
    /// By material.
    pub double_sided: Vec<bool>,
    /// Distinct textures with their size and whether any sampler wants their mip levels.
    pub textures: Vec<(TextureKey, [u32; 2], bool)>,
}

/// Maps that a material may have.
pub const MAPS: usize = 6;

/// Maps that hold colours are decoded from sRGB.
const SRGB: [bool; MAPS] = [true, false, false, false, true, false];

/// Value of SHADING for one model.
pub fn shading_constant(model: Model) -> u32 {
    match model {
        Model::Lambert => shared::SHADING_LAMBERT,
        Model::Phong => shared::SHADING_PHONG,
        Model::Gltf => shared::SHADING_GLTF,
        Model::CarPaint => shared::SHADING_CAR_PAINT,
        Model::Rim => shared::SHADING_RIM,
    }
}

fn maps_of(material: &Material) -> [Option<&Texture>; MAPS] {
    [
        material.base_color_texture.as_ref(),
        material.metallic_roughness_texture.as_ref(),
        material.normal_texture.as_ref(),
        material.occlusion_texture.as_ref(),
        material.emissive_texture.as_ref(),
        material.height.as_ref().map(|height| &height.texture),
    ]
}

/// Levels of a full mip chain.
pub fn level_count(size: [u32; 2]) -> u32 {
    32 - size[0].max(size[1]).max(1).leading_zeros()
}

impl Materials {
    /// Collects materials and textures; those that name no model have `shading`.
    ///
    /// # Errors
    /// An image larger than the device's largest, named.
    pub fn new(scene: &Scene, shading: Shading, limits: &Limits) -> Result<Self> {
        let mut materials = Self::default();
        for material in &scene.materials {
            materials.add(scene, material, shading, limits)?;
        }
        Ok(materials)
    }

    fn add(&mut self, scene: &Scene, material: &Material, shading: Shading, limits: &Limits) -> Result<()> {
        let wanted = maps_of(material);
        let mut maps = [None; MAPS];
        let (mut bits, mut uv_sets) = (0, 0);
        let mut rows = [IDENTITY_UV; MAPS];
        let own = material.model.unwrap_or(OwnModel::of(shading.into()));
        for (index, texture) in wanted.iter().enumerate() {
            let Some(texture) = texture else { continue };
            let key = TextureKey { image: texture.image, srgb: SRGB[index] };
            maps[index] =
                Some(Map { texture: self.texture(scene, key, texture.sampler, limits)?, sampler: texture.sampler });
            bits |= 1 << index;
            uv_sets |= u32::from(texture.uv_set == 1) << index;
            rows[index] = texture.uv_transform;
        }
        let masked = matches!(material.alpha, AlphaMode::Mask(_));
        self.data.push(MaterialData {
            base_color: material.base_color,
            emissive: material.emissive,
            metallic: material.metallic,
            roughness: material.roughness,
            normal_scale: material.normal_scale,
            occlusion_strength: material.occlusion_strength,
            alpha_cutoff: if let AlphaMode::Mask(cutoff) = material.alpha { cutoff } else { -1.0 },
            uv_base_color_u: rows[0][0],
            uv_base_color_v: rows[0][1],
            uv_metallic_roughness_u: rows[1][0],
            uv_metallic_roughness_v: rows[1][1],
            uv_normal_u: rows[2][0],
            uv_normal_v: rows[2][1],
            uv_occlusion_u: rows[3][0],
            uv_occlusion_v: rows[3][1],
            uv_emissive_u: rows[4][0],
            uv_emissive_v: rows[4][1],
            uv_height_u: rows[5][0],
            uv_height_v: rows[5][1],
            height_scale: material.height.as_ref().map_or(0.0, |height| height.scale),
            height_channel: material.height.as_ref().map_or(0, |height| height.channel as u32),
            model: shading_constant(own.model),
            model_color: own.color,
            model_exponent: own.exponent,
        });
        self.maps.push(maps);
        self.variants.push(Variant {
            masked,
            blended: material.alpha == AlphaMode::Blend,
            unlit: material.unlit,
            textures: bits,
            uv_sets,
            uv_transforms: rows.iter().any(|r| *r != IDENTITY_UV),
            vertex_colors: false,
            model: shading_constant(own.model),
        });
        self.double_sided.push(material.double_sided);
        Ok(())
    }

    fn texture(&mut self, scene: &Scene, key: TextureKey, sampler: Sampler, limits: &Limits) -> Result<usize> {
        let image = &scene.images[key.image];
        let (size, most) = ([image.width, image.height], limits.max_image_dimension);
        if size[0].max(size[1]) > most {
            return Err(Error::new(format!(
                "{}: image {} ({}) is {}x{}, this device's largest is {most}x{most}",
                scene.name, key.image, image.name, size[0], size[1]
            )));
        }
        let index = self.textures.iter().position(|t| t.0 == key).unwrap_or_else(|| {
            self.textures.push((key, size, false));
            self.textures.len() - 1
        });
        self.textures[index].2 |= sampler.mipmapped;
        Ok(index)
    }

    /// Bytes of constants and texels, mip levels included.
    pub fn bytes(&self) -> u64 {
        let texels = |&(_, [w, h], mipmapped): &(TextureKey, [u32; 2], bool)| {
            let levels = if mipmapped { level_count([w, h]) } else { 1 };
            (0..levels).map(|l| u64::from((w >> l).max(1)) * u64::from((h >> l).max(1))).sum::<u64>()
        };
        let constants = (self.data.len() * size_of::<MaterialData>()) as u64;
        constants + self.textures.iter().map(texels).sum::<u64>() * 4
    }
}

/// Bit of the normal map.
pub const NORMAL_MAP: u32 = shared::TEXTURE_NORMAL;
/// Bit of the height map.
pub const HEIGHT_MAP: u32 = shared::TEXTURE_HEIGHT;
