//! Form factors between all patches: near ones by the closed form, others by points, times the share of rays between them that nothing stops.
//!
//! What is computed is the exchange `A_i F_ij = A_j F_ji`, once for each pair. Afterwards rows are scaled symmetrically (each by a factor of its own,
//! to both sides) so that each sums to the share of light that meets any patch, which rays from the patch itself tell; the report says by how much.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::pair::{self, Facet, point_kernel};
use super::patches::{Patch, Patches, by_cosine};
use super::sight::{NO_TRIANGLE, Segment, Sight};
use crate::error::{Error, Result};
use crate::math::random::Random;
use crate::reference::render::Reference;

/// Patches nearer than so many times the sum of their radii exchange by the closed form.
const NEAR: f64 = 1.5;
/// Farther than so many times the larger diameter one point of each is enough.
const FAR: f64 = 8.0;
/// Pairs of points between those, and rays of a near pair.
const SAMPLES: u32 = 16;
/// Rays of a far pair.
const FAR_RAYS: u32 = 4;
/// Rays from each patch that tell what its row sums to.
const ROW_RAYS: u32 = 256;
/// Rows of a batch for each core, at least.
const ROWS_A_CORE: usize = 4;
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
    /// Pairs by the closed form, by points and by one point.
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

/// Exchanges of some patches with all that follow them, before rows are scaled.
#[derive(Debug, Clone, PartialEq)]
pub struct RawRows {
    /// First patch.
    pub first: usize,
    /// Row by row, patches after the row's own; square metres.
    pub exchanges: Vec<Vec<f32>>,
    /// Pairs by the closed form, by points and by one point; rays.
    pub counted: [u64; 4],
}

