//! CPU twin of light assignment to clusters: `glsl/inc/cluster_assign.glsl` and its steps, to the bit.

use super::cluster_index::ClusterBox;
use super::tile_cull::Lists;
use crate::math::cull;
use crate::shared::{CONE_TEXELS, CULL_TEXELS, ClusterGrid, TileGrid};

/// What the device is given.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// Tiles.
    pub grid: &'a TileGrid,
    /// Slices.
    pub clusters: &'a ClusterGrid,
    /// Nearest and farthest distance of each slice.
    pub slices: &'a [[f32; 4]],
    /// `CULL_TEXELS` a light.
    pub lights: &'a [[f32; 4]],
    /// `CONE_TEXELS` a light; empty where no light is a spot.
    pub cones: &'a [[f32; 4]],
    /// Columns + 1, then rows + 1.
    pub edges: &'a [[f32; 4]],
    /// Candidates: the list of each tile.
    pub tile_lists: &'a Lists,
    /// Of each cluster; `None` where every slice of every tile is one.
    pub keys: Option<&'a [u32]>,
    /// Of each cluster's samples; `None` where tile and slice bound it.
    pub boxes: Option<&'a [ClusterBox]>,
    /// Least and greatest normal of each direction; `None` where clusters tell none.
    pub directions: Option<&'a [[f32; 4]]>,
}

/// Light ids by cluster.
pub fn run(inputs: &Inputs) -> Lists {
    let (grid, clusters) = (inputs.grid, inputs.clusters);
    let dense: Vec<u32>;
    let places: &[u32] = match inputs.keys {
        Some(keys) => keys,
        None => {
            let slices = (0..grid.columns * grid.rows).flat_map(|tile| (0..clusters.slices).map(move |s| (tile, s)));
            dense = slices.map(|(tile, slice)| tile << clusters.slice_bits | slice).collect();
            &dense
        }
    };
    let mut lists = Lists { offsets: vec![0], lights: Vec::new() };
    for (id, key) in places.iter().enumerate() {
        let tile = key >> clusters.slice_bits;
        let cell = Cell::new(inputs, id, tile, key - (tile << clusters.slice_bits));
        let candidates = inputs.tile_lists.of(tile as usize).iter();
        lists.lights.extend(candidates.filter(|&&light| cell.touches(inputs, light - grid.first_light)));
        lists.offsets.push(lists.lights.len() as u32);
    }
    lists
}

/// What is known of a cluster: distances, and its box or the tangents of its tile's edges.
struct Cell {
    near: f32,
    far: f32,
    across: [f32; 2],
    up: [f32; 2],
    /// Least and greatest of each coordinate of its normals.
    normals: Option<[[f32; 4]; 2]>,
}

impl Cell {
    fn new(inputs: &Inputs, id: usize, tile: u32, low: u32) -> Self {
        let (columns, bits) = (inputs.grid.columns, inputs.clusters.direction_bits);
        let (slice, direction) = (low >> bits, (low - (low >> bits << bits)) as usize);
        let normals = inputs.directions.map(|table| [table[2 * direction], table[2 * direction + 1]]);
        let [near, far, ..] = inputs.slices[slice as usize];
        if let Some(found) = inputs.boxes.and_then(|boxes| boxes.get(id)) {
            let (near, far) = (near.max(found.distance[0]), far.min(found.distance[1]));
            return Self { near, far, across: found.across, up: found.up, normals };
        }
        let tangents = |at: u32| [at, at + 1].map(|edge| inputs.edges[edge as usize][0]);
        Self { near, far, across: tangents(tile % columns), up: tangents(columns + 1 + tile / columns), normals }
    }

