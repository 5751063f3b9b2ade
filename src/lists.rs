//! Light lists as a device makes them, read back: judged by the f64 oracle, counted, and spread over the picture's pixels.
//!
//! Whatever makes lists, what is left are [`Cells`]: which cell each pixel reads, where each cell's list begins, and ids. Cells are
//! clusters where the technique has them, else tiles; a technique without lists is one cell that lists every light.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::gbuffer;
use crate::graph::checker::Violation;
use crate::measure::picture::Picture;
use crate::passes;
use crate::plan::projection::{self, PixelRect};
use crate::plan::{Clusters, CullTest, DebugView, Gbuffer, Plan, Tiles};
use crate::reference::cluster_keys;
use crate::reference::depth_reduce::TileBounds;
use crate::reference::light_pairs::{NO_CELL, Oracle, PairCounts};
use crate::reference::octahedral;
use crate::renderer::Renderer;
use crate::scene::lighting::ResolvedLight;
use crate::scene::{LightKind, Scene};

pub use cells::Cells;
pub use counters::Counters;

mod cells;
mod counters;
#[cfg(test)]
mod tests;

/// What list making left, and the depths that it was made from.
#[derive(Debug, Clone, Default)]
pub struct Made {
    /// As stored, one value a pixel.
    pub depth: Vec<f32>,
    /// Texels of tile bounds as stored; empty where nothing is known of depths.
    pub bounds: Vec<[u32; 4]>,
    /// The lists.
    pub cells: Cells,
    /// Lists of bins, where tiles are the cells: where each begins, and indices among the culled lights.
    pub bins: [Vec<u32>; 2],
    /// Lists of tiles, where cells are clusters, which choose from them.
    pub candidates: Option<Cells>,
    /// Normals that the clusters were told apart by, one a pixel, view space; empty where they were not.
    pub normals: Vec<DVec3>,
    /// What the checker found in the recorded frames: empty is the proof.
    pub violations: Vec<Violation>,
}

/// Makes the lists of a plan on the device and reads them back.
///
/// # Errors
/// Several samples a pixel, out of memory, a lost device, or a pipeline that the driver refuses.
pub fn make(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Made> {
    if plan.samples > 1 {
        let count = plan.samples;
        return Err(Error::new(format!(
            "--msaa {count}: light lists are read back and judged with one sample a pixel"
        )));
    }
    let frame = passes::cluster_frame(plan).unwrap_or_else(|| passes::list_frame(plan));
    let mut prepared = renderer.prepare_frame(scene, plan, frame)?;
    // The second frame meets what the first one left.
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    Ok(Made { violations, ..read(plan, &picture) })
}

/// What a frame of the plan's lists left.
pub fn read(plan: &Plan, picture: &Picture) -> Made {
    let depth = picture.layer("depth").unwrap_or(&[]).to_vec();
    let candidates = plan.tiles.as_ref().filter(|_| plan.clusters.is_some() && !plan.walks_tree());
    let candidates = candidates.map(|tiles| Cells::of_tiles(tiles, picture, ["tile_offsets", "tile_lights"]));
    let cells = match (&plan.tiles, &plan.clusters) {
        (Some(tiles), Some(clusters)) => Cells::of_clusters(tiles, clusters, picture, &depth),
        (Some(tiles), None) => Cells::of_tiles(tiles, picture, ["list_offsets", "list_lights"]),
        _ => Cells::whole_picture(plan.pixels() as usize, directional(plan)..plan.lights.count),
    };
    let bounds = words(picture, "tile_bounds").chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect();
    let planned = plan.deferred.as_ref().map(|deferred| deferred.gbuffer);
    let decoded = |planned: Gbuffer| {
        let decode = |&code: &_| octahedral::decode(code, planned.normal_bits);
        normal_codes(picture, &planned).iter().map(decode).collect()
    };
    let normals = planned.map_or_else(Vec::new, decoded);
    let mut bins = ["bin_ranges", "bin_lights"].map(|layer| words(picture, layer));
    let listed = bins[0].last().map_or(0, |&end| end as usize);
    bins[1].truncate(listed);
    Made { depth, bounds, cells, bins, candidates, normals, violations: Vec::new() }
}

impl Made {
    /// Judges the lists by the f64 oracle.
    pub fn judge(&self, plan: &Plan) -> PairCounts {
        let lights: Vec<_> = plan.lighting.in_table_order().cloned().collect();
        self.cells.judge(Oracle::new(&lights, &plan.view).facing(self.normals.clone()), &self.depth)
    }

    /// The numbers that a debug view shows, one a pixel and NaN where there is none, and what they are called. `None` for a view of
    /// something else, and for one of tiles or clusters where the plan has none.
    pub fn numbers(&self, view: DebugView, plan: &Plan, counts: &PairCounts) -> Option<(&'static str, Vec<f32>)> {
        if view.of_clusters() && plan.clusters.is_none() {
            return None;
        }
        let at = |numbers: &[u32], pixel: usize| numbers.get(pixel).map_or(f32::NAN, |&n| n as f32);
        Some(match view {
            DebugView::TileMin => ("tile_min", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.near)),
            DebugView::TileMax => ("tile_max", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.far)),
            DebugView::TileMask => {
                ("tile_slots", self.of_tiles(plan.tiles.as_ref()?, |bounds| bounds.mask.count_ones() as f32))
            }
            DebugView::TileLights => ("list_length", self.candidates.as_ref().unwrap_or(&self.cells).list_lengths()),
            DebugView::Clusters => ("cluster", self.of_samples(|pixel| self.cell(pixel))),
            DebugView::ClusterLights => ("cluster_lights", self.cells.list_lengths()),
            DebugView::Slices => ("slice", self.slices(plan.tiles.as_ref()?, plan.clusters.as_ref()?)),
            DebugView::Lights => ("lights", self.of_samples(|pixel| at(&counts.lights_of_sample, pixel))),
            DebugView::Missed => ("missed", self.of_samples(|pixel| at(&counts.missed_of_sample, pixel))),
            DebugView::Waste => {
                let of = |pixel| waste(at(&counts.listed_of_sample, pixel), at(&counts.lights_of_sample, pixel));
                ("waste", self.of_samples(of))
            }
            _ => return None,
        })
    }

    /// A number of each pixel's tile; none in tiles of nothing but sky.
    fn of_tiles(&self, tiles: &Tiles, number: impl Fn(TileBounds) -> f32) -> Vec<f32> {
        let numbers: Vec<f32> = self
            .bounds
            .iter()
            .map(|&words| TileBounds::from_words(words))
            .map(|bounds| if bounds.near <= bounds.far { number(bounds) } else { f32::NAN })
            .collect();
        let of = |pixel| numbers.get(tile_of(tiles, pixel) as usize).copied().unwrap_or(f32::NAN);
        (0..tiles.grid.width * tiles.grid.height).map(of).collect()
    }

    /// The cell of a pixel.
    fn cell(&self, pixel: usize) -> f32 {
        let cell = self.cells.cell_of_sample.get(pixel).filter(|cell| **cell != NO_CELL);
        cell.map_or(f32::NAN, |&cell| cell as f32)
    }

    /// The slice that each pixel's sample lies in.
    fn slices(&self, tiles: &Tiles, clusters: &Clusters) -> Vec<f32> {
        self.of_samples(|pixel| cluster_keys::slice(&tiles.grid, &clusters.grid, self.depth[pixel]) as f32)
    }

    /// A number of each pixel that shows a surface.
    fn of_samples(&self, number: impl Fn(usize) -> f32) -> Vec<f32> {
        let of = |(pixel, depth): (usize, &f32)| if *depth > 0.0 { number(pixel) } else { f32::NAN };
        self.depth.iter().enumerate().map(of).collect()
    }
}

