//! Texture sampling in f64, by the rule that the shaders follow too.
//!
//! `level = log2(longest)`, where `longest` is the longer of the two fine screen-space derivatives of the texture
//! coordinates, in texels of level 0. At a level of 0 or less the magnification filter reads level 0; above it the
//! minification filter reads level `ceil(level + 0.5) - 1` or blends the two levels around it (Vulkan 1.3, section
//! 16.5.8, "Image Level(s) Selection"). Texels have their centres at half coordinates; sRGB texels are decoded before
//! they are blended.

use glam::{DVec2, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::scene::mips::{self, Level, MipChain};
use crate::scene::{Material, Sampler, Scene, Texture, Wrap};

/// What the bytes of an image mean. Alpha is linear in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Byte over 255.
    Linear,
    /// Red, green and blue are sRGB-encoded.
    Srgb,
}

/// Texture coordinates and their differences to the next pixel, before `KHR_texture_transform`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// At the pixel's centre.
    pub uv: DVec2,
    /// Fine difference along a row of the picture.
    pub dx: DVec2,
    /// Fine difference down a column of the picture.
    pub dy: DVec2,
}

/// The mip chains of every image that a material uses.
pub struct Textures {
    /// For each image, the chains for `Encoding::Linear` and `Encoding::Srgb`, where used.
    chains: Vec<[Option<MipChain>; 2]>,
    /// `srgb_to_linear` of each byte.
    decoded: [f64; 256],
}

impl Textures {
    /// Builds the chains.
    ///
    /// # Errors
    /// A texture without an image, or an image whose bytes do not fit its size.
    pub fn new(scene: &Scene) -> Result<Self> {
        let mut chains: Vec<[Option<MipChain>; 2]> = scene.images.iter().map(|_| [None, None]).collect();
        for (texture, encoding) in scene.materials.iter().flat_map(used) {
            let (Some(image), Some(pair)) = (scene.images.get(texture.image), chains.get_mut(texture.image)) else {
                let what = format!("texture image {} of {} does not exist", texture.image, scene.images.len());
                return Err(Error::new(what));
            };
            let bytes = image.width as usize * image.height as usize * 4;
            if bytes == 0 || image.rgba8.len() != bytes {
                let (name, given) = (&image.name, image.rgba8.len());
                let size = format!("{}x{}", image.width, image.height);
                return Err(Error::new(format!("image \"{name}\": {given} bytes for {size} texels")));
            }
            let chain = &mut pair[encoding as usize];
            if chain.is_none() {
                *chain = Some(mips::chain(image, encoding == Encoding::Srgb));
            }
        }
        Ok(Self { chains, decoded: std::array::from_fn(|byte| mips::srgb_to_linear(byte as u8)) })
    }

    /// Linear RGBA. White for a texture that no material of the scene has.
    pub fn sample(&self, texture: &Texture, encoding: Encoding, footprint: &Footprint) -> DVec4 {
        let Some(chain) = self.chains.get(texture.image).and_then(|pair| pair[encoding as usize].as_ref()) else {
            return DVec4::ONE;
        };
        let rows = texture.uv_transform.map(|row| DVec3::from_array(row.map(f64::from)));
        let transform = |v: DVec3| DVec2::new(rows[0].dot(v), rows[1].dot(v));
        let uv = transform(footprint.uv.extend(1.0));
        let size = DVec2::new(f64::from(chain.levels[0].width), f64::from(chain.levels[0].height));
        let level = level(transform(footprint.dx.extend(0.0)) * size, transform(footprint.dy.extend(0.0)) * size);
        let sampler = &texture.sampler;
        let linear = if level <= 0.0 { sampler.mag_linear } else { sampler.min_linear };
        let fetch = |index: usize| self.filter(&chain.levels[index], sampler, encoding, uv, linear);
        if level <= 0.0 || !sampler.mipmapped {
            return fetch(0);
        }
        let last = chain.levels.len() - 1;
        let level = level.min(last as f64);
        if sampler.mip_linear {
            let lower = level.floor();
            let index = lower as usize;
            fetch(index).lerp(fetch((index + 1).min(last)), level - lower)
        } else {
            fetch(((level + 0.5).ceil() - 1.0) as usize)
        }
    }

