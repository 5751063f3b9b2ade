//! CPU twin of cluster keys: `glsl/inc/cluster_slice.glsl`, `glsl/cluster/cluster_keys.comp` and the steps up to the cluster of each
//! sample, to the bit.

use crate::shared::{ClusterGrid, NO_CLUSTER, PROBE_DEPTHS, TileGrid};

/// The slice of a stored depth.
pub fn slice(grid: &TileGrid, clusters: &ClusterGrid, depth: f32) -> u32 {
    let last = clusters.slices - 1;
    if grid.perspective != 0 {
        let s = depth.max(0.0) + grid.depth_scale;
        let bits = s.to_bits().min(clusters.slice_top);
        return ((clusters.slice_top - bits) >> clusters.slice_shift).min(last);
    }
    ((1.0 - depth) * clusters.slice_scale).clamp(0.0, last as f32) as u32
}

/// Direction of a normal by its code in the G-buffer: the cell of the octahedron's square that it lies in.
pub fn direction(clusters: &ClusterGrid, code: [u32; 2]) -> u32 {
    let [x, y] = code.map(|code| code >> clusters.direction_shift);
    y << (clusters.direction_bits >> 1) | x
}

/// Tile, then slice, then direction, from the highest bits down.
pub fn key(grid: &TileGrid, clusters: &ClusterGrid, tile: u32, depth: f32, direction: u32) -> u32 {
    tile << clusters.slice_bits | slice(grid, clusters, depth) << clusters.direction_bits | direction
}

/// Something was drawn there; 0 is the sky.
pub fn shows_surface(depth: f32) -> bool {
    (1..=f32::INFINITY.to_bits()).contains(&depth.to_bits())
}

/// A block: its tile, and the pixels from its first corner up to its last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Row-major.
    pub tile: u32,
    /// First column and row.
    pub begin: [u32; 2],
    /// Behind the last column and row.
    pub end: [u32; 2],
}

impl Block {
    /// Block `index`; empty where it lies outside of the picture.
    pub fn new(grid: &TileGrid, clusters: &ClusterGrid, index: u32) -> Self {
        let parts = clusters.tile_parts;
        let (tile, part) = (index / (parts * parts), index % (parts * parts));
        let at = [tile % grid.columns * parts + part % parts, tile / grid.columns * parts + part / parts];
        let size = [grid.width, grid.height];
        let begin = [0, 1].map(|axis: usize| (at[axis] * clusters.block).min(size[axis]));
        let end = [0, 1].map(|axis: usize| (begin[axis] + clusters.block).min(size[axis]));
        Self { tile, begin, end }
    }

    /// Column and row of each of its pixels.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        (self.begin[1]..self.end[1]).flat_map(move |y| (self.begin[0]..self.end[0]).map(move |x| [x, y]))
    }
}

/// Clusters that own samples, in the order of their keys.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Keys {
    /// How many keys each block has.
    pub block_counts: Vec<u32>,
    /// Of each cluster.
    pub keys: Vec<u32>,
    /// Cluster of each sample, row-major; `NO_CLUSTER` for the sky.
    pub index: Vec<u32>,
}

/// Keys of every sample, those of all blocks merged. `codes` are those of each sample's normal, where clusters tell directions.
pub fn run(grid: &TileGrid, clusters: &ClusterGrid, depth: &[f32], codes: Option<&[[u32; 2]]>) -> Keys {
    let mut found = Keys { index: vec![NO_CLUSTER; depth.len()], ..Keys::default() };
    let mut key_of = vec![None; depth.len()];
    for index in 0..clusters.block_count {
        let block = Block::new(grid, clusters, index);
        let mut own = Vec::new();
        for [x, y] in block.pixels() {
            let pixel = (y * grid.width + x) as usize;
            if shows_surface(depth[pixel]) {
                let direction = codes.map_or(0, |codes| direction(clusters, codes[pixel]));
                let key = key(grid, clusters, block.tile, depth[pixel], direction);
                key_of[pixel] = Some(key);
                own.push(key);
            }
        }
        own.sort_unstable();
        own.dedup();
        found.block_counts.push(own.len() as u32);
        found.keys.extend(own);
    }
    found.keys.sort_unstable();
    found.keys.dedup();
    for (id, key) in found.index.iter_mut().zip(key_of) {
        let place = key.map(|key| found.keys.partition_point(|&other| other < key));
        *id = place.map_or(NO_CLUSTER, |place| place as u32);
    }
    found
}

