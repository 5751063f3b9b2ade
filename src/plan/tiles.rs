//! Light lists of screen tiles: the grid, the lights in the form that culling reads, and the exact sizes of every buffer.
//!
//! Everything that takes more than adding, multiplying and comparing is done here in f64 and rounded outward; the device decides
//! membership by exact arithmetic alone (math/cull.rs).

use glam::DVec3;
use rayon::prelude::*;

use super::gbuffer::depth_terms;
use super::light_parts::Sum;
use super::request::{CullTest, DepthBounds};
use super::{Limits, Request};
use crate::error::{Error, Result};
use crate::math::cull;
use crate::scene::LightKind;
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::{Lens, View};
use crate::shared::{self, BIN_TILES, CULL_TEXELS, LIGHT_CHUNK, LIST_CHUNK, MOST_GROUPS, SCAN_RUN, TileGrid};

use cull_data::cone_texels;
pub(super) use reduction::check_reduction;

/// What the plan decided about tiles.
#[derive(Debug, Clone)]
pub struct Tiles {
    /// Pixels along each side of a tile.
    pub tile: u32,
    /// Which lights a tile takes.
    pub cull: CullTest,
    /// What is known of its depths.
    pub bounds: DepthBounds,
    /// Slots of the 2.5D mask.
    pub slots: u32,
    /// For the device.
    pub grid: TileGrid,
    /// `CULL_TEXELS` a light.
    pub lights: Vec<[f32; 4]>,
    /// `CONE_TEXELS` a light; empty where no light is a spot.
    pub cones: Vec<[f32; 4]>,
    /// Columns + 1, then rows + 1: tangent (or metres), normal across, normal along z, offset.
    pub edges: Vec<[f32; 4]>,
    /// Exact: pairs of bin and light.
    pub bin_pairs: u64,
    /// Entries of the longest bin's list.
    pub longest_bin: u32,
    /// Pairs of tile and light, at most: what rectangles or planes leave without anything known of the depths.
    pub tile_pairs: u64,
    /// Entries of the longest tile's list, at most.
    pub longest_tile: u32,
    /// Lists are read by texel.
    pub words_by_texel: bool,
    /// Metres by which a shaded position may lie outside what its pixel and its stored depth say: interpolation is off by some ulp of the
    /// largest coordinate of its triangle. Radii are wider by as much.
    pub position_slack: f64,
    /// The same for vertices that are snapped to sub-pixels: metres a metre of distance, or metres where the lens is orthographic.
    pub snap_slack: f64,
    /// Lights are culled by texel.
    pub lights_by_texel: bool,
    /// Listed lights are tested for their range before they are shaded. Measured on lavapipe: with boxes and depth bounds most listed
    /// lights reach their samples, and the test costs 3 to 20 % more than it saves.
    pub list_seek: bool,
    /// A group of threads reduces the depths of a tile, else one thread; the bounds are the same.
    pub group_a_tile: bool,
    /// Bounds hold blended surfaces as well: their lists serve both kinds.
    pub merged: bool,
}

/// Relative error of positions, radii and the arithmetic of the tests, relative to the farthest thing that is drawn: 2^-20.
const SPACE_SLACK: f64 = 9.5367431640625e-7;

/// Sub-pixel steps by which a rasteriser may shift what it interpolates; pixels' centres lie half a pixel within their tile besides.
const SNAP_STEPS: f64 = 8.0;

/// Squared distance over squared range stays under 1 in the shader only within this of the range (plan/lights.rs).
const RANGE_SLACK: f64 = 2e-5;

/// Depth slots of tiles up to this many pixels; larger tiles hold more depth, and more slots.
const COARSE_TILE: u32 = 32;

/// Items of a workgroup of scan_sum.comp.
pub(super) const SCAN_GROUP: u64 = 32 * SCAN_RUN as u64;

/// First and last column and row; empty where first passes last.
pub(super) type Span = [u32; 4];

