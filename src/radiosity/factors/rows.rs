//! Exchanges as they are computed, row by row: how much each pair would exchange were nothing in between, and the share of rays that nothing stops. The
//! more light a pair carries the more rays it has: what a ray too few costs a row is in proportion to that.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Result;
use crate::math::random::Random;
use crate::radiosity::pair::point_kernel;
use crate::radiosity::patches::{Patch, Patches};
use crate::radiosity::places::Places;
use crate::radiosity::sight::{Segment, Sight};

/// Patches nearer than so many times the sum of their radii exchange by their triangles.
const NEAR: f64 = 1.5;
/// Farther than so many times the larger diameter one point of each is enough.
const FAR: f64 = 8.0;
/// Pairs of points between those, at least.
const LEAST_POINTS: u32 = 16;
/// Rays for all the light that leaves a patch, were they shared out by how much of it each pair carries; a pair has at least one.
const RAYS: f64 = 16384.0;
/// Rays of a pair, at most.
const MOST_RAYS: u32 = 256;
/// Rows of a batch for each core, at least.
const ROWS_A_CORE: usize = 4;

/// Exchanges of some patches with all that follow them, before rows are scaled.
#[derive(Debug, Clone, PartialEq)]
pub struct RawRows {
    /// First patch.
    pub first: usize,
    /// Row by row, patches after the row's own; square metres.
    pub exchanges: Vec<Vec<f32>>,
    /// Pairs by their triangles, by points and by one point; rays.
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
        let places: Vec<Places> = patches.list[rows.start..].par_iter().map(Places::new).collect();
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
                (begin..next).into_par_iter().map(|i| PendingRow::new(&places[i - first..], i, seed)).collect();
            let segments: Vec<&[Segment]> = pending.iter().map(|row| row.segments.as_slice()).collect();
            let open = sight.open(&segments)?;
            let done: Vec<Vec<f32>> = pending
                .par_iter()
                .zip(&open)
                .enumerate()
                .map(|(k, (row, open))| {
                    let row = row.finished(&places[begin - first + k..], begin + k, seed, open);
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

/// A pair of patches whose exchange hangs on what lies between them.
struct Pair {
    /// Within its row.
    at: usize,
    /// Square metres, were nothing in between; none: by the triangles of both.
    exchange: Option<f64>,
    /// First of its segments, and how many there are.
    segments: Range<usize>,
}

/// What of a row is known without looking at what stands in the way.
struct PendingRow {
    pairs: Vec<Pair>,
    segments: Vec<Segment>,
    /// Which part of its pair's exchange each segment stands for; they sum to 1 in a pair.
    shares: Vec<f64>,
    counted: [u64; 4],
}

/// A segment, and what it would exchange over areas.
type Weighted = (Segment, f64);

impl PendingRow {
    /// Of patch `i`, the first of `places`, with all others there.
    fn new(places: &[Places], i: usize, seed: u64) -> Self {
        let mut row = Self { pairs: Vec::new(), segments: Vec::new(), shares: Vec::new(), counted: [0; 4] };
        let mut room = Vec::new();
        for at in 0..places.len() - 1 {
            let mut random = random(seed, i, at);
            row.add([&places[0], &places[at + 1]], at, &mut random, &mut room);
        }
        row
    }

    fn add(&mut self, ends: [&Places; 2], at: usize, random: &mut Random, room: &mut Vec<Weighted>) {
        let [a, b] = ends.map(|places| places.patch);
        if !sees(a, b) || !sees(b, a) {
            return;
        }
        let distance = a.center.distance(b.center);
        let areas = a.area * b.area;
        room.clear();
        let exchange = if distance > FAR * 2.0 * a.radius.max(b.radius) {
            self.counted[2] += 1;
            let exchange = point_kernel(a.center, a.normal, b.center, b.normal) * areas;
            if exchange == 0.0 {
                return;
            }
            add_points(ends, rays(exchange, a, b), random, room);
            room.iter_mut().for_each(|point| point.1 = 1.0);
            self.keep(room);
            Some(exchange)
        } else {
            let near = distance < NEAR * (a.radius + b.radius);
            self.counted[usize::from(!near)] += 1;
            // How many points there are hangs on the middles alone: on what points find it must not, or what they find would be low on average.
            let about = point_kernel(a.center, a.normal, b.center, b.normal) * areas;
            add_points(ends, rays(about, a, b).max(LEAST_POINTS), random, room);
            let exchange = room.iter().map(|point| point.1).sum::<f64>() / room.len() as f64 * areas;
            let wanted = rays(exchange, a, b);
            // What would exchange nothing needs no look.
            room.retain(|point| point.1 > 0.0);
            self.keep_some(room, wanted, random);
            (!near).then_some(exchange)
        };
        let first = self.pairs.last().map_or(0, |pair| pair.segments.end);
        if self.segments.len() > first {
            self.counted[3] += (self.segments.len() - first) as u64;
            self.pairs.push(Pair { at, exchange, segments: first..self.segments.len() });
        }
    }

    /// Takes all of a pair's segments.
    fn keep(&mut self, room: &[Weighted]) {
        let all: f64 = room.iter().map(|point| point.1).sum();
        self.segments.extend(room.iter().map(|point| point.0));
        self.shares.extend(room.iter().map(|point| point.1 / all));
    }

    /// Takes `wanted` of them, by how much each would exchange and evenly spread: on average their open share is that of all.
    fn keep_some(&mut self, room: &[Weighted], wanted: u32, random: &mut Random) {
        if room.len() <= wanted as usize {
            return self.keep(room);
        }
        let all: f64 = room.iter().map(|point| point.1).sum();
        let each = all / f64::from(wanted);
        let (mut passed, mut taken) = (0.0, 0u32);
        let offset = random.unit_f64();
        for (segment, weight) in room {
            passed += weight;
            let before = taken;
            while taken < wanted && (f64::from(taken) + offset) * each < passed {
                taken += 1;
            }
            if taken > before {
                self.segments.push(*segment);
                self.shares.push(f64::from(taken - before) / f64::from(wanted));
            }
        }
    }

    /// The row of patch `i`, from whether each segment is open; square metres.
    fn finished(&self, places: &[Places], i: usize, seed: u64, open: &[bool]) -> Vec<f32> {
        let mut row = vec![0f32; places.len() - 1];
        for pair in &self.pairs {
            let run = pair.segments.clone();
            let seen = open[run.clone()].iter().zip(&self.shares[run]).filter(|(open, _)| **open);
            let share: f64 = seen.map(|(_, share)| share).sum();
            if share > 0.0 {
                let exchange = pair
                    .exchange
                    .unwrap_or_else(|| places[0].exchange(&places[pair.at + 1], &mut random(!seed, i, pair.at)));
                row[pair.at] = (exchange * share) as f32;
            }
        }
        row
    }
}

/// A stream for the pair of a patch and the one `at` places behind the next, whoever computes it.
fn random(seed: u64, i: usize, at: usize) -> Random {
    let pair = (i as u64) << 32 | (i + 1 + at) as u64;
    Random::new(seed ^ pair.wrapping_mul(0x9E6C_63D0_876A_46D5))
}

/// Rays of a pair that would exchange so many square metres: by the larger of both form factors.
fn rays(exchange: f64, a: &Patch, b: &Patch) -> u32 {
    ((exchange / a.area.min(b.area) * RAYS).ceil() as u32).clamp(1, MOST_RAYS)
}

/// Pairs of points, from independent strata of both.
fn add_points([a, b]: [&Places; 2], count: u32, random: &mut Random, room: &mut Vec<Weighted>) {
    let offset = (random.unit_f64() * f64::from(count)) as u32;
    for k in 0..count {
        let from = a.point(k, count, random);
        let to = b.point(other_stratum(k, offset, count), count, random);
        let weight = point_kernel(from.at, from.normal, to.at, to.normal);
        room.push((Segment { from: from.at, to: to.at, triangles: [from.triangle, to.triangle] }, weight));
    }
}

/// Stratum of the other patch that stratum `k` of `count` is paired with: all of them have their turn, since nothing divides both the stride and `count`.
fn other_stratum(k: u32, offset: u32, count: u32) -> u32 {
    let stride = [7, 11, 13].into_iter().find(|stride| !count.is_multiple_of(*stride)).unwrap_or(1);
    (k * stride + offset) % count
}

/// Some of the other may lie in front.
fn sees(patch: &Patch, other: &Patch) -> bool {
    if !patch.flat {
        return true;
    }
    let slack = 1e-9 * (patch.radius + other.radius);
    let ahead = (other.center - patch.center).dot(patch.normal);
    // All of it lies within its radius.
    if ahead < -other.radius - slack {
        return false;
    }
    ahead > slack || other.triangles.iter().flatten().any(|p| (*p - patch.center).dot(patch.normal) > slack)
}

#[cfg(test)]
mod tests;