/// Depth `index` of those that a check asks for: twin of `glsl/cluster/slice_probe.comp`. `step` is the reversed depth between the
/// boundaries of linear slices.
pub fn probe_depth(grid: &TileGrid, clusters: &ClusterGrid, step: f32, index: u32) -> f32 {
    let (slice, place) = (index / PROBE_DEPTHS, index % PROBE_DEPTHS);
    if slice == clusters.slices {
        return f32::from_bits(((place >> 1) * 0x7f_8000) | ((place & 1) << 31));
    }
    let boundary = if grid.perspective != 0 {
        f32::from_bits(clusters.slice_top - (slice << clusters.slice_shift)) - grid.depth_scale
    } else {
        1.0 - slice as f32 * step
    };
    let bits = boundary.max(0.0).to_bits() + place;
    f32::from_bits(bits - bits.min(PROBE_DEPTHS / 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids() -> (TileGrid, ClusterGrid) {
        let grid = TileGrid { width: 20, height: 9, columns: 2, rows: 1, perspective: 1, ..TileGrid::default() };
        let clusters = ClusterGrid {
            slices: 40,
            slice_top: 1f32.to_bits(),
            slice_shift: 21,
            slice_bits: 6,
            block: 16,
            tile_parts: 1,
            block_count: 2,
            ..ClusterGrid::default()
        };
        (grid, clusters)
    }

    #[test]
    fn four_slices_an_octave() {
        let (grid, clusters) = grids();
        let slices = [1.0, 0.9, 0.876, 0.875, 0.5, 0.25, 1e-30].map(|depth| slice(&grid, &clusters, depth));
        assert_eq!(slices, [0, 0, 0, 1, 4, 8, 39]);
        let odd = [2.0, f32::INFINITY, -1.0, 0.0, -0.0].map(|depth| slice(&grid, &clusters, depth));
        assert_eq!(odd, [0, 0, 39, 39, 39]);
        let linear = ClusterGrid { slice_scale: 8.0, slices: 8, ..clusters };
        let flat = TileGrid { perspective: 0, ..grid };
        let slices = [1.5, 1.0, 0.876, 0.875, 0.0, -1.0].map(|depth| slice(&flat, &linear, depth));
        assert_eq!(slices, [0, 0, 0, 1, 7, 7]);
    }

    #[test]
    fn clusters_of_two_tiles() {
        let (grid, clusters) = grids();
        let mut depth = vec![0.0; 180];
        (depth[0], depth[1], depth[16], depth[179]) = (0.5, 0.9, 0.5, 0.5);
        let found = run(&grid, &clusters, &depth, None);
        assert_eq!(found.block_counts, [2, 1]);
        assert_eq!(found.keys, [0, 4, 1 << 6 | 4]);
        assert_eq!((found.index[0], found.index[1], found.index[16], found.index[179]), (1, 0, 2, 2));
        assert_eq!(found.index.iter().filter(|&&id| id == NO_CLUSTER).count(), 176);
    }

    #[test]
    fn samples_that_point_elsewhere_have_other_clusters() {
        let (grid, clusters) = grids();
        let clusters = ClusterGrid { slice_bits: 12, direction_bits: 6, direction_shift: 5, ..clusters };
        let mut depth = vec![0.0; 180];
        (depth[0], depth[1], depth[2]) = (0.5, 0.5, 0.5);
        let mut codes = vec![[0, 0]; 180];
        (codes[0], codes[1], codes[2]) = ([254, 127], [0, 255], [224, 96]);
        let found = run(&grid, &clusters, &depth, Some(&codes));
        assert_eq!(found.keys, [4 << 6 | (3 * 8 + 7), 4 << 6 | (7 * 8)]);
        assert_eq!(found.index[..3], [0, 1, 0]);
    }

    #[test]
    fn parts_of_a_tile_follow_each_other() {
        let grid = TileGrid { width: 70, height: 40, columns: 3, rows: 2, ..TileGrid::default() };
        let clusters = ClusterGrid { block: 16, tile_parts: 2, block_count: 24, ..ClusterGrid::default() };
        assert_eq!(Block::new(&grid, &clusters, 5), Block { tile: 1, begin: [48, 0], end: [64, 16] });
        assert_eq!(Block::new(&grid, &clusters, 9), Block { tile: 2, begin: [70, 0], end: [70, 16] });
        let mut seen = vec![0; 70 * 40];
        for index in 0..24 {
            Block::new(&grid, &clusters, index).pixels().for_each(|[x, y]| seen[(y * 70 + x) as usize] += 1);
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}
