//! Slices of the view: how many there are, and what each spans in metres.

use super::{DISTANCE_MARGIN, MOST_SLICES, Request, Tiles};
use crate::scene::view::View;
use crate::shared::{ClusterGrid, FAR_LIMIT, TileGrid};

/// Ways to slice the view, finest first, each twice as deep as the one before it; the last has one slice.
pub(super) fn slicings(request: &Request, tiles: &Tiles, view: &View, extent: f64) -> Vec<ClusterGrid> {
    let e = view.lens.extents();
    let farthest = extent.min(view.zfar.unwrap_or(f64::INFINITY)).max(view.znear);
    // Metres, or tangent.
    let wide = (e.top - e.bottom).abs() * f64::from(tiles.tile) / f64::from(view.height);
    let mut found: Vec<_> = if view.lens.is_perspective() {
        // In each doubling of distance, which then grows by a factor of about 1 + `wide` from slice to slice.
        let octave = std::f64::consts::LN_2 / wide.ln_1p();
        exponential(&tiles.grid, request.slices_per_octave.map_or(octave, f64::from), farthest)
    } else {
        linear(&tiles.grid, wide, farthest - view.znear)
    };
    found.retain(|grid| grid.slices <= MOST_SLICES);
    let coarsest = found.iter().position(|grid| grid.slices == 1);
    found.truncate(coarsest.map_or(found.len(), |last| last + 1));
    found
}

/// `octave` slices, to the nearest power of two, in each doubling of distance.
fn exponential(grid: &TileGrid, octave: f64, farthest: f64) -> Vec<ClusterGrid> {
    let finest = 23 - octave.log2().round().clamp(0.0, 20.0) as u32;
    let slice_top = (1.0 + grid.depth_scale).to_bits();
    let last = (f64::from(grid.depth_offset) / farthest) as f32;
    let span = slice_top - last.max(f32::MIN_POSITIVE).to_bits().min(slice_top);
    let of = |slice_shift: u32| ClusterGrid {
        slices: (span >> slice_shift) + 1,
        slice_top,
        slice_shift,
        ..ClusterGrid::default()
    };
    (finest..u32::BITS).map(of).collect()
}

/// Slices of `wide` metres over `depth` metres.
fn linear(grid: &TileGrid, wide: f64, depth: f64) -> Vec<ClusterGrid> {
    let finest = wide.max(depth / f64::from(MOST_SLICES));
    let of = |doublings: u32| {
        let each = finest * f64::from(1u32 << doublings);
        let slices = (depth / each).ceil().clamp(1.0, f64::from(MOST_SLICES)) as u32;
        let scale = if slices > 1 { (f64::from(grid.depth_scale) / each) as f32 } else { 0.0 };
        ClusterGrid { slices, slice_scale: scale.min(FAR_LIMIT), ..ClusterGrid::default() }
    };
    (0..10).map(of).collect()
}

/// Nearest and farthest distance of each slice.
pub(super) fn slice_table(grid: &TileGrid, clusters: &ClusterGrid) -> Vec<[f32; 4]> {
    let last = clusters.slices - 1;
    let of = |slice: u32| {
        let [near, far] = match grid.perspective {
            0 => linear_slice(grid, clusters, slice),
            _ => exponential_slice(grid, clusters, slice),
        };
        let far = if slice == last { f64::from(FAR_LIMIT) } else { far };
        [(near as f32).next_down(), (far as f32).next_up().min(FAR_LIMIT), 0.0, 0.0]
    };
    (0..=last).map(of).collect()
}

/// As `cull::distance_range` at both ends of a slice, with its error added. What lies in a slice has at most the depth of its first end,
/// so it is no nearer, even where nothing is known of how far it is.
fn exponential_slice(grid: &TileGrid, clusters: &ClusterGrid, slice: u32) -> [f64; 2] {
    let at = |bits: u32| {
        let inverse = 1.0 / f64::from(f32::from_bits(bits)).max(1e-37);
        (f64::from(grid.depth_offset) * inverse, f64::from(grid.depth_slack) * inverse)
    };
    let first = slice << clusters.slice_shift;
    let (d, e) = at(clusters.slice_top - first);
    let near = d - d * e - (d + d * e) * DISTANCE_MARGIN;
    // The last slice, whose end may lie below 0, is unbounded.
    let (d, e) = at(clusters.slice_top.saturating_sub(first + ((1 << clusters.slice_shift) - 1)));
    let known = e * (1.0 + DISTANCE_MARGIN) < 0.5;
    [near, if known { (d + 2.0 * d * e) * (1.0 + DISTANCE_MARGIN) } else { f64::from(FAR_LIMIT) }]
}

/// The same for linear slices: an ulp of 1 is what rounding may take from the reversed depth, and each distance is off by less than
/// 2^-20 of the largest.
fn linear_slice(grid: &TileGrid, clusters: &ClusterGrid, slice: u32) -> [f64; 2] {
    let [offset, scale, slack] = [grid.depth_offset, grid.depth_scale, grid.depth_slack].map(f64::from);
    let each = if clusters.slice_scale > 0.0 { scale / f64::from(clusters.slice_scale) } else { scale };
    let near = offset - scale + each * f64::from(slice);
    let margin = scale * (slack + f64::from(f32::EPSILON)) + (offset.abs() + scale) * DISTANCE_MARGIN;
    [near - margin, near + each + margin]
}
