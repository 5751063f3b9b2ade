//! Where clusters find their candidates: in the lists of their tiles, or in the light hierarchy, through which each cluster walks with its
//! own box. Both give the same lists, but for the depth bounds of tiles, which only lists of tiles know.
//!
//! The cheaper source is chosen by counting tests of a light against a tile, each of which is made twice, to count and to fill, and what
//! else takes as long as so many of them:
//!
//! - lists of tiles: every bin looks at every light, the 64 tiles of a bin at its list, and the clusters of a tile at the tile's;
//! - hierarchy: every cluster looks at the nodes of a walk, and making the tree passes each light through the digits of a sort.
//!
//! How many clusters there will be only depths know, so `KEYED_CLUSTERS` a tile are taken for granted where clusters are made of samples.
//! The factors were measured on lavapipe, two cores (`render builtin:atrium --technique clustered-deferred`, with `--lights 4096
//! --light-range 1` and `--lights 65536 --light-range 0.4`): a test of a light and a tile takes 6 ns. By them the hierarchy wins from about
//! 100,000 lights on at 1280x720; measured there: 21 ms against 39 ms at 4,096 lights, 84 ms against 99 ms at 65,536.

use super::light_tree::LightTree;
use super::list_sort::ListSort;
use super::request::{AssignChoice, DepthBounds};
use super::tiles::SCAN_GROUP;
use super::{Clusters, Limits, Request, Tiles};
use crate::error::{Error, Result};
use crate::shared::{BIN_TILES, CULL_TEXELS, MOST_GROUPS, RADIX_BITS, TREE_KEY_BITS, TREE_SHIFT};

/// Candidates from the light hierarchy.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeSource {
    /// The hierarchy.
    pub tree: LightTree,
    /// Puts each cluster's list into the order of ids.
    pub sort: ListSort,
}

/// Clusters of a tile that own samples: 256 of 60 tiles of 16 pixels on the atrium (`check --only cluster_trees`).
const KEYED_CLUSTERS: f64 = 4.0;
/// Directions of normals that the samples of a tile and slice have, about: 43,797 pairs of lists became 55,175 with four directions
/// (atrium, 4,096 lights of 1 m, 1280x720, `render --counters`).
const DIRECTIONS_SEEN: f64 = 1.3;

/// A light against a bin: rectangles alone.
const BIN_TEST: f64 = 0.25;

/// A light of a tile's list against a cluster: a box alone.
const CLUSTER_TEST: f64 = 0.5;

/// A node of the hierarchy, with what lanes of one walk wait for those of others.
const NODE_TEST: f64 = 1.1;

/// Side of the box of lights that are neighbours by their keys over that of a cube that holds as many.
const BOX_SIDE: f64 = 1.3;

/// Share of a tile's lights that its depth bounds leave: at most half on the atrium (issue "Many lights", shapes from the literature).
const BOUNDED: f64 = 0.5;

/// Times that a light is touched for each digit of its key: counted, scanned and moved.
const TOUCHES: f64 = 3.0;

/// What the steps that only the hierarchy has cost by themselves: about 45 of 0.1 ms.
const STEPS: f64 = 400_000.0;

impl TreeSource {
    pub(super) fn new(tiles: &Tiles, clusters: &Clusters, limits: &Limits) -> Result<Self> {
        let grid = &clusters.grid;
        let tree = LightTree::new(&tiles.lights, limits)?;
        let counts = u64::from(grid.capacity) * u64::from(tree.walk_count());
        let most = limits.max_storage_bytes.min(limits.max_buffer_bytes) / 4;
        let most = most.min(u64::from(MOST_GROUPS) * SCAN_GROUP).min(u64::from(u32::MAX));
        if counts >= most {
            let (clusters, walks) = (grid.capacity, tree.walk_count());
            return Err(Error::new(format!(
                "{clusters} clusters of {walks} walks through the light hierarchy need {counts} counts, this device takes {most}"
            )));
        }
        let sort = ListSort {
            list_count: grid.capacity,
            stride: 1,
            entry_count: clusters.pairs,
            longest: clusters.longest_list,
        };
        sort.check(limits)?;
        Ok(Self { tree, sort })
    }

    /// Bytes of everything that lists of clusters take beyond what those from lists of tiles do.
    pub fn bytes(&self) -> u64 {
        let (clusters, walks) = (u64::from(self.sort.list_count), u64::from(self.tree.walk_count()));
        let walked = if walks > 1 { clusters * (2 * walks - 1) * 4 } else { 0 };
        self.tree.bytes() + self.sort.bytes() + walked
    }
}

