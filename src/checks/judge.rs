//! Pictures of any material against rays, and how far they may be apart.
//!
//! What two right renderers may differ by, in the mean over the interior (covered pixels whose 3x3 neighbourhood is one surface):
//! - What a plain picture may: [`picture_bound`].
//! - A rasteriser with p sub-pixel bits moves each vertex by at most 2^-(p+1) pixels along x and along y, and a pixel's interpolants
//!   by a blend of its three vertices' shifts. So the reference is drawn again through a lens moved by as much along x, and along y;
//!   the two differences together bound what the shifts do, to lighting, to filtered texels, and to texels that a pixel passes to.
//! - `subTexelPrecisionBits` and `mipmapPrecisionBits` cut the way between two texels, and between two levels, into 2^bits divisions;
//!   a weight is snapped to one, so it is off by half a division in the mean and its blend of a and b by |b - a| times that. Places
//!   all over the map, at levels 0 to 3, give the mean, for both axes and the level together.
//! - Vulkan gives no precision for decoding sRGB: half a code is allowed, the least that 8 bits tell apart. Each of the blends along
//!   u, v and the level may round a linear map's value to 8 bits, a quarter of a code in the mean.
//!
//! The last two are errors of a map's value. The reference is lit again with values that are off by them, which gives the radiance's.
//!
//! Pixels off by a fifth are counted beside the mean: as many are allowed as the two moved pictures have, which is none but where
//! pixels pass to another texel or surface.

use glam::{DVec2, DVec3};

use super::oracle::{self, larger, picture_bound};
use crate::error::Result;
use crate::math::random::Random;
use crate::measure::metrics;
use crate::plan::{Plan, Request};
use crate::reference::render::Reference;
use crate::reference::shade::Shader;
use crate::reference::surface::Surface;
use crate::reference::texture::{Encoding, Footprint, Textures};
use crate::renderer::Renderer;
use crate::scene::{IDENTITY_UV, Material, Scene, Texture, mips};

/// Relative error from which a pixel counts as an outlier.
const OUTLIER: f64 = 0.2;

/// Places of a map at which its filter's error is taken.
const PLACES: usize = 512;

/// How a picture compares with its rays.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// Mean relative error over the interior: covered pixels whose 3x3 neighbourhood is one surface.
    pub error: f64,
    /// What [`error`](Self::error) may be.
    pub bound: f64,
    /// Interior pixels off by more than a fifth.
    pub outliers: usize,
    /// What [`outliers`](Self::outliers) may be.
    pub outlier_bound: usize,
    /// Pixels drawn where rays hit nothing in the whole neighbourhood, or not drawn where all hit one surface.
    pub misplaced: usize,
    /// Pixels of the interior.
    pub interior: usize,
    /// Pixels that the device covered.
    pub covered: usize,
    /// Pixels with a channel that is NaN or infinite.
    pub not_finite: usize,
}

/// The pixels of a reference picture that others are compared in.
struct Interior<'a> {
    rgba: &'a [[f64; 4]],
    pixels: Vec<usize>,
    /// Least value that an error is relative to: 1e-3 of the mean.
    floor: f64,
}

impl<'a> Interior<'a> {
    fn new(rgba: &'a [[f64; 4]], pixels: Vec<usize>) -> Self {
        let sum: f64 = rgba.iter().flat_map(|pixel| &pixel[..3]).map(|c| c.abs()).sum();
        Self { rgba, pixels, floor: 1e-3 * sum / (3 * rgba.len()).max(1) as f64 }
    }

    /// Mean relative error of another picture and the number of its outliers; NaN where there is no pixel to compare.
    fn errors(&self, other: &[[f64; 4]]) -> (f64, usize) {
        let (mut sum, mut outliers) = (0.0, 0);
        for &pixel in &self.pixels {
            let (a, b) = (self.rgba[pixel], other[pixel]);
            let error = (0..3).map(|c| (a[c] - b[c]).abs() / a[c].abs().max(self.floor)).fold(0.0, larger);
            sum += error;
            outliers += usize::from(error.is_nan() || error > OUTLIER);
        }
        (sum / self.pixels.len() as f64, outliers)
    }
}