/// Listed over reaching lights: 1 where there is neither, infinite where there are only listed ones.
fn waste(listed: f32, reaching: f32) -> f32 {
    if listed == 0.0 && reaching == 0.0 { 1.0 } else { listed / reaching }
}

/// Lights that stand in no list because they reach everything; their ids come first.
pub fn directional(plan: &Plan) -> u32 {
    plan.lighting.lights.iter().filter(|light| light.kind == LightKind::Directional).count() as u32
}

/// Each light's bounding rectangle in the picture, by the test that the plan's tiles use, else by tangents, and the light's
/// intensity. Lights outside the picture have none.
pub fn rectangles(plan: &Plan) -> Vec<(PixelRect, DVec3)> {
    let textbook = plan.tiles.as_ref().is_some_and(|tiles| tiles.cull == CullTest::BoundsTextbook);
    let rectangle = |light: &ResolvedLight| {
        let center = plan.view.world_to_view.transform_point3(light.position);
        projection::distance_range(center, light.range, &plan.view)?;
        let rect = if textbook {
            projection::textbook_rectangle(center.as_vec3(), light.range as f32, &plan.view)
        } else {
            projection::tangent_rectangle(center, light.range, &plan.view)
        };
        rect.map(|rect| (rect, light.intensity))
    };
    let placed = plan.lighting.lights.iter().filter(|light| light.kind != LightKind::Directional);
    placed.filter_map(rectangle).collect()
}

fn tile_of(tiles: &Tiles, pixel: u32) -> u32 {
    let (x, y) = (pixel % tiles.grid.width, pixel / tiles.grid.width);
    y / tiles.tile * tiles.grid.columns + x / tiles.tile
}

/// Codes of normals of each pixel, where the frame left them.
pub fn normal_codes(picture: &Picture, planned: &Gbuffer) -> Vec<[u32; 2]> {
    if picture.layer(passes::NORMAL_CODES).is_none() {
        return Vec::new();
    }
    let mut codes = gbuffer::codes(&words(picture, passes::NORMAL_CODES), planned);
    // Words hold one pixel or two.
    codes.truncate(picture.width as usize * picture.height as usize);
    codes
}

/// Words that came back as the bits of floats.
fn words(picture: &Picture, layer: &str) -> Vec<u32> {
    picture.layer(layer).unwrap_or(&[]).iter().map(|x| x.to_bits()).collect()
}
