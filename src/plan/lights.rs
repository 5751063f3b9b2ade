//! Lights in device form: view-space texels (src/shared.rs), and the choice of how they are read.

use glam::DVec3;
use rayon::prelude::*;

use super::light_parts::Sum;
use super::{FetchChoice, Limits};
use crate::error::{Error, Result};
use crate::scene::LightKind;
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;
use crate::shared;

/// How the shaders read light texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fetch {
    /// Storage buffer.
    Storage,
    /// Uniform buffer.
    Uniform,
    /// Uniform texel buffer.
    Texel,
}

impl Fetch {
    /// Value of the shaders' LIGHT_FETCH.
    pub fn constant(self) -> u32 {
        match self {
            Self::Storage => shared::FETCH_STORAGE,
            Self::Uniform => shared::FETCH_UNIFORM,
            Self::Texel => shared::FETCH_TEXEL,
        }
    }

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Storage => "storage",
            Self::Uniform => "uniform",
            Self::Texel => "texel",
        }
    }
}

/// Lights that one task rounds: enough that tasks cost nothing beside them.
const LIGHTS_A_TASK: usize = 4096;

/// All lights of a picture, ready for upload.
#[derive(Debug, Clone)]
pub struct LightTable {
    /// `count * texels_each` texels.
    pub texels: Vec<[f32; 4]>,
    /// Lights.
    pub count: u32,
    /// 2, or 4 where spots exist.
    pub texels_each: u32,
    /// Bits `KIND_*` of the kinds that occur.
    pub kinds: u32,
    /// See `Frame::light_remainder_step`.
    pub remainder_step: f32,
    /// See `Frame::light_seek_limit`.
    pub seek_limit: f32,
    /// Lights out of range are stepped over by a loop of their own; pointless where no light has a range.
    pub seek: bool,
    /// How shaders read them.
    pub fetch: Fetch,
    /// Why.
    pub fetch_why: String,
}

pub(super) fn kind_of(light: &ResolvedLight) -> u32 {
    match light.kind {
        LightKind::Point => shared::KIND_POINT,
        LightKind::Spot { .. } => shared::KIND_SPOT,
        LightKind::Directional => shared::KIND_DIRECTIONAL,
    }
}

/// The smallest f32 that is not below `x` (finite, not negative).
fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// Metres a step of the packed remainders: 1/128 of the ulp of the largest coordinate.
fn remainder_step(positions: impl Iterator<Item = DVec3>) -> f32 {
    let largest = positions.fold(0.0f32, |m, p| m.max(p.abs().max_element() as f32)).max(f32::MIN_POSITIVE);
    // An ulp of x in [2^e, 2^(e+1)) is 2^(e-23).
    let exponent = (largest.to_bits() >> 23) as i32 - 127;
    (f64::from(exponent - 23).exp2() / 128.0) as f32
}

/// The rounded position and what rounding took from it, packed (src/shared.rs).
fn split(position: DVec3, step: f32) -> ([f32; 3], u32) {
    let rounded = position.as_vec3();
    let rest = (position - rounded.as_dvec3()) / f64::from(step).max(f64::MIN_POSITIVE);
    let bias = f64::from(shared::REMAINDER_BIAS);
    let steps = rest.to_array().map(|r| (r.round() + bias).clamp(0.0, 2.0 * bias - 1.0) as u32);
    let packed = steps[0] | steps[1] << shared::REMAINDER_BITS | steps[2] << (2 * shared::REMAINDER_BITS);
    (rounded.to_array(), packed)
}

/// Limit of `light_out_of_range`. The shader's distance is that to the rounded position: off by at most e = sqrt(3) * 64 steps
/// (half an ulp a component), and by a few ulp of the arithmetic. A surface inside the range R has d < R, so its rounded distance
/// is under R + e: from (1 + e/R)^2 on, with 1e-5 for the arithmetic, nothing is inside.
fn seek_limit(lighting: &Lighting, step: f32) -> f32 {
    let shortest = lighting.lights.iter().map(|l| l.range).fold(f64::INFINITY, f64::min);
    let off = 3f64.sqrt() * 64.0 * f64::from(step);
    round_up((1.0 + off / shortest).powi(2) * (1.0 + 1e-5)).min(f32::MAX)
}

