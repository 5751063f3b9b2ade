//! Counters of light lists.

use serde::Serialize;

use super::Cells;
use crate::reference::light_pairs::PairCounts;

/// What lists cost and hold, in numbers. Pairs of light and sample are over the pixels that show a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Counters {
    /// Entries of all lists.
    pub light_pairs: u64,
    /// Pairs in which the light reaches the sample, in f64.
    pub exact_pairs: u64,
    /// Exact pairs whose light is not in the list of the sample's cell.
    pub missed_pairs: u64,
    /// Listed over reached pairs of light and cell, over the cells that own a sample; infinite where nothing is reached.
    pub waste_cells: f64,
    /// Listed over exact pairs of light and sample; infinite where nothing is reached.
    pub waste_samples: f64,
    /// Directional lights and the list's length, summed over samples.
    pub light_evaluations: u64,
    /// Lists that end beyond what was allocated for them.
    pub lists_overflowed: u64,
    /// Entries of the longest list.
    pub longest_list: u32,
}

impl Counters {
    /// Counters of lists that were judged; every sample adds `directional` lights beside its list.
    pub fn new(cells: &Cells, counts: &PairCounts, directional: u32) -> Self {
        Self {
            light_pairs: cells.light_pairs(),
            exact_pairs: counts.exact_pairs,
            missed_pairs: counts.missed_pairs,
            waste_cells: counts.waste_cells(),
            waste_samples: counts.waste_samples(),
            light_evaluations: counts.samples * u64::from(directional) + counts.listed_pairs,
            lists_overflowed: cells.overflowed(),
            longest_list: cells.longest_list(),
        }
    }
}