/// The hierarchy where candidates come from it, `None` where they come from lists of tiles; and why.
///
/// # Errors
/// What was asked for and this device does not take, or neither of the two.
pub(super) fn source(
    request: &Request,
    tiles: &Tiles,
    clusters: &Clusters,
    limits: &Limits,
) -> Result<(Option<TreeSource>, String)> {
    const TILES: &str = "candidates from lists of tiles";
    const TREE: &str = "candidates from the light hierarchy";
    match request.assign {
        AssignChoice::Tiles => tiles.check_candidates(limits).map(|()| (None, format!("{TILES}: asked for"))),
        AssignChoice::Tree => {
            TreeSource::new(tiles, clusters, limits).map(|tree| (Some(tree), format!("{TREE}: asked for")))
        }
        AssignChoice::Auto => match (tiles.check_candidates(limits), TreeSource::new(tiles, clusters, limits)) {
            (Err(error), Err(_)) => Err(error),
            (Ok(()), Err(error)) => Ok((None, format!("{TILES}: {error}"))),
            (Err(error), Ok(tree)) => Ok((Some(tree), format!("{TREE}: {error}"))),
            (Ok(()), Ok(tree)) => {
                let (of_tiles, of_tree) = (tile_tests(tiles, clusters), tree_tests(tiles, clusters, &tree.tree));
                let numbers =
                    format!("about {of_tiles:.0} tests by lists of tiles, {of_tree:.0} by the light hierarchy");
                let chosen = (of_tree < of_tiles).then_some(tree);
                let name = if chosen.is_some() { TREE } else { TILES };
                Ok((chosen, format!("{name}: {numbers}")))
            }
        },
    }
}

/// Clusters of a tile, about.
fn clusters_a_tile(clusters: &Clusters) -> f64 {
    let slices = f64::from(clusters.grid.slices);
    let told = if clusters.by_normal() { DIRECTIONS_SEEN } else { 1.0 };
    if clusters.keyed { slices.min(KEYED_CLUSTERS) * told } else { slices }
}

fn tile_tests(tiles: &Tiles, clusters: &Clusters) -> f64 {
    let listed = if tiles.bounds == DepthBounds::Off { 1.0 } else { BOUNDED };
    f64::from(tiles.count_bins()) * f64::from(tiles.grid.light_count) * BIN_TEST
        + tiles.bin_pairs as f64 * f64::from(BIN_TILES * BIN_TILES)
        + tiles.tile_pairs as f64 * listed * clusters_a_tile(clusters) * CLUSTER_TEST
}

fn tree_tests(tiles: &Tiles, clusters: &Clusters, tree: &LightTree) -> f64 {
    let digits = f64::from(TREE_KEY_BITS.div_ceil(RADIX_BITS));
    let made = f64::from(tree.shape.light_count) * digits * TOUCHES;
    let clusters = f64::from(tiles.count_tiles()) * clusters_a_tile(clusters);
    clusters * nodes_of_walk(tiles, tree) * NODE_TEST + made + STEPS
}

/// Nodes that the box of a cluster meets on its way through all roots, where lights lie anywhere in their box alike: all children of each
/// node whose own box it touches. A node above m of n lights spans m / n of the volume, and a light's diameter more along each axis.
fn nodes_of_walk(tiles: &Tiles, tree: &LightTree) -> f64 {
    let (shape, spread) = (&tree.shape, Spread::new(tiles, tree.shape.radius_limit));
    let of_level = |depth: u32| {
        let nodes = f64::from(shape.root_count << (TREE_SHIFT * depth));
        let side = (spread.volume / nodes).cbrt();
        let touched = if side > 0.0 { (BOX_SIDE + (spread.diameter + spread.cluster) / side).powi(3) } else { nodes };
        f64::from(1u32 << TREE_SHIFT) * touched.min(nodes)
    };
    f64::from(shape.everywhere_count + shape.root_count) + (0..shape.height).map(of_level).sum::<f64>()
}

/// How the lights that stand in the hierarchy lie.
#[derive(Default)]
struct Spread {
    /// Of the box of centres, cubic metres.
    volume: f64,
    /// Mean of spheres, metres.
    diameter: f64,
    /// Width of a tile at the mean distance of lights, metres: as deep as that is a cluster, too.
    cluster: f64,
}