impl Tiles {
    /// Decides grid and lists. No geometry is farther than `extent` metres from the eye.
    ///
    /// # Errors
    /// Lists that pass a limit of the device.
    pub fn new(request: &Request, lighting: &Lighting, view: &View, extent: f64, limits: &Limits) -> Result<Self> {
        let tile = request.tile;
        let mut grid = grid(tile, view);
        let culled: Vec<_> = culled(&lighting.lights).collect();
        grid.first_light = (lighting.lights.len() - culled.len()) as u32;
        grid.light_count = culled.len() as u32;
        grid.light_chunks = grid.light_count.div_ceil(LIGHT_CHUNK).max(1);
        let edges = edges(tile, &grid, view);
        let mut tiles = Self {
            tile,
            cull: request.cull,
            bounds: request.depth_bounds_or_default(),
            slots: if tile > COARSE_TILE { 64 } else { 32 },
            grid,
            lights: Vec::new(),
            cones: Vec::new(),
            edges,
            bin_pairs: 0,
            longest_bin: 0,
            tile_pairs: 0,
            longest_tile: 0,
            words_by_texel: false,
            position_slack: extent * SPACE_SLACK,
            snap_slack: SNAP_STEPS * (-f64::from(limits.sub_pixel_bits)).exp2() * pixel_size(view),
            lights_by_texel: false,
            list_seek: !request.culls_tightly(),
            group_a_tile: reduction::group_a_tile(request, limits),
            merged: false,
        };
        let lights: Vec<_> = culled.par_iter().map(|light| tiles.cull_texels(light, view, extent)).collect();
        tiles.lights = lights.into_flattened();
        if culled.iter().any(|light| matches!(light.kind, LightKind::Spot { .. })) {
            let radii = tiles.lights.chunks_exact(CULL_TEXELS as usize).map(|light| f64::from(light[1][2]));
            tiles.cones =
                culled.iter().zip(radii).flat_map(|(light, radius)| cone_texels(light, view, radius)).collect();
        }
        tiles.count();
        tiles.grid.list_chunks = tiles.longest_bin.div_ceil(LIST_CHUNK).max(1);
        tiles.check_lights(limits)?;
        // Clusters may do without lists of tiles (plan/assign.rs).
        if !request.technique.clusters() {
            tiles.check_lists(limits)?;
        }
        let loops = Sum { lights: tiles.longest_tile, ahead: tiles.grid.first_light, seek: true };
        tiles.list_seek &= loops.fits(limits);
        tiles.words_by_texel = tiles.most_words() <= limits.max_texel_elements;
        tiles.lights_by_texel = tiles.cull_texels_in_all() <= limits.max_texel_elements;
        Ok(tiles)
    }

    /// Tiles.
    pub fn count_tiles(&self) -> u32 {
        self.grid.columns * self.grid.rows
    }

    /// Bins.
    pub fn count_bins(&self) -> u32 {
        self.grid.bin_columns * self.grid.bin_rows
    }

    /// Texels of lights and cones.
    fn cull_texels_in_all(&self) -> u64 {
        (self.lights.len() + self.cones.len()) as u64
    }

    /// Bytes of every buffer and image that lists take.
    pub fn bytes(&self) -> u64 {
        let [of_tiles, of_bins] = self.counts();
        let words = self.bin_pairs + self.tile_pairs + 2 * of_tiles + 2 * of_bins;
        words * 4
            + self.bounds_bytes(self.bounds)
            + (self.lights.len() + self.cones.len() + self.edges.len()) as u64 * 16
    }

    /// Bytes of one more set of lists of these tiles, with such bounds.
    pub(super) fn list_bytes(&self, bounds: DepthBounds) -> u64 {
        let [of_tiles, _] = self.counts();
        (self.tile_pairs + 2 * of_tiles) * 4 + self.bounds_bytes(bounds)
    }

    /// Bytes of the image of bounds.
    pub(super) fn bounds_bytes(&self, bounds: DepthBounds) -> u64 {
        if bounds == DepthBounds::Off { 0 } else { u64::from(self.count_tiles()) * 16 }
    }

    /// Says how far away the farthest surface can be, which stands for the sky behind blended ones.
    pub(super) fn set_farthest(&mut self, distance: f64) {
        let widened = distance + distance.abs() * 1e-5 + self.position_slack;
        self.grid.farthest = up(widened).min(self.grid.far);
    }

    /// Counts that lists are made with: one a tile and run of its bin's list, and one a bin and run of lights.
    fn counts(&self) -> [u64; 2] {
        let of = |cells: u32, runs: u32| u64::from(cells) * u64::from(runs);
        [of(self.count_tiles(), self.grid.list_chunks), of(self.count_bins(), self.grid.light_chunks)]
    }

    /// Words of the longest of lists and offsets.
    fn most_words(&self) -> u64 {
        let [of_tiles, of_bins] = self.counts();
        [self.tile_pairs, self.bin_pairs, of_tiles + 1, of_bins + 1].into_iter().fold(0, u64::max)
    }