impl RawRows {
    /// Rows `first` to `end` on all cores: the same numbers however rows are grouped, and whoever looks. `progress` is told of each row that is done.
    ///
    /// # Errors
    /// Those of the one who looks.
    pub fn new(
        patches: &Patches,
        sight: &dyn Sight,
        seed: u64,
        rows: Range<usize>,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Self> {
        let first = rows.start;
        let (mut exchanges, mut counted) = (Vec::with_capacity(rows.len()), [0u64; 4]);
        let mut next = rows.start;
        while next < rows.end {
            // As many rows as a batch holds.
            let (begin, mut pairs) = (next, 0);
            let all_cores = begin + ROWS_A_CORE * rayon::current_num_threads();
            while next < rows.end && (next < all_cores || pairs + patches.list.len() - next <= sight.batch_pairs()) {
                pairs += patches.list.len() - next;
                next += 1;
            }
            let pending: Vec<PendingRow> =
                (begin..next).into_par_iter().map(|i| PendingRow::new(patches, i, seed)).collect();
            let segments: Vec<&[Segment]> = pending.iter().map(|row| row.segments.as_slice()).collect();
            let open = sight.open(&segments)?;
            let done: Vec<Vec<f32>> = pending
                .par_iter()
                .zip(&open)
                .enumerate()
                .map(|(k, (row, open))| {
                    let row = row.finished(patches, begin + k, open);
                    progress();
                    row
                })
                .collect();
            pending.iter().for_each(|row| (0..4).for_each(|k| counted[k] += row.counted[k]));
            exchanges.extend(done);
        }
        Ok(Self { first, exchanges, counted })
    }
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

/// A pair of patches whose exchange hangs on what lies between them.
struct Pair {
    /// Within its row.
    at: usize,
    kind: PairKind,
    /// First of its segments, and how many there are.
    segments: Range<usize>,
}

enum PairKind {
    /// By the closed form, as much as the open share of so much.
    Near(f64),
    /// By points: as much as their weights add up to, times that.
    Between(f64),
    /// That much for each segment.
    Far(f64),
}

/// What of a row is known without looking at what stands in the way.
struct PendingRow {
    pairs: Vec<Pair>,
    segments: Vec<Segment>,
    /// What each segment adds, where nothing stops it.
    weights: Vec<f64>,
    counted: [u64; 4],
}

impl PendingRow {
    fn new(patches: &Patches, i: usize, seed: u64) -> Self {
        let mut row = Self { pairs: Vec::new(), segments: Vec::new(), weights: Vec::new(), counted: [0; 4] };
        for j in (i + 1)..patches.list.len() {
            let pair = (i as u64) << 32 | j as u64;
            let mut random = Random::new(seed ^ pair.wrapping_mul(0x9E6C_63D0_876A_46D5));
            row.add(&patches.list[i], &patches.list[j], j - i - 1, &mut random);
        }
        row
    }

    fn add(&mut self, a: &Patch, b: &Patch, at: usize, random: &mut Random) {
        if !sees(a, b) || !sees(b, a) {
            return;
        }
        let distance = a.center.distance(b.center);
        let first = self.segments.len();
        let (kind, samples) = if distance > FAR * 2.0 * a.radius.max(b.radius) {
            self.counted[2] += 1;
            let geometry = point_kernel(a.center, a.normal, b.center, b.normal);
            if geometry == 0.0 {
                return;
            }
            (PairKind::Far(geometry * a.area * b.area / f64::from(FAR_RAYS)), FAR_RAYS)
        } else if distance < NEAR * (a.radius + b.radius) {
            self.counted[0] += 1;
            (PairKind::Near(0.0), SAMPLES)
        } else {
            self.counted[1] += 1;
            (PairKind::Between(a.area * b.area / f64::from(SAMPLES)), SAMPLES)
        };
        let far = matches!(kind, PairKind::Far(_));
        let mut all = 0.0;
        for k in 0..samples {
            let (from, own) = place_on(a, k, samples, random);
            let (to, other) = place_on(b, (k * 7 + 3) % samples, samples, random);
            let weight = if far { 1.0 } else { point_kernel(from, a.looks(own), to, b.looks(other)) };
            // What would exchange nothing needs no look.
            if weight > 0.0 {
                all += weight;
                self.weights.push(weight);
                self.segments.push(Segment { from, to, triangles: [a.source(own), b.source(other)] });
            }
        }
        self.counted[3] += (self.segments.len() - first) as u64;
        if self.segments.len() > first {
            let kind = if matches!(kind, PairKind::Near(_)) { PairKind::Near(all) } else { kind };
            self.pairs.push(Pair { at, kind, segments: first..self.segments.len() });
        }
    }

    /// The row, from whether each segment is open; square metres.
    fn finished(&self, patches: &Patches, i: usize, open: &[bool]) -> Vec<f32> {
        let mut row = vec![0f32; patches.list.len() - i - 1];
        for pair in &self.pairs {
            let run = pair.segments.clone();
            let seen = || open[run.clone()].iter().zip(&self.weights[run.clone()]).filter(|(open, _)| **open);
            let sum: f64 = seen().map(|(_, weight)| weight).sum();
            if sum == 0.0 {
                continue;
            }
            row[pair.at] = match pair.kind {
                PairKind::Far(each) => sum * each,
                PairKind::Between(scale) => sum * scale,
                PairKind::Near(all) => exact(&patches.list[i], &patches.list[i + 1 + pair.at]) * sum / all,
            } as f32;
        }
        row
    }
}

/// Square metres: light that leaves one patch and meets the other, were nothing in between.
fn exact(a: &Patch, b: &Patch) -> f64 {
    let facets = |patch: &Patch| -> Vec<Facet> { patch.triangles.iter().map(Facet::new).collect() };
    let others = facets(b);
    facets(a).iter().flat_map(|t| others.iter().map(|u| pair::exchange(t, u))).sum()
}

impl Patch {
    /// Which way one of its triangles looks.
    fn looks(&self, triangle: usize) -> DVec3 {
        let of = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero();
        self.triangles.get(triangle).map_or(self.normal, of)
    }

    /// The scene's triangle that one of its own is a piece of.
    fn source(&self, triangle: usize) -> u32 {
        self.sources.get(triangle).copied().unwrap_or(NO_TRIANGLE)
    }
}

/// Some of the other may lie in front.
fn sees(patch: &Patch, other: &Patch) -> bool {
    if !patch.flat {
        return true;
    }
    let slack = 1e-9 * (patch.radius + other.radius);
    other.triangles.iter().flatten().any(|p| (*p - patch.center).dot(patch.normal) > slack)
}

/// A point of a patch and the normal there: stratum k of n by area, anywhere in the triangle that it falls on.
pub(super) fn point_on(patch: &Patch, k: u32, n: u32, random: &mut Random) -> [DVec3; 2] {
    let (at, triangle) = place_on(patch, k, n, random);
    [at, patch.looks(triangle)]
}

/// The same with the patch's triangle that it is on.
fn place_on(patch: &Patch, k: u32, n: u32, random: &mut Random) -> (DVec3, usize) {
    let mut left = (f64::from(k) + random.unit_f64()) / f64::from(n) * patch.area;
    let area = |t: &[DVec3; 3]| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).length();
    let chosen = patch.triangles.iter().position(|t| {
        left -= area(t);
        left < 0.0
    });
    let chosen = chosen.unwrap_or(patch.triangles.len().saturating_sub(1));
    let [a, b, c] = patch.triangles.get(chosen).copied().unwrap_or([patch.center; 3]);
    let (root, across) = (random.unit_f64().sqrt(), random.unit_f64());
    (a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across), chosen)
}

/// Share of the light that leaves a patch and meets one.
fn row_target(patch: &Patch, occluders: &Reference, seed: u64) -> f64 {
    let mut random = Random::new(seed);
    let side = ROW_RAYS.isqrt();
    let mut met = 0u32;
    for k in 0..side * side {
        let [at, normal] = point_on(patch, k, side * side, &mut random);
        let direction = by_cosine(normal, k, side, [random.unit_f64(), random.unit_f64()]);
        met += u32::from(occluders.meets_a_patch(at, direction));
    }
    f64::from(met) / f64::from(side * side)
}
