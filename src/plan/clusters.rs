//! Clusters: screen tiles cut along the view axis into slices about as deep as the tile is wide (O. Olsson, M. Billeter, U. Assarsson,
//! "Clustered Deferred and Forward Shading", HPG 2012), and a bound for every buffer that they take.
//!
//! A perspective lens stores near / distance, whose bits are a piecewise linear log2: a slice is 2^shift of them, and integers find it
//! (inc/cluster_slice.glsl). What it spans in metres is computed here in f64 and rounded outward.
//!
//! How many clusters hold samples only the device knows, so buffers are sized for the most that there can be: a tile has at most as many
//! clusters as slices and as samples, and a light reaches only the slices within its distances. Where that passes a limit the slices are
//! taken twice as deep until it does not.

use super::assign::{self, TreeSource};
use super::{ClusterBounds, CullTest, Limits, Request, Tiles};
use crate::error::{Error, Result};
use crate::math::cull;
use crate::scene::view::View;
use crate::shared::{
    BIN_TILES, BOX_WORDS, CELL_TEXELS, CELLS_WIDE, CULL_TEXELS, ClusterGrid, NORMAL_CELL_TEXELS, NORMAL_CELLS_WIDE,
    TileGrid,
};

pub(super) use options::{asked, check_normals};
use slices::{slice_table, slicings};

/// What the plan decided about clusters.
#[derive(Debug, Clone)]
pub struct Clusters {
    /// For the device.
    pub grid: ClusterGrid,
    /// Nearest and farthest distance of each slice, metres: between them lie the distances of every depth that it holds.
    pub slices: Vec<[f32; 4]>,
    /// Least and greatest normal of each direction that clusters tell, two texels each; empty where they tell none.
    pub directions: Vec<[f32; 4]>,
    /// What bounds a cluster.
    pub bounds: ClusterBounds,
    /// Clusters are made of the samples that a pre-pass leaves; else every slice of every tile is one.
    pub keyed: bool,
    /// They are those that samples or fragments flag: the place of each among them is looked up by its slice, not by pixel.
    pub flagged: bool,
    /// Tiles have several blocks, whose keys are sorted and merged; else keys ascend from the start.
    pub merged: bool,
    /// Bits of a key.
    pub key_bits: u32,
    /// Pairs of cluster and light, at most.
    pub pairs: u64,
    /// Entries of the longest list, at most.
    pub longest_list: u32,
    /// Lists are read by texel.
    pub words_by_texel: bool,
    /// Candidates come from the light hierarchy; else from lists of tiles.
    pub tree: Option<TreeSource>,
    /// Why these slices, whether keys are sorted, and where candidates come from.
    pub why: String,
}

/// Pixels along each side of a block: a thread walks through at most 256 samples.
const BLOCK: u32 = 16;

/// Most slices: a key holds one in 9 bits.
const MOST_SLICES: u32 = 512;

/// Relative error of `cull::distance_range` against f64 is less: 2^-21 of the reciprocal, in the distance and once more in its slack,
/// `DISTANCE_SLACK` 2^-20, and a few roundings of 2^-24.
const DISTANCE_MARGIN: f64 = 1.0 / 262_144.0;

/// What the clusters of a light can be: its tiles, at most, and its distances.
struct Reach {
    tiles: u64,
    near: f32,
    far: f32,
}