fn push(texels: &mut Vec<[f32; 4]>, light: &ResolvedLight, view: &View, texels_each: u32, step: f32) {
    let kind = kind_of(light);
    let rotate = |v: DVec3| view.world_to_view.transform_vector3(v).normalize();
    let ([x, y, z], remainder, inverse_range2) = if kind == shared::KIND_DIRECTIONAL {
        ((-rotate(light.direction)).as_vec3().to_array(), 0, 0.0)
    } else {
        // Rounded up, so that the window has reached 0 wherever the true range has.
        let inverse = round_up(1.0 / (light.range * light.range));
        let (rounded, packed) = split(view.world_to_view.transform_point3(light.position), step);
        (rounded, packed, inverse)
    };
    let [r, g, b] = light.intensity.as_vec3().to_array();
    texels.push([x, y, z, inverse_range2]);
    texels.push([r, g, b, (remainder | kind << (3 * shared::REMAINDER_BITS)) as f32]);
    if texels_each == shared::LIGHT_TEXELS_SPOT {
        let [x, y, z] = rotate(light.direction).as_vec3().to_array();
        let (mut one_minus_cos_outer, mut scale) = (0.0, 0.0);
        if let LightKind::Spot { inner, outer } = light.kind {
            // 1 - cos as 2 sin^2(a/2): narrow cones keep their digits.
            let one_minus_cos = |a: f32| 2.0 * (f64::from(a) * 0.5).sin().powi(2);
            one_minus_cos_outer = one_minus_cos(outer);
            scale = 1.0 / (one_minus_cos_outer - one_minus_cos(inner)).max(0.001);
        }
        texels.push([x, y, z, one_minus_cos_outer as f32]);
        texels.push([scale as f32, 0.0, 0.0, 0.0]);
    }
}

impl LightTable {
    /// Rounds `lighting` to view space and f32 and chooses the fetch.
    ///
    /// # Errors
    /// A fetch that was asked for and cannot hold the lights; more lights than a storage buffer binds; an intensity past f32.
    pub fn new(lighting: &Lighting, view: &View, choice: FetchChoice, limits: &Limits) -> Result<Self> {
        check_intensities(lighting)?;
        let kinds = lighting.lights.iter().fold(0, |k, l| k | kind_of(l));
        let spots = kinds & shared::KIND_SPOT != 0;
        let texels_each = if spots { shared::LIGHT_TEXELS_SPOT } else { shared::LIGHT_TEXELS_POINT };
        let count = u32::try_from(lighting.lights.len()).unwrap_or(u32::MAX);
        let texel_count = u64::from(count) * u64::from(texels_each);
        let seek = lighting.lights.iter().any(|l| l.range.is_finite());
        let (fetch, fetch_why) = choose(choice, count, texel_count, limits)?;
        let placed = lighting.lights.iter().filter(|l| l.kind != LightKind::Directional);
        let positions = placed.map(|l| view.world_to_view.transform_point3(l.position));
        let step = remainder_step(positions);
        let table: Vec<&ResolvedLight> = lighting.in_table_order().collect();
        let texels_of = |run: &[&ResolvedLight]| {
            let mut texels = Vec::with_capacity(run.len() * texels_each as usize);
            run.iter().for_each(|light| push(&mut texels, light, view, texels_each, step));
            texels
        };
        let runs: Vec<_> = table.par_chunks(LIGHTS_A_TASK).map(texels_of).collect();
        Ok(Self {
            texels: runs.concat(),
            count,
            texels_each,
            kinds,
            remainder_step: step,
            seek_limit: seek_limit(lighting, step),
            seek,
            fetch,
            fetch_why,
        })
    }

