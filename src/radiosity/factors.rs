//! Form factors between all patches: near ones by their triangles, others by points, times the share of rays between them that nothing stops.
//!
//! What is computed is the exchange `A_i F_ij = A_j F_ji`, once for each pair. Afterwards rows are scaled symmetrically (each by a factor of its own,
//! to both sides) so that each sums to the share of light that meets any patch, which rays from the patch itself tell; the report says by how much.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::patches::{Patch, Patches, by_cosine};
use super::places::Places;
use crate::error::{Error, Result};
use crate::math::random::Random;
use crate::reference::render::Reference;

mod rows;

pub use rows::RawRows;

/// Rays from each patch that tell what its row sums to.
const ROW_RAYS: u32 = 256;
/// Columns are counted in 16 bits.
pub const MOST_PATCHES: usize = 1 << 15;
/// Rows that sum to less see next to nothing: their rays are too few to judge them by.
const DARK: f64 = 0.05;
/// A row's own factor is at most that, and at least one over it: what is off by more is not mended by scaling.
const MOST_SCALE: f64 = 2.0;
/// Rounds of scaling; the sum of a row is off by the square of what it was after each.
const ROUNDS: u32 = 40;

/// Form factors of `count` patches.
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    /// Patches.
    pub count: usize,
    /// Row i, column j: share of the light that leaves patch i and meets patch j.
    pub rows: Vec<f32>,
    /// How they came to be.
    pub report: Report,
}

/// What was computed, and how good it was.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Report {
    /// Pairs by their triangles (in closed form where these are near), by points and by one point.
    pub pairs: [u64; 3],
    /// Rays between patches.
    pub rays: u64,
    /// Smallest, mean and largest sum of a row over the share of light that rays from it find to meet a patch, before scaling.
    pub row_sums: [f64; 3],
    /// The largest change that scaling made to a row's own factor.
    pub largest_scale: f64,
    /// Largest sum of a row of form factors, after that.
    pub most_seen: f64,
}

impl Factors {
    /// All pairs, on all cores. `progress` is told of each row that is done.
    ///
    /// # Errors
    /// More patches than a matrix of so many rows and columns is made of here.
    pub fn new(patches: &Patches, occluders: &Reference, seed: u64, progress: &(dyn Fn() + Sync)) -> Result<Self> {
        let raw = RawRows::new(patches, occluders, seed, 0..patches.list.len(), progress)?;
        Self::of_rows(vec![raw], patches, occluders, seed)
    }

    /// From the rows of all patches, in any grouping.
    ///
    /// # Errors
    /// As [`Factors::new`]; rows that are missing.
    pub fn of_rows(raw: Vec<RawRows>, patches: &Patches, occluders: &Reference, seed: u64) -> Result<Self> {
        let count = patches.list.len();
        if count > MOST_PATCHES {
            return Err(Error::new(format!("{count} patches: at most {MOST_PATCHES} have a matrix here")));
        }
        let mut rows = vec![0f32; count * count];
        let (mut counted, mut there) = ([0u64; 4], 0);
        for part in raw {
            (0..4).for_each(|k| counted[k] += part.counted[k]);
            for (offset, row) in part.exchanges.iter().enumerate() {
                let i = part.first + offset;
                if i + 1 + row.len() != count {
                    return Err(Error::new(format!("row {i} of {count} has {} elements", row.len())));
                }
                there += 1;
                for (offset, &value) in row.iter().enumerate() {
                    let j = i + 1 + offset;
                    (rows[i * count + j], rows[j * count + i]) = (value, value);
                }
            }
        }
        if there != count {
            return Err(Error::new(format!("{there} rows for {count} patches")));
        }
        let [near, between, far, rays] = counted;
        let mut factors =
            Self { count, rows, report: Report { pairs: [near, between, far], rays, ..Report::default() } };
        factors.scale(patches, occluders, seed);
        Ok(factors)
    }

    /// Form factors over the area of the patch that light comes from: symmetric, 1 / m^2.
    pub fn over_area(&self, patches: &Patches) -> Vec<f32> {
        let mut elements = self.rows.clone();
        for i in 0..self.count {
            for j in i + 1..self.count {
                let value = (f64::from(self.rows[i * self.count + j]) / patches.list[j].area) as f32;
                (elements[i * self.count + j], elements[j * self.count + i]) = (value, value);
            }
        }
        elements
    }

    /// From exchanges to form factors whose rows sum to what rays find.
    fn scale(&mut self, patches: &Patches, occluders: &Reference, seed: u64) {
        let count = self.count;
        let targets: Vec<f64> = patches
            .list
            .par_iter()
            .enumerate()
            .map(|(i, patch)| row_target(patch, occluders, seed ^ i as u64))
            .collect();
        let mut scales = vec![1.0f64; count];
        for round in 0..ROUNDS {
            let sums: Vec<f64> = (0..count)
                .into_par_iter()
                .map(|i| {
                    let row = &self.rows[i * count..(i + 1) * count];
                    let sum: f64 = row.iter().zip(&scales).map(|(x, scale)| f64::from(*x) * scale).sum();
                    sum * scales[i] / patches.list[i].area
                })
                .collect();
            if round == 0 {
                let shares: Vec<f64> =
                    sums.iter().zip(&targets).filter(|(_, t)| **t > DARK).map(|(sum, target)| sum / target).collect();
                let mean = shares.iter().sum::<f64>() / shares.len().max(1) as f64;
                let least = shares.iter().copied().reduce(f64::min).unwrap_or(0.0);
                self.report.row_sums = [least, mean.abs(), shares.iter().copied().fold(0.0, f64::max)];
            }
            for ((scale, sum), target) in scales.iter_mut().zip(&sums).zip(&targets) {
                if *sum > 0.0 {
                    *scale = (*scale * (target / sum).sqrt()).clamp(1.0 / MOST_SCALE, MOST_SCALE);
                }
            }
        }
        self.report.largest_scale = scales.iter().map(|scale| (scale - 1.0).abs()).fold(0.0, f64::max);
        let scales = &scales;
        self.rows.par_chunks_mut(count.max(1)).enumerate().for_each(|(i, row)| {
            let own = scales[i] / patches.list[i].area;
            row.iter_mut().zip(scales).for_each(|(x, other)| *x = (f64::from(*x) * own * other) as f32);
        });
        let sum = |i: usize| self.row(i).iter().map(|x| f64::from(*x)).sum::<f64>();
        self.report.most_seen = (0..count).map(sum).fold(0.0, f64::max);
    }

    /// Row i.
    pub fn row(&self, i: usize) -> &[f32] {
        &self.rows[i * self.count..(i + 1) * self.count]
    }
}

/// Share of the light that leaves a patch and meets one.
fn row_target(patch: &Patch, occluders: &Reference, seed: u64) -> f64 {
    let (places, mut random) = (Places::new(patch), Random::new(seed));
    let side = ROW_RAYS.isqrt();
    let mut met = 0u32;
    for k in 0..side * side {
        let place = places.point(k, side * side, &mut random);
        let direction = by_cosine(place.normal, k, side, [random.unit_f64(), random.unit_f64()]);
        met += u32::from(occluders.meets_a_patch(place.at, direction));
    }
    f64::from(met) / f64::from(side * side)
}