impl Clusters {
    /// Decides slices and sizes over `tiles`. No geometry is farther than `extent` metres from the eye.
    ///
    /// # Errors
    /// Clusters that pass a limit of the device with one slice too; slices an octave of a lens that has none.
    pub fn new(request: &Request, tiles: &Tiles, view: &View, extent: f64, limits: &Limits) -> Result<Self> {
        let reaches = reaches(tiles);
        if request.slices_per_octave.is_some() && !view.lens.is_perspective() {
            return Err(Error::usage(
                "--slices-per-octave is for perspective lenses: an orthographic one has equal slices",
            ));
        }
        let mut refused = None;
        // Fewer directions first, then fewer slices with all directions again. Without a sample there are none.
        let directions: &[u32] = if request.cluster_normals && request.prepass { &directions::BITS } else { &[0] };
        let sliced = slicings(request, tiles, view, extent).into_iter();
        let several = request.msaa > 1;
        for sliced in
            sliced.flat_map(|grid| directions.iter().map(move |&direction_bits| ClusterGrid { direction_bits, ..grid }))
        {
            let mut clusters = Self::sized(request, tiles, view, &reaches, sliced);
            if several && clusters.keyed {
                // Several samples of a pixel may lie in several clusters.
                clusters = clusters.flagged_ones(tiles, true);
            }
            let source = clusters.check(tiles, limits).and_then(|()| {
                clusters.longest_list = longest::longest_list(tiles, &clusters.slices, limits);
                assign::source(request, tiles, &clusters, limits)
            });
            match source {
                Ok((tree, why)) => {
                    clusters.tree = tree;
                    if clusters.grid.direction_bits > 0 {
                        clusters.directions = directions::table(request.normal_bits, clusters.grid.direction_bits);
                    }
                    clusters.words_by_texel = clusters.most_list_words() <= limits.max_texel_elements;
                    clusters.why = format!("{}; {why}", clusters.explain(refused.is_some()));
                    return Ok(clusters);
                }
                Err(error) => refused = Some(error),
            }
        }
        Err(refused.unwrap_or_else(|| Error::new("no number of slices can be met")))
    }

    /// Everything that follows from the slices.
    fn sized(request: &Request, tiles: &Tiles, view: &View, reaches: &[Reach], sliced: ClusterGrid) -> Self {
        let (tile, keyed) = (tiles.tile, request.prepass);
        let e = view.lens.extents();
        let block = tile.min(BLOCK);
        let parts = tile / block;
        let (direction_bits, normal_bits) = (sliced.direction_bits, request.normal_bits);
        let most = sliced.slices << direction_bits;
        let most_keys = |side: u32| most.min(side * side);
        let room = |side: u32| room(&tiles.grid, side, most);
        let dense = u64::from(tiles.count_tiles()) * u64::from(sliced.slices);
        let grid = ClusterGrid {
            slice_bits: bits(sliced.slices) + direction_bits,
            direction_shift: directions::shift(normal_bits, direction_bits),
            block,
            tile_parts: parts,
            block_count: tiles.count_tiles() * parts * parts,
            block_keys: most_keys(block),
            entry_capacity: saturated(room(block)),
            capacity: saturated(if keyed { room(tile) } else { dense }),
            pixel_x: pixel_axis(e.left, e.right, view.width),
            pixel_y: pixel_axis(e.top, e.bottom, view.height),
            ..sliced
        };
        let slices = slice_table(&tiles.grid, &grid);
        let in_tile = if keyed { most_keys(tile) } else { grid.slices };
        Self {
            pairs: pairs(reaches, &slices, direction_bits, in_tile),
            directions: Vec::new(),
            key_bits: bits(tiles.count_tiles()) + grid.slice_bits,
            bounds: request.cluster_bounds_or_default(),
            flagged: false,
            merged: keyed && parts > 1,
            longest_list: 0,
            words_by_texel: false,
            tree: None,
            why: String::new(),
            grid,
            slices,
            keyed,
        }
    }

    /// Bytes of every buffer and image that clusters take beside those of tiles.
    pub fn bytes(&self) -> u64 {
        let [blocks, entries, clusters] =
            [self.grid.block_count, self.grid.entry_capacity, self.grid.capacity].map(u64::from);
        // Cells, counts and offsets.
        let assigned = clusters * (4 * u64::from(self.cells()[1]) + 2) + self.pairs;
        let keys = blocks * (u64::from(self.grid.block_keys) + 2) + clusters;
        if self.flagged {
            // Flags, their offsets, keys and places.
            return 4 * (assigned + 4 * clusters)
                + self.slices.len() as u64 * 16
                + self.tree.as_ref().map_or(0, TreeSource::bytes);
        }
        let boxes = if self.bounds == ClusterBounds::Explicit { entries * u64::from(BOX_WORDS) } else { 0 };
        // Keys with origins, sorted; two buffers of pairs; heads and their offsets; clusters of entries.
        let sorted = if self.merged { entries * 11 + boxes } else { entries };
        let keyed = if self.keyed { keys + boxes + sorted } else { 0 };
        let tree = self.tree.as_ref().map_or(0, TreeSource::bytes);
        4 * (assigned + keyed) + (self.slices.len() + self.direction_texels()) as u64 * 16 + tree
    }

