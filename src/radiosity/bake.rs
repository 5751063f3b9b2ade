//! Everything that light between patches needs and that does not depend on light: patches, their exchange matrix in the codec's form, its spectrum,
//! and where light of patches is mixed. Made once, kept in a folder (`files`), loaded by every picture.

use std::ops::Range;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::codec::{self, Dense, ZeroBlock};
use super::factors::{Factors, RawRows, Report, point_on};
use super::patches::{Patch, Patches};
use super::spectrum::{self, Spectrum};
use super::transfer::Transfer;
use crate::error::{Error, Result};
use crate::math::random::Random;
use crate::reference::render::Reference;
use crate::scene::Scene;
use crate::scene::view::View;

/// Places of a patch at which direct light is looked at.
pub const POINTS: u32 = 16;
/// Light set-ups that the codec's error is measured with.
const PROBES: u64 = 6;

/// How many patches, or how wide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatchRule {
    /// About so many.
    Count(usize),
    /// Metres.
    Size(f64),
}

/// How the matrix is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CodecName {
    /// 32 bits an element.
    Classical,
    /// See [`ZeroBlock`].
    ZeroBlock,
}

impl CodecName {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Classical => "classical",
            Self::ZeroBlock => "zero-block",
        }
    }
}

/// What is baked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// How many patches, or how wide.
    pub patches: PatchRule,
    /// How the matrix is stored.
    pub codec: CodecName,
    /// Share of elements whose residual is stored beside blocks, 0 to 1.
    pub extract: f64,
    /// Of rays and points.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patches: PatchRule::Count(1000), codec: CodecName::ZeroBlock, extract: 0.02, seed: 1 }
    }
}

/// The exchange matrix as a device reads it.
#[derive(Debug, Clone, PartialEq)]
pub enum Operator {
    /// See [`Dense`].
    Dense(Dense),
    /// See [`ZeroBlock`].
    ZeroBlock(ZeroBlock),
}

impl Operator {
    /// Bytes on a device.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Dense(dense) => dense.bytes(),
            Self::ZeroBlock(blocks) => blocks.bytes(),
        }
    }

    /// What `sent`, times the patches' areas, comes to in each row; see the codecs.
    pub fn product(&self, sent: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        match self {
            Self::Dense(dense) => dense.product(sent, lanes),
            Self::ZeroBlock(blocks) => blocks.product(sent, lanes),
        }
    }

    /// A row, 1 / m^2.
    pub fn row(&self, i: usize) -> Vec<f32> {
        match self {
            Self::Dense(dense) => dense.elements[i * dense.count..(i + 1) * dense.count].to_vec(),
            Self::ZeroBlock(blocks) => blocks.row(i),
        }
    }

    /// Less by a factor.
    fn scaled(self, factor: f32) -> Self {
        match self {
            Self::Dense(mut dense) => {
                dense.elements.iter_mut().for_each(|x| *x *= factor);
                Self::Dense(dense)
            }
            Self::ZeroBlock(blocks) => Self::ZeroBlock(blocks.scaled(factor)),
        }
    }
}

/// A baked scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Bake {
    /// [`Scene::surface_fingerprint`].
    pub fingerprint: String,
    /// What was asked for.
    pub settings: Settings,
    /// Patches and what was left out; their triangles are not kept in files.
    pub patches: Patches,
    /// [`POINTS`] places a patch, world space.
    pub points: Vec<DVec3>,
    /// The exchange matrix.
    pub operator: Operator,
    /// Where light of patches is mixed.
    pub transfer: Transfer,
    /// Of the operator times reflectance.
    pub spectrum: Spectrum,
    /// How the factors came to be.
    pub factors: Report,
    /// Relative L2 error of irradiance that the codec makes: mean and largest over light set-ups.
    pub codec_error: [f64; 2],
    /// What everything stored was scaled by, so that no bounce adds energy: 1 where it need not be.
    pub norm_scale: f64,
}

/// Patches of a scene by a rule.
///
/// # Errors
/// See [`Patches`].
pub fn patches(scene: &Scene, occluders: &Reference, rule: PatchRule) -> Result<Patches> {
    match rule {
        PatchRule::Count(count) => Patches::of_count(scene, occluders, count),
        PatchRule::Size(size) => Patches::of_size(scene, occluders, size),
    }
}

impl Bake {
    /// All of it, without a file.
    ///
    /// # Errors
    /// See [`patches`] and [`Bake::new`].
    pub fn of_scene(scene: &Scene, settings: Settings) -> Result<Self> {
        let occluders = Reference::new(scene, &View::of_world())?;
        let patches = patches(scene, &occluders, settings.patches)?;
        let rows = RawRows::new(&patches, &occluders, settings.seed, 0..patches.list.len(), &|| {});
        Self::new(scene, &occluders, settings, patches, vec![rows])
    }