    /// Bytes of the light buffer.
    pub fn bytes(&self) -> u64 {
        self.texels.len() as u64 * 16
    }
}

/// Refuses what would be infinite on the device: colour and intensity each fit f32, their product may not.
fn check_intensities(lighting: &Lighting) -> Result<()> {
    let most = f64::from(f32::MAX);
    match lighting.lights.iter().find(|l| l.intensity.max_element() > most) {
        Some(light) => Err(Error::new(format!(
            "a light at {} has colour times intensity {:e}, more than the {most:e} of 32-bit floats",
            light.position,
            light.intensity.max_element()
        ))),
        None => Ok(()),
    }
}

/// Refuses what the driver would cut short, for a technique that adds all lights in one pass.
pub(super) fn check_loops(count: u32, seek: bool, limits: &Limits) -> Result<()> {
    let sum = Sum { lights: count, ahead: 0, seek };
    if !sum.fits(limits) {
        let (iterations, most) = (sum.iterations(), limits.max_loop_iterations);
        return Err(Error::new(format!(
            "a pixel loops over {count} lights in up to {iterations} iterations, this driver leaves its loops after {most}; \
             --technique forward adds them in several passes"
        )));
    }
    Ok(())
}

fn choose(choice: FetchChoice, count: u32, texels: u64, limits: &Limits) -> Result<(Fetch, String)> {
    let bytes = texels * 16;
    let fits_storage = bytes <= limits.max_storage_bytes;
    let fits_uniform = bytes <= limits.max_uniform_bytes;
    let fits_texel = texels <= limits.max_texel_elements;
    let refuse = |what: &str, most: u64, unit: &str| {
        Err(Error::new(format!("--light-fetch {what}: {count} lights do not fit into this device's {most} {unit}")))
    };
    if !fits_storage {
        let most = limits.max_storage_bytes;
        return Err(Error::new(format!("{count} lights need {bytes} bytes, this device binds at most {most} at once")));
    }
    match choice {
        FetchChoice::Uniform if !fits_uniform => refuse("uniform", limits.max_uniform_bytes, "bytes of uniform buffer"),
        FetchChoice::Texel if !fits_texel => refuse("texel", limits.max_texel_elements, "texels of a texel buffer"),
        FetchChoice::Storage => Ok((Fetch::Storage, "asked for".into())),
        FetchChoice::Uniform => Ok((Fetch::Uniform, "asked for".into())),
        FetchChoice::Texel => Ok((Fetch::Texel, "asked for".into())),
        FetchChoice::Auto => {
            let profile = limits.profile.clone().unwrap_or_default();
            let ways = [
                (Fetch::Texel, fits_texel, profile.texel_fetch),
                (Fetch::Uniform, fits_uniform, profile.uniform_fetch),
                (Fetch::Storage, true, profile.storage_fetch),
            ];
            let fitting = ways.iter().filter(|way| way.1);
            let best = fitting.min_by(|a, b| a.2.total_cmp(&b.2)).map_or(Fetch::Storage, |way| way.0);
            let ns = |way: &(Fetch, bool, f64)| {
                let fits = if way.1 { format!("{} ns", way.2) } else { "does not fit".into() };
                format!("{} {fits}", way.0.name())
            };
            Ok((
                best,
                format!("the fastest that holds them: {}; {}", ways.each_ref().map(ns).join(", "), profile.source),
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_that_a_driver_would_cut_short_are_refused() {
        let limits = Limits { max_loop_iterations: 65_535, ..Limits::MINIMUM };
        assert!(check_loops(31_298, true, &limits).is_ok());
        let refused = check_loops(31_299, true, &limits).expect_err("one too many").to_string();
        assert!(refused.contains("31299 lights") && refused.contains("65535"), "{refused}");
        assert!(check_loops(65_535, false, &limits).is_ok());
        assert!(check_loops(65_536, false, &limits).is_err());
        assert!(check_loops(1 << 20, true, &Limits::MINIMUM).is_ok());
    }
}
