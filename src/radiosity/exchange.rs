//! What all codecs of a scene's bake start from: patches, their exchange matrix in full, and where light of patches is mixed.

use std::ops::Range;

use glam::DVec3;

use super::bake::{POINTS, PatchRule, Settings};
use super::codec::Dense;
use super::factors::{Factors, RawRows, Report};
use super::patches::Patches;
use super::places::points_on;
use super::spectrum::{self, Spectrum};
use super::transfer::Transfer;
use crate::error::{Error, Result};
use crate::math::random::Random;
use crate::reference::render::Reference;
use crate::scene::Scene;
use crate::scene::view::View;

/// See the module.
#[derive(Debug, Clone)]
pub struct Exchange {
    /// [`Scene::surface_fingerprint`].
    pub fingerprint: String,
    /// Patches and what was left out.
    pub patches: Patches,
    /// [`POINTS`] places a patch with the unit normals there, world space.
    pub points: Vec<[DVec3; 2]>,
    /// Where light of patches is mixed.
    pub transfer: Transfer,
    /// Form factors over areas, symmetric, 1 / m^2.
    pub exact: Dense,
    /// Of those times reflectance.
    pub spectrum: Spectrum,
    /// How the factors came to be.
    pub factors: Report,
}

impl Exchange {
    /// From the patches and the raw rows of all of them.
    ///
    /// # Errors
    /// Rows that are missing; reflectance under which light never ends.
    pub fn new(scene: &Scene, occluders: &Reference, seed: u64, patches: Patches, rows: Vec<RawRows>) -> Result<Self> {
        let factors = Factors::of_rows(rows, &patches, occluders, seed)?;
        let exact = Dense { count: factors.count, elements: factors.over_area(&patches) };
        let report = factors.report;
        drop(factors);
        let spectrum = spectrum::of(&|sent| exact.product(sent, 32), &patches);
        if spectrum.largest >= 1.0 - 1e-6 {
            return Err(Error::new(format!(
                "{}: light between patches never ends: the largest eigenvalue of reflection is {:.6}",
                scene.name, spectrum.largest
            )));
        }
        let points = (0..patches.list.len()).flat_map(|index| points_of(&patches, index)).collect();
        let transfer = Transfer::new(&patches, occluders);
        let fingerprint = scene.surface_fingerprint();
        Ok(Self { fingerprint, patches, points, transfer, exact, spectrum, factors: report })
    }

    /// All of it, without a file.
    ///
    /// # Errors
    /// See [`patches`] and [`Exchange::new`].
    pub fn of_scene(scene: &Scene, settings: &Settings) -> Result<Self> {
        let seed = settings.seed;
        let occluders = Reference::new(scene, &View::of_world())?;
        let patches = patches(scene, &occluders, settings)?;
        let rows = RawRows::new(&patches, &occluders, seed, 0..patches.list.len(), &|| {})?;
        Self::new(scene, &occluders, seed, patches, vec![rows])
    }

    /// Areas of all patches, square metres.
    pub fn areas(&self) -> Vec<f64> {
        self.patches.list.iter().map(|patch| patch.area).collect()
    }
}

/// Patches of a scene as the settings have them.
///
/// # Errors
/// See [`Patches`].
pub fn patches(scene: &Scene, occluders: &Reference, settings: &Settings) -> Result<Patches> {
    let source = settings.patches_from;
    match settings.patches {
        PatchRule::Count(count) => Patches::of_count(scene, occluders, count, source),
        PatchRule::Size(size) => Patches::of(scene, occluders, size, source),
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

/// [`POINTS`] places of a patch with the unit normals there.
pub(super) fn points_of(patches: &Patches, index: usize) -> Vec<[DVec3; 2]> {
    let patch = &patches.list[index];
    let mut random = Random::new((index as u64).wrapping_mul(0xA24B_AED4_963E_E407));
    points_on(patch, POINTS, &mut random)
}
