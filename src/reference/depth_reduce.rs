//! CPU twin of depth reduction: `glsl/tile/depth_reduce.comp`, to the bit.

use crate::math::cull;
use crate::shared::{FAR_LIMIT, TileGrid};

/// What culling knows of a tile: two distances in metres and the mask of slots between them that hold samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileBounds {
    /// Nearest; beyond `far` where nothing but sky is seen.
    pub near: f32,
    /// Farthest.
    pub far: f32,
    /// Bit s: slot s holds a sample.
    pub mask: u64,
}

impl TileBounds {
    /// A tile of nothing but sky.
    pub const SKY: Self = Self { near: FAR_LIMIT, far: 0.0, mask: 0 };

    /// The texel that the device stores.
    pub fn words(&self) -> [u32; 4] {
        [self.near.to_bits(), self.far.to_bits(), self.mask as u32, (self.mask >> 32) as u32]
    }

    /// From a texel that the device stored.
    pub fn from_words(words: [u32; 4]) -> Self {
        Self {
            near: f32::from_bits(words[0]),
            far: f32::from_bits(words[1]),
            mask: u64::from(words[2]) | u64::from(words[3]) << 32,
        }
    }

    /// Slots of its mask a metre.
    pub fn slots_a_metre(&self, slots: u32) -> f32 {
        cull::slots_a_metre(self.near, self.far, slots)
    }
}

/// Bounds of every tile of `tile` pixels, row-major; `slots` of the mask, or `None` for a mask of ones.
pub fn run(grid: &TileGrid, tile: u32, slots: Option<u32>, depth: &[f32]) -> Vec<TileBounds> {
    let opaque: Vec<[u32; 2]> = depth.iter().map(|&depth| [solid_bits(depth); 2]).collect();
    of_tiles(grid, tile, slots, &opaque)
}

/// The same of blended fragments: of each pixel from the nearest one, `blended`, to the opaque sample behind it, `depth`. With `merged`
/// opaque samples count as well.
pub fn run_blended(
    grid: &TileGrid,
    tile: u32,
    slots: Option<u32>,
    [blended, depth]: [&[f32]; 2],
    merged: bool,
) -> Vec<TileBounds> {
    let of = |(&blended, &depth): (&f32, &f32)| {
        let [blended, depth] = [blended, depth].map(solid_bits);
        [if merged { blended.max(depth) } else { blended }, depth]
    };
    let stretches: Vec<[u32; 2]> = blended.iter().zip(depth).map(of).collect();
    of_tiles(grid, tile, slots, &stretches)
}

/// Bits of a depth, as integers in the order of positive floats; 0 where nothing was drawn.
fn solid_bits(depth: f32) -> u32 {
    let bits = depth.to_bits();
    if (1..=f32::INFINITY.to_bits()).contains(&bits) { bits } else { 0 }
}

/// `pixels` are bits of the nearest and farthest depth: the first 0 where nothing counts, the second where the sky is behind.
fn of_tiles(grid: &TileGrid, tile: u32, slots: Option<u32>, pixels: &[[u32; 2]]) -> Vec<TileBounds> {
    let tiles = (0..grid.rows).flat_map(|y| (0..grid.columns).map(move |x| [x, y]));
    tiles.map(|at| of_tile(grid, at.map(|t| t * tile), tile, slots, pixels)).collect()
}

fn of_tile(grid: &TileGrid, [x0, y0]: [u32; 2], tile: u32, slots: Option<u32>, depths: &[[u32; 2]]) -> TileBounds {
    let (x1, y1) = ((x0 + tile).min(grid.width), (y0 + tile).min(grid.height));
    let pixels = || (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (y * grid.width + x) as usize));
    let bits = || pixels().map(|p| depths[p]).filter(|bits| bits[0] != 0);
    let nearest = bits().map(|bits| bits[0]).max();
    let (Some(nearest), Some(farthest)) = (nearest, bits().map(|bits| bits[1]).min()) else { return TileBounds::SKY };
    let begin = |bits: u32| cull::distance_range(grid, f32::from_bits(bits))[0];
    let end = |bits: u32| if bits == 0 { grid.farthest } else { cull::distance_range(grid, f32::from_bits(bits))[1] };
    let (near, far) = (begin(nearest), end(farthest));
    let mut bounds = TileBounds { near, far, mask: u64::MAX };
    if let Some(slots) = slots {
        let scale = bounds.slots_a_metre(slots);
        bounds.mask = bits().fold(0, |mask, [nearest, farthest]| {
            let [first, last] = [begin(nearest), end(farthest)].map(|d| cull::depth_slot(near, scale, d, slots));
            mask | cull::slot_mask(first, last)
        });
    }
    bounds
}
