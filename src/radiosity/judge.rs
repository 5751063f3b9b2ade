//! How far light of patches is from what it should be: over light that falls in parallel or from a place, against all bounces of the exact matrix.

use glam::DVec3;

use super::bake::Sums;
use super::codec;
use super::patches::{Patch, Patches};
use super::spectrum::Product;
use crate::math::random::Random;

/// Light set-ups.
const PROBES: u64 = 6;
/// Reflections in which what is left of light is under what f32 holds.
const MOST_BOUNCES: usize = 400;
/// Change of the whole at which they end.
const TOLERANCE: f64 = 1e-7;

/// What takes exitance of all patches to their irradiance.
pub type Gather<'a> = &'a dyn Fn(&[[f32; 3]]) -> Vec<[f64; 3]>;

/// Exitance of a light set-up, and irradiance that it leads to.
type Probe = (Vec<[f32; 3]>, Vec<[f64; 3]>);

/// Light set-ups and the right answers.
pub struct Judge {
    areas: Vec<f64>,
    probes: Vec<Probe>,
}

/// What was found of a way to gather light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Relative L2 error of irradiance, mean over light set-ups.
    pub mean: f64,
    /// The largest.
    pub worst: f64,
    /// Power that arrives, over what should, mean.
    pub energy: f64,
}

impl Judge {
    /// With the answers of `right`.
    pub fn new(patches: &Patches, right: Gather) -> Self {
        let areas = patches.list.iter().map(|patch| patch.area).collect();
        let probe = |k: u64| {
            let exitance = probe_light(patches, k);
            let answer = right(&exitance);
            (exitance, answer)
        };
        Self { areas, probes: (0..PROBES).map(probe).collect() }
    }

    /// Exitance of each light set-up.
    pub fn lights(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        self.probes.iter().map(|(exitance, _)| exitance.as_slice())
    }

    /// Of another way.
    pub fn error(&self, found: Gather) -> Found {
        self.score(&self.lights().map(found).collect::<Vec<_>>())
    }

    /// Of irradiance under each light set-up.
    pub fn score(&self, found: &[Vec<[f64; 3]>]) -> Found {
        let power = |of: &[[f64; 3]]| of.iter().zip(&self.areas).map(|(e, a)| (e[0] + e[1] + e[2]) * a).sum::<f64>();
        let (mut mean, mut worst, mut energy) = (0.0, 0.0f64, 0.0);
        for ((_, right), other) in self.probes.iter().zip(found) {
            let error = codec::relative_l2(other, right, &self.areas);
            mean += error / self.probes.len() as f64;
            worst = worst.max(error);
            let all = power(right);
            energy += if all > 0.0 { power(other) / all } else { 1.0 } / self.probes.len() as f64;
        }
        Found { mean, worst, energy }
    }
}

/// The same numbers in f64.
pub fn wide(of: &[[f32; 3]]) -> Vec<[f64; 3]> {
    of.iter().map(|e| e.map(f64::from)).collect()
}

/// Irradiance by sums of bounces as they were before any codec, summed in f64.
pub fn product_of_sums((sums, scales): &Sums, exitance: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let n = exitance.len();
    let row = |i: usize| {
        std::array::from_fn(|c| {
            let row = &sums[c][i * n..(i + 1) * n];
            let sum: f64 = row.iter().zip(exitance).map(|(x, b)| f64::from(*x) * f64::from(b[c])).sum();
            sum * scales.as_ref().map_or(1.0, |scales| f64::from(scales[i][c]))
        })
    };
    (0..n).map(row).collect()
}

/// Irradiance after all bounces, from exitance.
pub fn after_bounces(product: Product, patches: &Patches, exitance: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let mut irradiance = vec![[0.0f64; 3]; exitance.len()];
    for _ in 0..MOST_BOUNCES {
        let sent: Vec<[f32; 3]> = patches
            .list
            .iter()
            .zip(exitance)
            .zip(&irradiance)
            .map(|((patch, first), e)| {
                let reflectance = patch.reflectance.to_array();
                std::array::from_fn(|c| ((f64::from(first[c]) + reflectance[c] * e[c]) * patch.area) as f32)
            })
            .collect();
        let next = wide(&product(&sent));
        let change = next.iter().flatten().zip(irradiance.iter().flatten()).map(|(a, b)| (a - b).abs()).sum::<f64>();
        let whole: f64 = next.iter().flatten().sum();
        irradiance = next;
        if change <= TOLERANCE * whole {
            break;
        }
    }
    irradiance
}

/// Exitance of all patches under one of the light set-ups that codecs are judged by.
fn probe_light(patches: &Patches, probe: u64) -> Vec<[f32; 3]> {
    let low = patches.list.iter().map(|patch| patch.center).fold(DVec3::INFINITY, DVec3::min);
    let high = patches.list.iter().map(|patch| patch.center).fold(DVec3::NEG_INFINITY, DVec3::max);
    let mut random = Random::new(probe);
    let mut three = || DVec3::new(random.unit_f64(), random.unit_f64(), random.unit_f64());
    let (way, place) = ((three() - 0.5).normalize_or(DVec3::Y), low + (high - low) * three());
    let lit = |patch: &Patch| {
        let to = place - patch.center;
        let local = patch.normal.dot(to).max(0.0) / to.length().powi(3).max(1e-12);
        if probe.is_multiple_of(2) { patch.normal.dot(way).max(0.0) } else { local }
    };
    patches.list.iter().map(|patch| (patch.reflectance * lit(patch)).as_vec3().to_array()).collect()
}