    fn filter(&self, level: &Level, sampler: &Sampler, encoding: Encoding, uv: DVec2, linear: bool) -> DVec4 {
        let at = uv * DVec2::new(f64::from(level.width), f64::from(level.height));
        let texel = |x: i64, y: i64| {
            let (x, y) = (wrap(x, level.width, sampler.wrap_u), wrap(y, level.height, sampler.wrap_v));
            let bytes = &level.rgba8[(y * level.width as usize + x) * 4..][..4];
            let decode = |byte: u8| match encoding {
                Encoding::Linear => f64::from(byte) / 255.0,
                Encoding::Srgb => self.decoded[byte as usize],
            };
            DVec4::new(decode(bytes[0]), decode(bytes[1]), decode(bytes[2]), f64::from(bytes[3]) / 255.0)
        };
        if !linear {
            return texel(at.x.floor() as i64, at.y.floor() as i64);
        }
        let corner = (at - 0.5).floor();
        let part = at - 0.5 - corner;
        let (x, y) = (corner.x as i64, corner.y as i64);
        let (right, below) = (x.saturating_add(1), y.saturating_add(1));
        let upper = texel(x, y).lerp(texel(right, y), part.x);
        upper.lerp(texel(x, below).lerp(texel(right, below), part.x), part.y)
    }
}

fn used(material: &Material) -> impl Iterator<Item = (&Texture, Encoding)> {
    [
        (&material.base_color_texture, Encoding::Srgb),
        (&material.emissive_texture, Encoding::Srgb),
        (&material.metallic_roughness_texture, Encoding::Linear),
        (&material.normal_texture, Encoding::Linear),
        (&material.occlusion_texture, Encoding::Linear),
    ]
    .into_iter()
    .filter_map(|(texture, encoding)| Some((texture.as_ref()?, encoding)))
    .chain(material.height.as_ref().map(|height| (&height.texture, Encoding::Linear)))
}

/// Level of detail from the derivatives in texels; 0 where they are all 0 or not numbers.
fn level(dx: DVec2, dy: DVec2) -> f64 {
    let longest = dx.length_squared().max(dy.length_squared());
    if longest > 0.0 { 0.5 * longest.log2() } else { 0.0 }
}

