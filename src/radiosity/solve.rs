//! Light of patches from their form factors: gathers until nothing changes any more, or so many (Neumann's series).

use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

use super::factors::Factors;
use super::patches::Patches;
use super::places::points_on;
use crate::math::random::Random;
use crate::reference::render::Reference;
use crate::reference::shade::Shader;

/// Points of a patch at which direct light is looked at.
const POINTS: u32 = 16;
/// Gathers before a series that does not end is left.
const MOST_GATHERS: u32 = 10_000;

/// Irradiance of each patch straight from punctual lights, past what stands in their way; lux by channel.
pub fn direct(patches: &Patches, occluders: &Reference, shader: &Shader, seed: u64) -> Vec<DVec3> {
    let of = |(index, patch): (usize, &super::Patch)| {
        let mut random = Random::new(seed ^ (index as u64).wrapping_mul(0xA24B_AED4_963E_E407));
        points_on(patch, POINTS, &mut random)
    };
    let points: Vec<[DVec3; 2]> = patches.list.iter().enumerate().flat_map(of).collect();
    direct_at(patches, &points, occluders, shader)
}

/// The same at given points with their normals, as many of each patch.
pub fn direct_at(patches: &Patches, points: &[[DVec3; 2]], occluders: &Reference, shader: &Shader) -> Vec<DVec3> {
    let each = points.len() / patches.list.len().max(1);
    let of = |index: usize| {
        let own = &points[index * each..(index + 1) * each];
        own.iter().map(|[at, normal]| occluders.irradiance(shader, *at, *normal)).sum::<DVec3>() / each.max(1) as f64
    };
    (0..patches.list.len()).into_par_iter().map(of).collect()
}

/// Irradiance of each patch from all others, of emission and of `direct` light after any number of reflections or at most `bounces` of them. Ends
/// where a gather changes nothing by more than `tolerance` of the mean.
pub fn indirect(
    factors: &Factors,
    patches: &Patches,
    direct: &[DVec3],
    bounces: Option<u32>,
    tolerance: f64,
) -> Vec<DVec3> {
    let mut irradiance = vec![DVec3::ZERO; factors.count];
    for _ in 0..bounces.unwrap_or(MOST_GATHERS) {
        let exitance: Vec<DVec3> = patches
            .list
            .iter()
            .zip(direct)
            .zip(&irradiance)
            .map(|((patch, direct), indirect)| patch.emission * PI + patch.reflectance * (*direct + *indirect))
            .collect();
        let gathered: Vec<DVec3> = (0..factors.count)
            .into_par_iter()
            .map(|i| factors.row(i).iter().zip(&exitance).map(|(share, sent)| *sent * f64::from(*share)).sum())
            .collect();
        let change = gathered.iter().zip(&irradiance).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
        let mean = gathered.iter().map(|e| e.element_sum()).sum::<f64>() / (3 * factors.count.max(1)) as f64;
        irradiance = gathered;
        if change <= tolerance * mean {
            break;
        }
    }
    irradiance
}

#[cfg(test)]
mod tests;