    /// Clusters in a row of the image that assignment reads, and texels of each.
    pub fn cells(&self) -> [u32; 2] {
        if self.by_normal() { [NORMAL_CELLS_WIDE, NORMAL_CELL_TEXELS] } else { [CELLS_WIDE, CELL_TEXELS] }
    }

    /// Directions of normals that clusters tell; 1 where they tell none.
    pub fn count_directions(&self) -> u32 {
        1 << self.grid.direction_bits
    }

    fn direction_texels(&self) -> usize {
        if self.by_normal() { 2 * self.count_directions() as usize } else { 0 }
    }

    /// Clusters tell directions of normals: those that are made of samples, which flags are not.
    pub fn by_normal(&self) -> bool {
        self.grid.direction_bits > 0 && self.keyed && !self.flagged
    }

    /// Clusters of blended surfaces in the same slices: those that fragments flag, or every slice of every tile.
    ///
    /// # Errors
    /// Clusters that pass a limit of the device.
    pub(super) fn for_blended(&self, tiles: &Tiles, flagged: bool, limits: &Limits) -> Result<Self> {
        let mut clusters = self.flagged_ones(tiles, flagged);
        clusters.check(tiles, limits)?;
        clusters.tree = self.tree.as_ref().map(|_| TreeSource::new(tiles, &clusters, limits)).transpose()?;
        clusters.words_by_texel = clusters.most_list_words() <= limits.max_texel_elements;
        Ok(clusters)
    }

    /// The same slices with clusters that are flagged, or with all of them.
    fn flagged_ones(&self, tiles: &Tiles, flagged: bool) -> Self {
        let dense = u64::from(tiles.count_tiles()) * u64::from(self.grid.slices);
        Self {
            grid: ClusterGrid { capacity: saturated(dense), entry_capacity: 0, ..self.grid },
            directions: Vec::new(),
            bounds: ClusterBounds::Implicit,
            keyed: flagged,
            flagged,
            merged: false,
            pairs: pairs(&reaches(tiles), &self.slices, 0, self.grid.slices),
            ..self.clone()
        }
    }

    /// What slices span, and after it what directions do: a texel each, and two.
    pub fn slice_texels(&self) -> Vec<[f32; 4]> {
        self.slices.iter().chain(&self.directions).copied().collect()
    }

    /// Words of the longer of lists and offsets.
    fn most_list_words(&self) -> u64 {
        self.pairs.max(u64::from(self.grid.capacity) + 1)
    }

    fn check(&self, tiles: &Tiles, limits: &Limits) -> Result<()> {
        let grid = &self.grid;
        let (width, height, slices) = (tiles.grid.width, tiles.grid.height, grid.slices);
        let told = if self.by_normal() {
            format!(" of {} directions of normals (--cluster-normals)", self.count_directions())
        } else {
            String::new()
        };
        let named = format!("clusters of {0}x{0} pixels in {slices} slices{told} across {width}x{height}", tiles.tile);
        if self.keyed && self.key_bits > u32::BITS {
            return Err(Error::new(format!("{named} need keys of {} bits, a key has 32", self.key_bits)));
        }
        let keys = u64::from(grid.block_count) * u64::from(grid.block_keys);
        let boxes = u64::from(grid.entry_capacity) * u64::from(BOX_WORDS);
        let keyed = if self.keyed { keys.max(boxes) } else { 0 };
        let bytes = keyed.max(self.most_list_words()) * 4;
        let most = limits.max_storage_bytes.min(limits.max_buffer_bytes);
        if bytes > most {
            return Err(Error::new(format!("{named} need {bytes} bytes, this device binds at most {most} at once")));
        }
        let side = limits.max_image_dimension;
        let [wide, texels] = self.cells();
        if wide * texels > side || grid.capacity.div_ceil(wide) > side {
            let room = u64::from(side) * u64::from(wide);
            return Err(Error::new(format!("{named} may be {}, this device's images hold {room}", grid.capacity)));
        }
        Ok(())
    }