    fn touches(&self, inputs: &Inputs, light: u32) -> bool {
        let texel = |i: u32| inputs.lights[(light * CULL_TEXELS + i) as usize];
        let ([cx, cy, cz, radius2], [light_near, light_far, _, slack]) = (texel(0), texel(1));
        let (near, far) = (self.near.max(light_near), self.far.min(light_far));
        let bounded = |[first, last]: [f32; 2]| match inputs.boxes {
            Some(_) => [first, last],
            None => cull::edge_interval(inputs.grid, first, last, near, far),
        };
        let ([x0, x1], [y0, y1]) = (bounded(self.across), bounded(self.up));
        let dx = cull::interval_distance(x0, x1, cx);
        let dy = cull::interval_distance(y0, y1, cy);
        let dz = cull::interval_distance(near, far, -cz);
        let inside = near <= far && (dx * dx + dy * dy) + dz * dz <= radius2;
        let cone = inputs.cones.chunks_exact(CONE_TEXELS as usize).nth(light as usize);
        let reached = |cone| cull::cone_reaches(cone, [cx, cy, cz], [[x0, x1], [y0, y1], [near, far]]);
        let inside = inside && cone.is_none_or(reached);
        let boxed = [[x0, x1], [y0, y1], [-far, -near]];
        inside && self.normals.is_none_or(|normals| most_facing(normals, boxed, [cx, cy, cz]) >= -slack)
    }
}

/// The most that a normal and the direction to the light from a point of the box can have in common, metres.
fn most_facing([low, high]: [[f32; 4]; 2], boxed: [[f32; 2]; 3], light: [f32; 3]) -> f32 {
    let of = |axis: usize| {
        let [a, b] = [light[axis] - boxed[axis][1], light[axis] - boxed[axis][0]];
        let (n, m) = (low[axis], high[axis]);
        (n * a).max(n * b).max((m * a).max(m * b))
    };
    (of(0) + of(1)) + of(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One tile of a parallel view, 2 m wide about the axis, in three slices of 1 m; lights of radius 0.4 m in the middle of the first
    /// and on the boundary of the second and third.
    #[test]
    fn lights_fall_into_the_slices_that_they_reach() {
        let grid = TileGrid { columns: 1, rows: 1, first_light: 1, ..TileGrid::default() };
        let clusters = ClusterGrid { slices: 3, slice_bits: 2, ..ClusterGrid::default() };
        let slices = [0.0, 1.0, 2.0].map(|near: f32| [near, near + 1.0, 0.0, 0.0]);
        let light = |z: f32| [[0.0, 0.0, z, 0.16], [-z - 0.4, -z + 0.4, 0.4, 0.0], [0.0; 4]];
        let lights = [light(-0.5), light(-2.0)].concat();
        let edges = [-1.0, 1.0, 1.0, -1.0].map(|t: f32| [t, 0.0, 0.0, 0.0]);
        let tile_lists = Lists { offsets: vec![0, 2], lights: vec![1, 2] };
        let inputs = Inputs {
            grid: &grid,
            clusters: &clusters,
            slices: &slices,
            lights: &lights,
            cones: &[],
            edges: &edges,
            tile_lists: &tile_lists,
            keys: None,
            boxes: None,
            directions: None,
        };
        assert_eq!(run(&inputs), Lists { offsets: vec![0, 1, 2, 3], lights: vec![1, 2, 2] });
        let far_off = ClusterBox { distance: [1.7, 2.2], across: [0.5, 0.9], up: [-0.1, 0.1] };
        let beside = ClusterBox { across: [0.3, 0.9], ..far_off };
        let boxes = [far_off, beside];
        let keyed = Inputs { keys: Some(&[1, 2]), boxes: Some(&boxes), ..inputs };
        assert_eq!(run(&keyed), Lists { offsets: vec![0, 0, 1], lights: vec![2] });
        // Faces that point to the eye and away from it, seen by a light in front of both.
        let told = ClusterGrid { slice_bits: 3, direction_bits: 1, ..clusters };
        let normal = |z: f32| [[-0.1, -0.1, z - 0.05, 0.0], [0.1, 0.1, z + 0.05, 0.0]];
        let directions = [normal(1.0), normal(-1.0)].concat();
        let behind = ClusterBox { distance: [1.2, 1.25], across: [-0.1, 0.1], up: [-0.1, 0.1] };
        let near = [light(-0.9), light(-2.0)].concat();
        let faced = Inputs {
            clusters: &told,
            lights: &near,
            keys: Some(&[1 << 1, 1 << 1 | 1]),
            boxes: Some(&[behind, behind]),
            directions: Some(&directions),
            ..inputs
        };
        assert_eq!(run(&faced), Lists { offsets: vec![0, 1, 1], lights: vec![1] });
    }
}
