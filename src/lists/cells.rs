//! Cells: tiles, clusters, or the whole picture.

use std::ops::Range;

use super::{tile_of, words};
use crate::measure::picture::Picture;
use crate::plan::{Clusters, Tiles};
use crate::reference::cluster_keys;
use crate::reference::light_pairs::{Lists, NO_CELL, Oracle, PairCounts};

/// Lists of cells, and which cell each pixel reads.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells {
    /// Cell of each pixel, row-major.
    pub cell_of_sample: Vec<u32>,
    /// cells + 1 offsets into `lights`.
    pub offsets: Vec<u32>,
    /// Light ids, ascending within each cell.
    pub lights: Vec<u32>,
    /// Ids that there was room for.
    pub capacity: usize,
}

impl Cells {
    /// One cell that every pixel reads: what a technique without lists loops over.
    pub fn whole_picture(pixels: usize, lights: Range<u32>) -> Self {
        let lights: Vec<u32> = lights.collect();
        let offsets = vec![0, lights.len() as u32];
        Self { cell_of_sample: vec![0; pixels], offsets, capacity: lights.len(), lights }
    }

    /// A cell a tile, from what was read back as offsets and as lights.
    pub(super) fn of_tiles(tiles: &Tiles, picture: &Picture, [offsets, lights]: [&str; 2]) -> Self {
        // A tile has an offset for each run of its bin; its list begins at the first.
        let runs = tiles.grid.list_chunks.max(1) as usize;
        let offsets = words(picture, offsets).into_iter().step_by(runs).collect();
        let pixels = tiles.grid.width * tiles.grid.height;
        Self::new((0..pixels).map(|pixel| tile_of(tiles, pixel)).collect(), offsets, words(picture, lights))
    }

    /// A cell a cluster; none where nothing was drawn. Where every slice of every tile is one, the depth of a sample says which.
    pub(super) fn of_clusters(tiles: &Tiles, clusters: &Clusters, picture: &Picture, depth: &[f32]) -> Self {
        let total = words(picture, "cluster_total").first().copied().unwrap_or(clusters.grid.capacity);
        let mut offsets = words(picture, "list_offsets");
        offsets.truncate(total as usize + 1);
        let dense = |(pixel, &depth): (u32, &f32)| {
            if !cluster_keys::shows_surface(depth) {
                return NO_CELL;
            }
            tile_of(tiles, pixel) * clusters.grid.slices + cluster_keys::slice(&tiles.grid, &clusters.grid, depth)
        };
        let cell_of_sample =
            if clusters.keyed { words(picture, "cluster_index") } else { (0..).zip(depth).map(dense).collect() };
        Self::new(cell_of_sample, offsets, words(picture, "list_lights"))
    }

    /// `lights` as the device has them: all that there is room for.
    fn new(cell_of_sample: Vec<u32>, offsets: Vec<u32>, mut lights: Vec<u32>) -> Self {
        let capacity = lights.len();
        lights.truncate(offsets.last().map_or(0, |&end| end as usize));
        Self { cell_of_sample, offsets, lights, capacity }
    }

    /// Entries of each cell's list.
    fn lengths(&self) -> impl Iterator<Item = u32> {
        self.offsets.windows(2).map(|ends| ends[1].saturating_sub(ends[0]))
    }

    /// Pairs of cell and light.
    pub fn light_pairs(&self) -> u64 {
        self.lengths().map(u64::from).sum()
    }

    /// Entries of the longest list.
    pub fn longest_list(&self) -> u32 {
        self.lengths().max().unwrap_or(0)
    }

    /// Lists that end beyond what was allocated for them.
    pub fn overflowed(&self) -> u64 {
        self.offsets.iter().skip(1).filter(|&&end| end as usize > self.capacity).count() as u64
    }

    /// Judges the lists by the f64 oracle; `depth` as stored, one value a pixel of the oracle's view.
    pub fn judge(&self, oracle: Oracle, depth: &[f32]) -> PairCounts {
        let lists = Lists { cell_of_sample: &self.cell_of_sample, offsets: &self.offsets, lights: &self.lights };
        oracle.count(depth, &lists)
    }

    /// Entries of the list that each pixel reads; NaN where it reads none.
    pub fn list_lengths(&self) -> Vec<f32> {
        let lengths: Vec<u32> = self.lengths().collect();
        let of = |&cell: &u32| lengths.get(cell as usize).map_or(f32::NAN, |&length| length as f32);
        self.cell_of_sample.iter().map(of).collect()
    }
}