    /// Bins and tiles that each light touches, by its rectangle and the planes.
    pub(super) fn spans(&self) -> Vec<[Span; 2]> {
        let of = |light: &[[f32; 4]]| {
            let rectangle = light[2].map(|t| t as u32);
            if is_empty(rectangle) {
                return [rectangle; 2];
            }
            let tiles = match self.cull {
                CullTest::Bounds | CullTest::BoundsTextbook => rectangle,
                _ => planes(light, rectangle, &self.grid, &self.edges),
            };
            [rectangle.map(|t| t / BIN_TILES), tiles]
        };
        self.lights.par_chunks_exact(CULL_TEXELS as usize).map(of).collect()
    }

    /// Sizes of the lists, from the rectangles and the planes alone.
    fn count(&mut self) {
        let [bins_wide, wide] = [self.grid.bin_columns, self.grid.columns].map(|columns| columns as usize + 1);
        let mut of_bins = vec![0; bins_wide * (self.grid.bin_rows as usize + 1)];
        let mut of_tiles = vec![0; wide * (self.grid.rows as usize + 1)];
        for [bins, tiles] in self.spans() {
            self.bin_pairs += add_span(&mut of_bins, bins_wide, bins, 1);
            self.tile_pairs += add_span(&mut of_tiles, wide, tiles, 1);
        }
        self.longest_bin = longest(&mut of_bins, bins_wide);
        self.longest_tile = longest(&mut of_tiles, wide);
    }

    fn check_lights(&self, limits: &Limits) -> Result<()> {
        let (bytes, most) = (self.cull_texels_in_all() * 16, limits.max_storage_bytes.min(limits.max_buffer_bytes));
        if bytes > most {
            let lights = self.grid.light_count;
            return Err(Error::new(format!(
                "{lights} lights to cull need {bytes} bytes, this device binds at most {most} at once"
            )));
        }
        Ok(())
    }

    /// Whether a device can make lists of tiles.
    ///
    /// # Errors
    /// Lists that pass one of its limits.
    pub(super) fn check_lists(&self, limits: &Limits) -> Result<()> {
        let tiles = self.count_tiles();
        let (bytes, most) = (self.most_words() * 4, limits.max_storage_bytes.min(limits.max_buffer_bytes));
        if bytes > most {
            return Err(Error::new(format!(
                "light lists of {tiles} tiles need {bytes} bytes, this device binds at most {most} at once"
            )));
        }
        let scanned = self.counts().map(|count| count.div_ceil(SCAN_GROUP));
        let rows = [self.count_bins(), self.grid.light_chunks].map(u64::from);
        let groups = scanned.into_iter().chain(rows).fold(0, u64::max);
        if groups > u64::from(MOST_GROUPS) {
            return Err(Error::new(format!(
                "light lists of {tiles} tiles need {groups} workgroups in a row, every device takes {MOST_GROUPS}"
            )));
        }
        Ok(())
    }

    /// Refuses lists of tiles as the candidates of clusters: a thread looks at the whole list of its cluster's tile.
    ///
    /// # Errors
    /// Lists that pass a limit, or that are longer than the driver's loops go round.
    pub(super) fn check_candidates(&self, limits: &Limits) -> Result<()> {
        self.check_lists(limits)?;
        let (longest, most) = (self.longest_tile, limits.max_loop_iterations);
        if longest > most {
            return Err(Error::new(format!(
                "a cluster looks at up to {longest} lights of its tile, this driver leaves its loops after {most} iterations"
            )));
        }
        Ok(())
    }
}

/// The larger side of a pixel, on the image plane.
pub(super) fn pixel_size(view: &View) -> f64 {
    let e = view.lens.extents();
    let (w, h) = (f64::from(view.width), f64::from(view.height));
    ((e.right - e.left) / w).abs().max(((e.top - e.bottom) / h).abs())
}

/// Beyond this from its centre (view space) a light's contribution is exactly 0 in the shader, whatever was rounded on the way there.
/// No geometry is farther than `extent` metres from the eye.
pub(super) fn padded_radius(center: DVec3, range: f64, extent: f64) -> f64 {
    let far_away = center.abs().max_element() + range + extent;
    range * (1.0 + RANGE_SLACK) + far_away * SPACE_SLACK
}

/// The smallest f32 that is not below `x`; infinity stays.
fn up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