/// Alpha that a surface may have beside that of rays, from filters.
const ALPHA_BOUND: f64 = 1.0 / 8.0;

/// Draws `scene` and compares it with rays; the module says how the bounds come about.
///
/// # Errors
/// A scene or a request that cannot be drawn, or a lost device.
pub fn judge(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<Judged> {
    scene.validate()?;
    let plan = Plan::new(scene, request, &renderer.limits())?;
    let drawn = oracle::draw(renderer, scene, &plan)?;
    let shader = oracle::shader(&plan);
    let reference = Reference::new(scene, &plan.view)?;
    let traced = reference.render(&shader, &|_| {});
    let uniform = metrics::interior_mask(&traced.surface_id, traced.width, traced.height);
    let is_hit = |pixel: usize| traced.surface_id[pixel] != u32::MAX;
    let is_covered = |pixel: usize| drawn[pixel][3] > 0.0;
    // Alpha is 0 or 1, but for blended surfaces, whose textures drivers filter to 8 bits.
    let is_elsewhere = |pixel: usize| (f64::from(drawn[pixel][3]) - traced.rgba[pixel][3]).abs() > ALPHA_BOUND;
    let pixels: Vec<usize> = (0..drawn.len()).filter(|&p| uniform[p] && is_hit(p)).collect();
    let interior = Interior::new(&traced.rgba, pixels);
    let (error, outliers) = interior.errors(&metrics::widen(&drawn));
    // Of surfaces over each other the nearest stands for all: its share of the pixel is at most 1.
    let hit = |p: usize| {
        let (x, y) = (p as u32 % request.width, p as u32 / request.width);
        reference.blended(x, y).pop().or_else(|| reference.surface(x, y))
    };
    let surfaces: Vec<Option<Surface>> = interior.pixels.iter().map(|&p| hit(p).map(|h| h.surface)).collect();
    let mut bound = picture_bound(renderer) + sampling_error(renderer, scene, &interior, &surfaces, &shader)?;
    let mut outlier_bound = 0;
    let step = 0.5 * (-f64::from(renderer.device().facts.limits.sub_pixel_precision_bits)).exp2();
    for (x, y) in [(step, 0.0), (0.0, step)] {
        let moved = Reference::new(scene, &plan.view.moved(x, y))?.render(&shader, &|_| {});
        let (error, outliers) = interior.errors(&moved.rgba);
        bound += error;
        outlier_bound += outliers;
    }
    Ok(Judged {
        error,
        bound,
        outliers,
        outlier_bound,
        misplaced: (0..drawn.len()).filter(|&p| uniform[p] && is_elsewhere(p)).count(),
        interior: interior.pixels.len(),
        covered: (0..drawn.len()).filter(|&p| is_covered(p)).count(),
        not_finite: drawn.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count(),
    })
}

/// Mean error of a map's values.
#[derive(Clone, Copy)]
struct Precision {
    /// By the weights of the filter.
    filter: f64,
    encoding: Encoding,
}

impl Precision {
    /// A value of the map, off by the filter's error and by that of the codes.
    fn off(self, value: f64) -> f64 {
        let codes = match self.encoding {
            Encoding::Linear => 0.75 / 255.0,
            Encoding::Srgb => {
                // Light a code, of ((code + 14.025) / 269.025)^2.4 and, near black, of code / (255 * 12.92).
                let code = f64::from(mips::linear_to_srgb(value));
                0.5 * (2.4 * value / (code + 14.025)).max(1.0 / (255.0 * 12.92))
            }
        };
        value + self.filter + codes
    }

    /// A surface whose mapped normal is off along `axis`. A texel's error is doubled by the decoding `2 t - 1`, and the sum of the
    /// weighted axes is at least 0.84 long, for a blue of 235 and more: 2 / 0.84 < 2.4.
    fn tilt(self, surface: Surface, axis: DVec3) -> Surface {
        Surface { normal: (surface.normal + axis * (2.4 * self.off(0.0))).normalize(), ..surface }
    }
}

type Change = fn(Surface, Precision) -> Surface;

/// A kind of map, and the ways in which its error changes a surface. Factors are at most 1.
struct MapRule {
    of: fn(&Material) -> Option<&Texture>,
    encoding: Encoding,
    changes: &'static [Change],
}

const MAPS: [MapRule; 5] = [
    MapRule {
        of: |m| m.base_color_texture.as_ref(),
        encoding: Encoding::Srgb,
        changes: &[|s, p| Surface { base_color: s.base_color.map(|v| p.off(v)), ..s }],
    },
    MapRule {
        of: |m| m.metallic_roughness_texture.as_ref(),
        encoding: Encoding::Linear,
        changes: &[
            |s, p| Surface { metallic: p.off(s.metallic).min(1.0), ..s },
            |s, p| Surface { roughness: p.off(s.roughness).min(1.0), ..s },
        ],
    },
    MapRule {
        of: |m| m.normal_texture.as_ref(),
        encoding: Encoding::Linear,
        changes: &[|s, p| p.tilt(s, DVec3::X), |s, p| p.tilt(s, DVec3::Y), |s, p| p.tilt(s, DVec3::Z)],
    },
    MapRule {
        of: |m| m.occlusion_texture.as_ref(),
        encoding: Encoding::Linear,
        changes: &[|s, p| Surface { occlusion: p.off(s.occlusion), ..s }],
    },
    MapRule {
        of: |m| m.emissive_texture.as_ref(),
        encoding: Encoding::Srgb,
        changes: &[|s, p| Surface { emissive: s.emissive.map(|v| p.off(v)), ..s }],
    },
];

/// Mean relative error of the radiance by all that sampling may be off.
fn sampling_error(
    renderer: &Renderer,
    scene: &Scene,
    interior: &Interior,
    surfaces: &[Option<Surface>],
    shader: &Shader,
) -> Result<f64> {
    let limits = &renderer.device().facts.limits;
    let halves = [limits.sub_texel_precision_bits, limits.mipmap_precision_bits].map(|b| 0.5 * (-f64::from(b)).exp2());
    let textures = Textures::new(scene)?;
    let mut sum = 0.0;
    for rule in &MAPS {
        let used = scene.materials.iter().filter_map(rule.of);
        let filters = used.map(|texture| filter_error(&textures, scene, texture, rule.encoding, halves));
        let Some(filter) = filters.reduce(larger) else { continue };
        for change in rule.changes {
            let mut rgba = interior.rgba.to_vec();
            for (&pixel, surface) in interior.pixels.iter().zip(surfaces) {
                let Some(surface) = surface else { continue };
                let changed = change(*surface, Precision { filter, encoding: rule.encoding });
                rgba[pixel] = shader.radiance(&changed).extend(1.0).to_array();
            }
            sum += interior.errors(&rgba).0;
        }
    }
    Ok(sum)
}

/// Mean change of the largest channel where the weights along u, along v and between levels are off by `halves`: half a division of
/// the texels, and of the levels.
fn filter_error(textures: &Textures, scene: &Scene, texture: &Texture, encoding: Encoding, halves: [f64; 2]) -> f64 {
    let texture = Texture { uv_transform: IDENTITY_UV, ..texture.clone() };
    let image = &scene.images[texture.image];
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let at = |uv: DVec2, level: f64| {
        let dx = DVec2::new(level.exp2() / size.x, 0.0);
        textures.sample(&texture, encoding, &Footprint { uv, dx, dy: DVec2::ZERO }).truncate()
    };
    let mut random = Random::new(1);
    let mut sum = 0.0;
    for _ in 0..PLACES {
        let uv = DVec2::new(random.unit_f64(), random.unit_f64());
        let level = random.range(0.0, 3.0);
        // The coarser of the two levels has the wider texels.
        let texel = if texture.sampler.mipmapped { level.ceil().exp2() } else { 1.0 };
        let step = texel * halves[0] / size;
        let moved = [
            at(uv + DVec2::new(step.x, 0.0), level),
            at(uv + DVec2::new(0.0, step.y), level),
            at(uv, level + halves[1]),
        ];
        let value = at(uv, level);
        sum += moved.iter().map(|v| (*v - value).abs().max_element()).sum::<f64>();
    }
    sum / PLACES as f64
}