impl Spread {
    fn new(tiles: &Tiles, radius_limit: f32) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let (mut radii, mut distances, mut count) = (0.0, 0.0, 0.0);
        for light in tiles.lights.chunks_exact(CULL_TEXELS as usize) {
            let ([x, y, z, _], radius, [x0, x1, y0, y1]) = (light[0], light[1][2], light[2]);
            if x0 > x1 || y0 > y1 || radius > radius_limit || !radius.is_finite() {
                continue;
            }
            for (axis, center) in [x, y, z].into_iter().enumerate() {
                low[axis] = low[axis].min(f64::from(center));
                high[axis] = high[axis].max(f64::from(center));
            }
            radii += f64::from(radius);
            distances += f64::from(z.abs());
            count += 1.0;
        }
        if count == 0.0 {
            return Self::default();
        }
        let tile = f64::from(tiles.edges[1][0] - tiles.edges[0][0]).abs();
        Self {
            volume: (0..3).map(|axis| high[axis] - low[axis]).product(),
            diameter: 2.0 * radii / count,
            cluster: if tiles.grid.perspective == 0 { tile } else { tile * distances / count },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Plan, Technique};
    use crate::scene::lighting::{LightRules, RangeRule};
    use crate::scene::{builtin, scatter};

    fn planned(lights: usize, range: f64, request: Request, limits: &Limits) -> Result<Plan> {
        let mut scene = builtin::load("atrium").expect("a built-in scene");
        scene.lights = scatter::point_lights(&scene.bounds(), lights, 5);
        let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
        Plan::new(&scene, &Request { technique: Technique::ClusteredDeferred, rules, ..request }, limits)
    }

    fn asked(assign: AssignChoice) -> Request {
        Request { width: 320, height: 180, assign, ..Request::default() }
    }

    fn takes_tree(lights: usize, range: f64) -> bool {
        let request = Request { width: 1280, height: 720, ..Request::default() };
        let clusters = planned(lights, range, request, &Limits::UNLIMITED).expect("a plan").clusters.expect("clusters");
        assert!(clusters.why.contains("by lists of tiles") && clusters.why.contains("by the light hierarchy"));
        clusters.tree.is_some()
    }

    #[test]
    fn few_lights_are_listed_by_tile_and_very_many_are_not() {
        assert_eq!([(16, 1.0), (1024, 1.0), (300_000, 0.25)].map(|(n, r)| takes_tree(n, r)), [false, false, true]);
    }

    #[test]
    fn the_hierarchy_knows_no_depths_of_tiles() {
        let plan = planned(300, 1.0, asked(AssignChoice::Tree), &Limits::MINIMUM).expect("a plan");
        let (tiles, clusters) = (plan.tiles.expect("tiles"), plan.clusters.expect("clusters"));
        assert_eq!(tiles.bounds, DepthBounds::Off);
        let source = clusters.tree.as_ref().expect("a hierarchy");
        assert_eq!((source.sort.entry_count, source.sort.list_count), (clusters.pairs, clusters.grid.capacity));
        assert!(source.sort.longest <= tiles.longest_tile && clusters.bytes() > source.bytes());
        let effect = |name| plan.effects.iter().find(|e| e.name == name).expect("an effect");
        assert!(!effect("light_lists").runs && !effect("depth_bounds").runs && effect("clusters").runs);
        let bounded = Request { depth_bounds: Some(DepthBounds::MinMax), ..asked(AssignChoice::Tree) };
        let refused = planned(300, 1.0, bounded, &Limits::MINIMUM).expect_err("no tile asks").to_string();
        assert!(refused.contains("--depth-bounds minmax") && refused.contains("--assign tree"), "{refused}");
        let bounded = Request { depth_bounds: Some(DepthBounds::MinMax), ..asked(AssignChoice::Auto) };
        let plan = planned(300, 1.0, bounded, &Limits::MINIMUM).expect("a plan");
        assert!(plan.clusters.is_some_and(|clusters| clusters.tree.is_none()));
    }

    #[test]
    fn the_source_that_fits_is_taken() {
        let loops = Limits { max_loop_iterations: 4000, ..Limits::UNLIMITED };
        let refused = planned(3000, 1.0, asked(AssignChoice::Tree), &loops).expect_err("long walks").to_string();
        assert!(refused.contains("hierarchy"), "{refused}");
        let plan = planned(3000, 1.0, asked(AssignChoice::Auto), &loops).expect("lists of tiles");
        let clusters = plan.clusters.expect("clusters");
        assert!(clusters.tree.is_none() && clusters.why.contains("hierarchy visits"), "{}", clusters.why);
    }
}
