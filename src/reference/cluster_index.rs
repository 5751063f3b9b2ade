//! CPU twin of cluster bounds: the boxes that `glsl/cluster/cluster_index.comp` makes of each cluster's samples, to the bit.

use super::cluster_keys::shows_surface;
use crate::math::cull;
use crate::shared::{BOX_WORDS, ClusterGrid, NO_CLUSTER, TileGrid, Vec3};

/// Low and high distance along the view axis, across and up, metres in view space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClusterBox {
    /// Distance.
    pub distance: [f32; 2],
    /// Along x.
    pub across: [f32; 2],
    /// Along y.
    pub up: [f32; 2],
}

impl ClusterBox {
    /// Of no sample.
    const NOTHING: Self = Self { distance: [3e38, -3e38], across: [3e38, -3e38], up: [3e38, -3e38] };

    /// The words that the device stores. The sign of a 0 depends on the order of samples, and is left out.
    pub fn words(&self) -> [u32; BOX_WORDS as usize] {
        let [[a, b], [c, d], [e, f]] = [self.distance, self.across, self.up];
        [a, b, c, d, e, f].map(|x| if x == 0.0 { 0 } else { x.to_bits() })
    }

    fn grow(&mut self, other: &Self) {
        let both = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.distance = both(self.distance, other.distance);
        self.across = both(self.across, other.across);
        self.up = both(self.up, other.up);
    }
}

/// Both edges of a pixel on the image plane, widened by what rounding may have taken from them.
fn pixel_edges([base, step, slack]: Vec3, pixel: u32) -> [f32; 2] {
    let [first, last] = [pixel, pixel + 1].map(|at| at as f32 * step + base);
    [first.min(last) - slack, first.max(last) + slack]
}

/// What a pixel covers at its stored depth.
pub fn of_sample(grid: &TileGrid, clusters: &ClusterGrid, [x, y]: [u32; 2], depth: f32) -> ClusterBox {
    let [near, far] = cull::distance_range(grid, depth);
    let near = near.max(grid.near);
    let [[left, right], [low, high]] = [pixel_edges(clusters.pixel_x, x), pixel_edges(clusters.pixel_y, y)];
    ClusterBox {
        distance: [near, far],
        across: cull::edge_interval(grid, left, right, near, far),
        up: cull::edge_interval(grid, low, high, near, far),
    }
}

/// The box of each of `count` clusters; `index` names the cluster of each sample.
pub fn run(grid: &TileGrid, clusters: &ClusterGrid, depth: &[f32], index: &[u32], count: usize) -> Vec<ClusterBox> {
    let mut boxes = vec![ClusterBox::NOTHING; count];
    for (pixel, (&depth, &id)) in (0..).zip(depth.iter().zip(index)) {
        if id != NO_CLUSTER && shows_surface(depth) {
            let at = [pixel % grid.width, pixel / grid.width];
            boxes[id as usize].grow(&of_sample(grid, clusters, at, depth));
        }
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_its_samples() {
        let grid = TileGrid {
            width: 2,
            height: 1,
            perspective: 1,
            depth_offset: 1.0,
            depth_slack: 1e-6,
            near: 1.0,
            ..TileGrid::default()
        };
        let clusters = ClusterGrid { pixel_x: [-1.0, 1.0, 1e-6], pixel_y: [0.5, -1.0, 1e-6], ..ClusterGrid::default() };
        let boxes = run(&grid, &clusters, &[0.5, 0.25], &[0, 0], 1);
        let near = |[low, high]: [f32; 2], wanted: [f32; 2]| {
            low <= wanted[0] && high >= wanted[1] && low > wanted[0] - 1e-3 && high < wanted[1] + 1e-3
        };
        assert!(near(boxes[0].distance, [2.0, 4.0]), "{boxes:?}");
        assert!(near(boxes[0].across, [-2.0, 4.0]), "{boxes:?}");
        assert!(near(boxes[0].up, [-2.0, 2.0]), "{boxes:?}");
        let apart = run(&grid, &clusters, &[0.5, 0.25], &[0, NO_CLUSTER], 1);
        assert!(near(apart[0].distance, [2.0, 2.0]) && near(apart[0].across, [-2.0, 0.0]), "{apart:?}");
    }
}