/// The texel of 0 to `size - 1` that the coordinate `i` means.
fn wrap(i: i64, size: u32, mode: Wrap) -> usize {
    let size = i64::from(size);
    let wrapped = match mode {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::ClampToEdge => i.clamp(0, size - 1),
        Wrap::MirroredRepeat => {
            let i = i.rem_euclid(2 * size);
            i.min(2 * size - 1 - i)
        }
    };
    wrapped as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{IDENTITY_UV, Image};

    /// 4 x 4 texels, every byte another value.
    fn textures() -> (Textures, Texture, Vec<u8>) {
        let rgba8: Vec<u8> = (0..64).map(|i| (i * 37 + 11) as u8).collect();
        let texture = Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV };
        let image = Image { name: "test".into(), width: 4, height: 4, rgba8: rgba8.clone() };
        let material = Material {
            base_color_texture: Some(texture.clone()),
            normal_texture: Some(texture.clone()),
            ..Material::default()
        };
        let scene = Scene { images: vec![image], materials: vec![material], ..Scene::default() };
        (Textures::new(&scene).expect("a good image"), texture, rgba8)
    }

    fn at(u: f64, v: f64) -> Footprint {
        Footprint { uv: DVec2::new(u, v), dx: DVec2::ZERO, dy: DVec2::ZERO }
    }

    /// A footprint of `texels` of level 0 along x.
    fn wide(u: f64, v: f64, texels: f64) -> Footprint {
        Footprint { dx: DVec2::new(texels / 4.0, 0.0), ..at(u, v) }
    }

    #[test]
    fn exact_at_texel_centres() {
        let (textures, texture, rgba8) = textures();
        for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
            let bytes = &rgba8[(y * 4 + x) * 4..][..4];
            let expected = DVec4::from_array(std::array::from_fn(|i| f64::from(bytes[i]) / 255.0));
            // Two periods to the left and one down: the same texel.
            for (du, dv) in [(0.0, 0.0), (-2.0, 1.0)] {
                let footprint = at((x as f64 + 0.5) / 4.0 + du, (y as f64 + 0.5) / 4.0 + dv);
                assert_eq!(textures.sample(&texture, Encoding::Linear, &footprint), expected);
                let color = textures.sample(&texture, Encoding::Srgb, &footprint);
                assert_eq!((color.x, color.w), (mips::srgb_to_linear(bytes[0]), expected.w));
            }
        }
    }

    #[test]
    fn edges_blend_by_their_wrapping() {
        let (textures, mut texture, rgba8) = textures();
        let red = |x: usize| f64::from(rgba8[x * 4]) / 255.0;
        for (mode, expected) in
            [(Wrap::Repeat, (red(0) + red(3)) / 2.0), (Wrap::MirroredRepeat, red(0)), (Wrap::ClampToEdge, red(0))]
        {
            texture.sampler.wrap_u = mode;
            let found = textures.sample(&texture, Encoding::Linear, &at(0.0, 0.125)).x;
            assert!((found - expected).abs() < 1e-15, "{mode:?}: {found} against {expected}");
        }
        assert_eq!([-1, -4, -5, 4, 7, 8].map(|i| wrap(i, 4, Wrap::MirroredRepeat)), [0, 3, 3, 3, 0, 0]);
        assert_eq!([-1, 4].map(|i| wrap(i, 4, Wrap::Repeat)), [3, 0]);
        assert_eq!([i64::MIN, i64::MAX].map(|i| wrap(i, 4, Wrap::ClampToEdge)), [0, 3]);
    }

    #[test]
    fn filters_follow_the_level() {
        let (textures, mut texture, _) = textures();
        let sample =
            |texture: &Texture, texels: f64| textures.sample(texture, Encoding::Linear, &wide(0.3, 0.6, texels));
        let (zero, one, two) = (sample(&texture, 1.0), sample(&texture, 2.0), sample(&texture, 4.0));
        assert!(zero != one && one != two);
        // Level 0.5 lies in the middle; beyond the last level and without derivatives it is clamped.
        assert!((sample(&texture, 2f64.sqrt()) - (zero + one) * 0.5).length() < 1e-12);
        assert_eq!(sample(&texture, 1e9), two);
        assert_eq!(sample(&texture, f64::NAN), zero);
        assert_eq!(sample(&texture, 0.0), zero);
        texture.sampler.mip_linear = false;
        // Half a level is rounded down: ceil(0.5 + 0.5) - 1 = 0.
        assert_eq!(sample(&texture, 1.41), zero);
        assert_eq!(sample(&texture, 1.42), one);
        texture.sampler.mipmapped = false;
        assert_eq!(sample(&texture, 4.0), zero);
        texture.sampler.min_linear = false;
        assert_ne!(sample(&texture, 4.0), zero);
        assert_eq!(sample(&texture, 1.0), zero);
    }

    #[test]
    fn the_transform_moves_coordinates_and_scales_the_level() {
        let (textures, mut texture, _) = textures();
        let plain = textures.sample(&texture, Encoding::Linear, &wide(0.35, 0.4, 2.0));
        texture.uv_transform = [[2.0, 0.0, 0.25], [0.0, 1.0, 0.0]];
        let moved = textures.sample(&texture, Encoding::Linear, &wide(0.05, 0.4, 1.0));
        assert!((plain - moved).length() < 1e-12);
    }

    #[test]
    fn bad_images_are_refused() {
        let texture = Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV };
        let material = Material { base_color_texture: Some(texture), ..Material::default() };
        let mut scene = Scene { materials: vec![material], ..Scene::default() };
        assert!(Textures::new(&scene).is_err());
        scene.images.push(Image { name: "short".into(), width: 2, height: 2, rgba8: vec![0; 15] });
        assert!(Textures::new(&scene).is_err_and(|e| e.to_string().contains("short")));
    }
}
