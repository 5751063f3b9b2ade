//! Light of patches from their form factors: gathers until nothing changes any more, or so many (Neumann's series).

use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

use super::factors::Factors;
use super::patches::Patches;
use crate::reference::render::Reference;
use crate::reference::shade::Shader;

/// Gathers before a series that does not end is left.
const MOST_GATHERS: u32 = 10_000;

/// Irradiance of each patch straight from punctual lights, past what stands in their way, at given points with their normals, as many of each patch; lux
/// by channel.
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