    /// From the patches and the raw rows of all of them.
    ///
    /// # Errors
    /// Rows that are missing; reflectance under which light never ends.
    pub fn new(
        scene: &Scene,
        occluders: &Reference,
        settings: Settings,
        patches: Patches,
        rows: Vec<RawRows>,
    ) -> Result<Self> {
        let factors = Factors::of_rows(rows, &patches, occluders, settings.seed)?;
        let elements = factors.over_area(&patches);
        let areas: Vec<f64> = patches.list.iter().map(|patch| patch.area).collect();
        let exact = Dense { count: factors.count, elements };
        let spectrum = spectrum::of(&Operator::Dense(exact.clone()), &patches);
        if spectrum.largest >= 1.0 - 1e-6 {
            return Err(Error::new(format!(
                "{}: light between patches never ends: the largest eigenvalue of reflection is {:.6}",
                scene.name, spectrum.largest
            )));
        }
        let report = factors.report;
        drop(factors);
        let operator = match settings.codec {
            CodecName::Classical => Operator::Dense(exact.clone()),
            CodecName::ZeroBlock => Operator::ZeroBlock(ZeroBlock::encode(&exact.elements, &areas, settings.extract)),
        };
        let found = spectrum::of(&operator, &patches);
        // A bound that no albedo of the scene passes: bounces of the stored matrix end as those of the exact one do.
        let bound = 0.5 * (1.0 + spectrum.largest);
        let norm_scale = if found.largest > bound { bound / found.largest } else { 1.0 };
        let (operator, spectrum) = if norm_scale < 1.0 {
            let operator = operator.scaled(norm_scale as f32);
            let spectrum = spectrum::of(&operator, &patches);
            (operator, spectrum)
        } else {
            (operator, found)
        };
        let codec_error = codec_error(&exact, &operator, &patches);
        let points = (0..patches.list.len()).flat_map(|index| points_of(&patches, index)).collect();
        let transfer = Transfer::new(&patches, occluders);
        Ok(Self {
            fingerprint: scene.surface_fingerprint(),
            settings,
            points,
            transfer,
            patches,
            operator,
            spectrum,
            factors: report,
            codec_error,
            norm_scale,
        })
    }

    /// Bytes of the matrix an element.
    pub fn bytes_an_element(&self) -> f64 {
        let count = self.patches.list.len() as f64;
        if count > 0.0 { self.operator.bytes() as f64 / (count * count) } else { 0.0 }
    }
}

/// Rows of `count` patches in runs that are baked, stored and resumed one by one: about as many pairs in each.
pub fn runs(count: usize) -> Vec<Range<usize>> {
    let pairs = |rows: usize| count.saturating_sub(rows + 1) as u64;
    let each = (count as u64 * count as u64 / 2).div_ceil(64).max(1);
    let (mut runs, mut first, mut held) = (Vec::new(), 0, 0);
    for row in 0..count {
        held += pairs(row);
        if held >= each || row + 1 == count {
            runs.push(first..row + 1);
            (first, held) = (row + 1, 0);
        }
    }
    runs
}

fn points_of(patches: &Patches, index: usize) -> Vec<DVec3> {
    let patch = &patches.list[index];
    let mut random = Random::new((index as u64).wrapping_mul(0xA24B_AED4_963E_E407));
    (0..POINTS).map(|k| point_on(patch, k, POINTS, &mut random)).collect()
}

/// Mean and largest relative L2 error of one gather, over light that falls in parallel or from a place, unhindered, in three colours.
fn codec_error(exact: &Dense, operator: &Operator, patches: &Patches) -> [f64; 2] {
    let count = patches.list.len();
    let areas: Vec<f64> = patches.list.iter().map(|patch| patch.area).collect();
    let low = patches.list.iter().map(|patch| patch.center).fold(DVec3::INFINITY, DVec3::min);
    let high = patches.list.iter().map(|patch| patch.center).fold(DVec3::NEG_INFINITY, DVec3::max);
    let errors: Vec<f64> = (0..PROBES)
        .map(|probe| {
            let mut random = Random::new(probe);
            let mut three = || DVec3::new(random.unit_f64(), random.unit_f64(), random.unit_f64());
            let (way, place) = ((three() - 0.5).normalize_or(DVec3::Y), low + (high - low) * three());
            let lit = |patch: &Patch| {
                let to = place - patch.center;
                let local = patch.normal.dot(to).max(0.0) / to.length().powi(3).max(1e-12);
                if probe % 2 == 0 { patch.normal.dot(way).max(0.0) } else { local }
            };
            let of = |patch: &Patch| (patch.reflectance * (lit(patch) * patch.area)).as_vec3().to_array();
            let sent: Vec<[f32; 3]> = patches.list.iter().map(of).collect();
            let right: Vec<[f64; 3]> = (0..count)
                .map(|i| {
                    let row = &exact.elements[i * count..(i + 1) * count];
                    let sum = |c: usize| row.iter().zip(&sent).map(|(x, s)| f64::from(*x) * f64::from(s[c])).sum();
                    [sum(0), sum(1), sum(2)]
                })
                .collect();
            codec::relative_l2(&operator.product(&sent, 32), &right, &areas)
        })
        .collect();
    let mean = errors.iter().sum::<f64>() / PROBES as f64;
    [mean, errors.into_iter().fold(0.0, f64::max)]
}

#[cfg(test)]
pub(crate) mod tests;