fn grid(tile: u32, view: &View) -> TileGrid {
    let (columns, rows) = (view.width.div_ceil(tile), view.height.div_ceil(tile));
    let [depth_offset, depth_scale] = depth_terms(view);
    let near = view.znear - (view.znear.abs() * 1e-5).max(1e-30);
    let far = view.zfar.map_or(f64::from(shared::FAR_LIMIT), |far| far + far.abs() * 1e-5);
    TileGrid {
        width: view.width,
        height: view.height,
        columns,
        rows,
        bin_columns: columns.div_ceil(BIN_TILES),
        bin_rows: rows.div_ceil(BIN_TILES),
        perspective: u32::from(view.lens.is_perspective()),
        depth_offset,
        depth_scale,
        depth_slack: shared::DEPTH_SLACK,
        near: near as f32,
        far: up(far).min(shared::FAR_LIMIT),
        farthest: up(far).min(shared::FAR_LIMIT),
        ..TileGrid::default()
    }
}

/// Edges of columns, then of rows. Normals point to growing indices; the last edge is that of the last whole tile, which may lie
/// outside the picture.
fn edges(tile: u32, grid: &TileGrid, view: &View) -> Vec<[f32; 4]> {
    let place = |pixel: u32, along_x: bool| {
        let at = f64::from(pixel) - 0.5;
        let point = view.image_point(if along_x { at } else { 0.0 }, if along_x { 0.0 } else { at });
        if along_x { point.x } else { point.y }
    };
    let edge = |index: u32, along_x: bool| {
        let t = place(index * tile, along_x);
        let sign = if place(tile, along_x) >= place(0, along_x) { 1.0 } else { -1.0 };
        match view.lens {
            Lens::Perspective(_) => {
                let length = t.hypot(1.0);
                [t, sign / length, sign * t / length, 0.0]
            }
            Lens::Orthographic(_) => [t, sign, 0.0, sign * t],
        }
        .map(|x| x as f32)
    };
    let columns = (0..=grid.columns).map(|i| edge(i, true));
    columns.chain((0..=grid.rows).map(|i| edge(i, false))).collect()
}

/// Tiles of the light's bins between whose planes it lies: first and last column and row. The planes of an axis pass a run of
/// neighbours, because each is passed by all tiles on one side of the light.
fn planes(light: &[[f32; 4]], [x0, x1, y0, y1]: Span, grid: &TileGrid, edges: &[[f32; 4]]) -> Span {
    let [x, y, z, _] = light[0];
    let radius = light[1][2];
    let run = |first: u32, last: u32, count: u32, base: u32, across: f32| {
        let (begin, end) = (first / BIN_TILES * BIN_TILES, ((last / BIN_TILES + 1) * BIN_TILES).min(count));
        let passes = |i: u32| {
            let edge = |i: u32| edges[(base + i) as usize];
            cull::edge_distance(edge(i), across, z) >= -radius && cull::edge_distance(edge(i + 1), across, z) <= radius
        };
        let found = || (begin..end).filter(|&i| passes(i));
        (found().next().unwrap_or(1), found().next_back().unwrap_or(0))
    };
    let (x0, x1) = run(x0, x1, grid.columns, 0, x);
    let (y0, y1) = run(y0, y1, grid.rows, grid.columns + 1, y);
    [x0, x1, y0, y1]
}

fn is_empty([x0, x1, y0, y1]: Span) -> bool {
    x0 > x1 || y0 > y1
}

/// Counts a light in each cell of a span, by corners whose sums over both axes are the counts, or with -1 takes it out again; the number of
/// these cells.
pub(super) fn add_span(corners: &mut [i32], wide: usize, span: Span, sign: i32) -> u64 {
    if is_empty(span) {
        return 0;
    }
    let [x0, x1, y0, y1] = span.map(|t| t as usize);
    corners[y0 * wide + x0] += sign;
    corners[y0 * wide + x1 + 1] -= sign;
    corners[(y1 + 1) * wide + x0] -= sign;
    corners[(y1 + 1) * wide + x1 + 1] += sign;
    ((x1 + 1 - x0) * (y1 + 1 - y0)) as u64
}

/// Largest sum over both axes.
pub(super) fn longest(corners: &mut [i32], wide: usize) -> u32 {
    let mut most = 0;
    for at in 0..corners.len() {
        let left = if at % wide > 0 { corners[at - 1] } else { 0 };
        let above = if at >= wide { corners[at - wide] } else { 0 };
        let both = if at % wide > 0 && at >= wide { corners[at - wide - 1] } else { 0 };
        corners[at] += left + above - both;
        most = most.max(corners[at]);
    }
    most.unsigned_abs()
}

/// Lights that are culled: all but directional ones, in table order.
fn culled(lights: &[ResolvedLight]) -> impl Iterator<Item = &ResolvedLight> {
    lights.iter().filter(|l| l.kind != LightKind::Directional)
}

mod cull_data;
mod reduction;
#[cfg(test)]
mod tests;