    fn explain(&self, coarser: bool) -> String {
        let slices = self.grid.slices;
        let octave = f64::from(23 - self.grid.slice_shift as i32).exp2();
        let depth = if self.grid.slice_top == 0 { "linear".to_string() } else { format!("{octave} an octave") };
        let fewer = if coarser { ", as many as this device's buffers hold lists for" } else { "" };
        let keys = match (self.keyed, self.merged) {
            _ if self.flagged => "samples flag their clusters",
            (false, _) => "every slice of every tile is a cluster",
            (true, false) => "a tile is one block and keys ascend: no sort",
            (true, true) => "a tile has several blocks: keys are sorted and merged",
        };
        let directions = self.count_directions();
        let told =
            if self.by_normal() { format!(" of {directions} directions of normals each") } else { String::new() };
        format!("{slices} slices, {depth}{told}{fewer}; {keys}")
    }
}

/// Bits that tell `count` things apart.
fn bits(count: u32) -> u32 {
    u32::BITS - count.saturating_sub(1).leading_zeros()
}

fn saturated(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// Clusters that squares of `side` pixels may have together: in each at most one a slice and one a sample.
fn room(grid: &TileGrid, side: u32, slices: u32) -> u64 {
    let parts = |pixels: u32| [(pixels / side, side), (1, pixels % side)];
    let squares = parts(grid.width).into_iter().flat_map(|x| parts(grid.height).map(|y| (x, y)));
    let most = |samples: u64| samples.min(u64::from(slices));
    squares.map(|((m, w), (n, h))| u64::from(m) * u64::from(n) * most(u64::from(w) * u64::from(h))).sum()
}

/// Edge of pixel 0 and step from edge to edge, and what rounding may take from an edge: half an ulp of each of the two, of their product
/// and of the sum, less than 2^-22 of either.
fn pixel_axis(first: f64, last: f64, pixels: u32) -> [f32; 3] {
    let slack = (first.abs() + (last - first).abs()) / 2_097_152.0;
    [first as f32, ((last - first) / f64::from(pixels)) as f32, (slack as f32).next_up()]
}

/// Tiles whose lists can hold each light, and its distances; lights that no tile sees are left out.
fn reaches(tiles: &Tiles) -> Vec<Reach> {
    let (columns, rows) = tiles.edges.split_at(tiles.grid.columns as usize + 1);
    let by_rectangle = matches!(tiles.cull, CullTest::Bounds | CullTest::BoundsTextbook);
    let across = |edges: &[[f32; 4]], first: f32, last: f32, [x, z, radius]: [f32; 3]| {
        if first > last {
            return 0;
        }
        if by_rectangle {
            return (last - first) as u64 + 1;
        }
        // Planes are asked for the tiles of the light's bins.
        let bin = |tile: f32| (tile as u32 / BIN_TILES * BIN_TILES) as usize;
        let end = (bin(last) + BIN_TILES as usize).min(edges.len() - 1);
        let passes =
            |e: &&[[f32; 4]]| cull::edge_distance(e[0], x, z) >= -radius && cull::edge_distance(e[1], x, z) <= radius;
        edges[bin(first)..=end].windows(2).filter(passes).count() as u64
    };
    let of = |light: &[[f32; 4]]| {
        let ([x, y, z, _], [near, far, radius, _], [x0, x1, y0, y1]) = (light[0], light[1], light[2]);
        let tiles = across(columns, x0, x1, [x, z, radius]) * across(rows, y0, y1, [y, z, radius]);
        Reach { tiles, near, far }
    };
    let all = tiles.lights.chunks_exact(CULL_TEXELS as usize).map(of);
    all.filter(|reach| reach.tiles > 0 && reach.near <= reach.far).collect()
}

/// Pairs of cluster and light, at most, where a tile has at most `in_tile` clusters.
fn pairs(reaches: &[Reach], slices: &[[f32; 4]], direction_bits: u32, in_tile: u32) -> u64 {
    let sorted = |end: usize| {
        let mut ends: Vec<f32> = slices.iter().map(|slice| slice[end]).collect();
        ends.sort_unstable_by(f32::total_cmp);
        ends
    };
    let (nears, fars) = (sorted(0), sorted(1));
    let of = |reach: &Reach| {
        // Slices that begin before the light ends, less those that end before it begins.
        let begun = nears.partition_point(|&near| near <= reach.far);
        let ended = fars.partition_point(|&far| far < reach.near);
        reach.tiles * ((begun.saturating_sub(ended) as u64) << direction_bits).min(u64::from(in_tile))
    };
    reaches.iter().map(of).sum()
}

mod directions;
mod longest;
mod options;
mod slices;
#[cfg(test)]
mod tests;
