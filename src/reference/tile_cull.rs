//! CPU twin of binning and tile culling: `glsl/inc/tile_cull.glsl` and its steps, to the bit.

use super::depth_reduce::TileBounds;
use crate::math::cull;
use crate::shared::{self, BIN_TILES, CONE_TEXELS, CULL_TEXELS, TileGrid};

/// What the device is given.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// Grid.
    pub grid: &'a TileGrid,
    /// `CULL_TEXELS` a light.
    pub lights: &'a [[f32; 4]],
    /// `CONE_TEXELS` a light; empty where no light is a spot.
    pub cones: &'a [[f32; 4]],
    /// Columns + 1, then rows + 1.
    pub edges: &'a [[f32; 4]],
    /// Value of CULL.
    pub cull: u32,
    /// Value of DEPTH_BOUNDS.
    pub depth_bounds: u32,
    /// Value of DEPTH_SLOTS.
    pub slots: u32,
    /// Of every tile; empty where nothing is known.
    pub bounds: &'a [TileBounds],
}

/// Lists of cells: cell c owns `lights[offsets[c]..offsets[c + 1]]`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lists {
    /// One more than cells.
    pub offsets: Vec<u32>,
    /// In order within a cell.
    pub lights: Vec<u32>,
}

impl Lists {
    /// List of one cell.
    pub fn of(&self, cell: usize) -> &[u32] {
        &self.lights[self.offsets[cell] as usize..self.offsets[cell + 1] as usize]
    }

    fn push(&mut self, list: impl Iterator<Item = u32>) {
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.lights.extend(list);
        self.offsets.push(self.lights.len() as u32);
    }
}

/// Culled lights by bin.
pub fn bins(inputs: &Inputs) -> Lists {
    let grid = inputs.grid;
    let mut lists = Lists { offsets: vec![0], lights: Vec::new() };
    for y in 0..grid.bin_rows {
        for x in 0..grid.bin_columns {
            lists.push((0..grid.light_count).filter(|&light| in_bin(inputs, [x, y], light)));
        }
    }
    lists
}

fn in_bin(inputs: &Inputs, bin: [u32; 2], light: u32) -> bool {
    let [x0, x1, y0, y1] = inputs.lights[(light * CULL_TEXELS + 2) as usize];
    let [left, top] = bin.map(|b| (b * BIN_TILES) as f32);
    let across = (BIN_TILES - 1) as f32;
    x0 <= left + across && x1 >= left && y0 <= top + across && y1 >= top && x0 <= x1 && y0 <= y1
}

/// Light ids by tile.
pub fn run(inputs: &Inputs) -> Lists {
    let (grid, bins) = (inputs.grid, bins(inputs));
    let mut lists = Lists { offsets: vec![0], lights: Vec::new() };
    for y in 0..grid.rows {
        for x in 0..grid.columns {
            let bin = bins.of((y / BIN_TILES * grid.bin_columns + x / BIN_TILES) as usize);
            let reaching = bin.iter().filter(|&&light| intersects(inputs, [x, y], light));
            lists.push(reaching.map(|&light| grid.first_light + light));
        }
    }
    lists
}

fn intersects(inputs: &Inputs, [x, y]: [u32; 2], light: u32) -> bool {
    let grid = inputs.grid;
    let texel = |i: u32| inputs.lights[(light * CULL_TEXELS + i) as usize];
    let ([cx, cy, cz, radius2], [light_near, light_far, radius, _]) = (texel(0), texel(1));
    let tile = match inputs.depth_bounds {
        shared::BOUNDS_OFF => TileBounds { near: grid.near, far: grid.far, mask: u64::MAX },
        _ => inputs.bounds[(y * grid.columns + x) as usize],
    };
    let (mut near, mut far) = (tile.near.max(light_near), tile.far.min(light_far));
    let mut inside = near <= far;
    if inputs.depth_bounds == shared::BOUNDS_MASK {
        let scale = tile.slots_a_metre(inputs.slots);
        let first = cull::depth_slot(tile.near, scale, near, inputs.slots);
        let last = cull::depth_slot(tile.near, scale, far, inputs.slots);
        // Where first passes last there is no common depth either.
        let slots = if first <= last { cull::slot_mask(first, last) & tile.mask } else { 0 };
        inside = inside && slots != 0;
        if slots != 0 {
            let (first, last) = (slots.trailing_zeros(), 63 - slots.leading_zeros());
            let [begin, end] = cull::slot_distances([tile.near, tile.far], inputs.slots, first, last);
            (near, far) = (near.max(begin), far.min(end));
        }
    }
    if inputs.cull == shared::CULL_RECTANGLE {
        let ([x0, x1, y0, y1], [x, y]) = (texel(2), [x as f32, y as f32]);
        return inside && x0 <= x && x <= x1 && y0 <= y && y <= y1;
    }
    let edge = |index: u32| inputs.edges[index as usize];
    let (left, right) = (edge(x), edge(x + 1));
    let (top, bottom) = (edge(grid.columns + 1 + y), edge(grid.columns + 2 + y));
    inside = inside
        && cull::edge_distance(left, cx, cz) >= -radius
        && cull::edge_distance(right, cx, cz) <= radius
        && cull::edge_distance(top, cy, cz) >= -radius
        && cull::edge_distance(bottom, cy, cz) <= radius;
    if inputs.cull == shared::CULL_PLANES_BOX {
        let [x0, x1] = cull::edge_interval(grid, left[0], right[0], near, far);
        let [y0, y1] = cull::edge_interval(grid, top[0], bottom[0], near, far);
        let dx = cull::interval_distance(x0, x1, cx);
        let dy = cull::interval_distance(y0, y1, cy);
        let dz = cull::interval_distance(near, far, -cz);
        inside = inside && (dx * dx + dy * dy) + dz * dz <= radius2;
        if let Some(cone) = inputs.cones.chunks_exact(CONE_TEXELS as usize).nth(light as usize) {
            inside = inside && cull::cone_reaches(cone, [cx, cy, cz], [[x0, x1], [y0, y1], [near, far]]);
        }
    }
    inside
}
