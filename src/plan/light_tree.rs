//! The light hierarchy: which lights stand outside it, how keys are quantised, and the exact size of everything.

use super::Limits;
use crate::error::{Error, Result};
use crate::shared::{
    CULL_TEXELS, RADIX_BLOCK, RADIX_DIGITS, SCAN_RUN, TREE_CELLS, TREE_ENTRY_TEXELS, TREE_HEADER_TEXELS, TREE_HEIGHT,
    TREE_SHIFT, TreeLevel, TreeShape,
};

/// What the plan decided about the hierarchy of one view's culled lights.
#[derive(Debug, Clone, PartialEq)]
pub struct LightTree {
    /// For the device.
    pub shape: TreeShape,
    /// Nodes are read by texel.
    pub by_texel: bool,
}

/// A dimension of a dispatch has at most 65,535 groups, here of 64 threads. Below 2^24, where f32 counts exactly.
const MOST_LIGHTS: u32 = 65_535 * 64;

/// A light of a radius above this part of the centres' largest extent makes every box above it useless.
const WIDE: f64 = 0.125;

/// Wide lights that every walk tests one by one, at most: with a whole root they stay below 65,535 iterations.
const MOST_WIDE: usize = 8192;

/// Where more than one light in this many is wide, boxes are no worse than a list, and all lights go into the hierarchy.
const WIDE_SHARE: usize = 8;

/// Centres closer together than this (metres) share a cell: products with the scale stay finite and normal.
const SMALLEST_EXTENT: f64 = 1e-30;

impl LightTree {
    /// Decides the hierarchy of `lights`, `CULL_TEXELS` each, as [`Tiles`](super::Tiles) makes them.
    ///
    /// # Errors
    /// More lights than a dispatch or a binding of the device takes, or than its loops go round.
    pub fn new(lights: &[[f32; 4]], limits: &Limits) -> Result<Self> {
        let count = lights.len() / CULL_TEXELS as usize;
        let light_count = u32::try_from(count).ok().filter(|&n| n <= MOST_LIGHTS).ok_or_else(|| {
            Error::new(format!("a light hierarchy takes at most {MOST_LIGHTS} lights, this picture has {count}"))
        })?;
        let (low, extent) = centers(lights);
        let (radius_limit, everywhere_count) = wide(lights, extent);
        let below = light_count - everywhere_count;
        let height = (0..TREE_HEIGHT).find(|h| below <= 1 << (TREE_SHIFT * h)).unwrap_or(TREE_HEIGHT);
        let root_count = below.div_ceil(1 << (TREE_SHIFT * height));
        let scale = if extent > SMALLEST_EXTENT { (f64::from(TREE_CELLS) / extent) as f32 } else { 1.0 };
        let mut shape =
            TreeShape { low, scale, radius_limit, light_count, everywhere_count, height, root_count, leaf_first: 0 };
        shape.leaf_first = first_entry(&shape, height);
        let mut tree = Self { shape, by_texel: false };
        tree.check(limits)?;
        tree.by_texel = tree.texel_count() <= limits.max_texel_elements;
        Ok(tree)
    }

    /// Walks that together meet every light: one a root, and one where there is none.
    pub fn walk_count(&self) -> u32 {
        self.shape.root_count.max(1)
    }

    /// Nodes that one walk visits at most.
    pub fn longest_walk(&self) -> u64 {
        let of_one_root = (1u64 << (TREE_SHIFT * (self.shape.height + 1))) / 7;
        u64::from(self.shape.everywhere_count) + of_one_root * u64::from(self.shape.root_count.min(1))
    }

    /// Level `depth` below the roots, for `depth` less than the height.
    pub fn level(&self, depth: u32) -> TreeLevel {
        let shape = &self.shape;
        let lights = shape.light_count - shape.everywhere_count;
        let filled = |depth: u32| shape.root_count << (TREE_SHIFT * depth);
        TreeLevel {
            first: first_entry(shape, depth),
            count: filled(depth),
            child_first: first_entry(shape, depth + 1),
            child_count: if depth + 1 < shape.height { filled(depth + 1) } else { lights },
        }
    }

    /// Texels of the hierarchy.
    pub fn texel_count(&self) -> u64 {
        let lights_below = self.shape.light_count - self.shape.everywhere_count;
        let entries = u64::from(self.shape.leaf_first) + u64::from(lights_below);
        u64::from(TREE_HEADER_TEXELS) + u64::from(TREE_ENTRY_TEXELS) * entries
    }

    /// Bytes of the hierarchy.
    pub fn tree_bytes(&self) -> u64 {
        self.texel_count() * 16
    }

    /// Bytes of the hierarchy and of all that is needed to make it: keys, and what the sort moves them through.
    pub fn bytes(&self) -> u64 {
        let lights = u64::from(self.shape.light_count);
        let digits = u64::from(RADIX_DIGITS) * lights.div_ceil(u64::from(RADIX_BLOCK)).max(1);
        let run = u64::from(SCAN_RUN);
        let levels = std::iter::successors(Some(digits), |&l| (l > run).then(|| l.div_ceil(run)));
        // Each level has its items and one offset more; keys and indices, two buffers of pairs, sorted keys and indices.
        let scanned: u64 = levels.map(|items| 2 * items + 1).sum();
        self.tree_bytes() + (2 * lights.max(1) + 6 * lights + scanned) * 4
    }

    fn check(&self, limits: &Limits) -> Result<()> {
        let (bytes, most) = (self.tree_bytes(), limits.max_storage_bytes.min(limits.max_buffer_bytes));
        if bytes > most {
            let lights = self.shape.light_count;
            return Err(Error::new(format!(
                "the hierarchy of {lights} lights needs {bytes} bytes, this device binds at most {most} at once"
            )));
        }
        let (nodes, most) = (self.longest_walk(), limits.max_loop_iterations);
        if nodes >= u64::from(most) {
            return Err(Error::new(format!(
                "a walk through the light hierarchy visits up to {nodes} nodes; this driver leaves its loops after {most} iterations"
            )));
        }
        Ok(())
    }
}

/// Entry of the first node at `depth`: behind the lights outside, and behind all levels above.
fn first_entry(shape: &TreeShape, depth: u32) -> u32 {
    shape.everywhere_count + shape.root_count * (((1 << (TREE_SHIFT * depth)) - 1) / 7)
}

/// Lights that some tile may see: centre and radius.
fn seen(lights: &[[f32; 4]]) -> impl Iterator<Item = ([f32; 3], f32)> + '_ {
    lights.chunks_exact(CULL_TEXELS as usize).filter_map(|light| {
        let [x0, x1, y0, y1] = light[2];
        let [x, y, z, _] = light[0];
        (x0 <= x1 && y0 <= y1).then_some(([x, y, z], light[1][2]))
    })
}

/// Low corner and largest extent, in metres, of the box of finite centres. One extent for all axes keeps cells cubes, which spheres
/// fill best.
fn centers(lights: &[[f32; 4]]) -> ([f32; 3], f64) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (center, _) in seen(lights).filter(|(center, _)| center.iter().all(|x| x.is_finite())) {
        for axis in 0..3 {
            low[axis] = low[axis].min(center[axis]);
            high[axis] = high[axis].max(center[axis]);
        }
    }
    if low[0] > high[0] {
        return ([0.0; 3], 0.0);
    }
    let extents = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis]));
    (low, extents.fold(0.0, f64::max))
}

/// The radius beyond which lights stand outside, and how many they are.
fn wide(lights: &[[f32; 4]], extent: f64) -> (f32, u32) {
    let limit = (extent * WIDE) as f32;
    let (mut all, mut wide) = (0, 0);
    for (_, radius) in seen(lights) {
        all += 1;
        wide += usize::from(radius > limit);
    }
    if wide == 0 || wide > MOST_WIDE || wide * WIDE_SHARE > all {
        return (f32::INFINITY, 0);
    }
    (limit, wide as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(x: f32, radius: f32) -> [[f32; 4]; 3] {
        [[x, 0.0, -5.0, radius * radius], [1.0, 9.0, radius, 0.0], [0.0; 4]]
    }

    fn row(count: u32, radius: f32) -> Vec<[f32; 4]> {
        (0..count).flat_map(|i| light(i as f32, radius)).collect()
    }

    fn tree(lights: &[[f32; 4]]) -> LightTree {
        LightTree::new(lights, &Limits::UNLIMITED).expect("nothing limits it")
    }

    #[test]
    fn heights_and_roots_hold_every_light() {
        // Lights, height, roots, texels.
        let cases = [
            (0, 0, 0, 1),
            (1, 0, 1, 3),
            (8, 1, 1, 1 + 2 * 9),
            (9, 2, 1, 1 + 2 * 18),
            (32_768, 5, 1, 1 + 2 * (4681 + 32_768)),
            (32_769, 5, 2, 1 + 2 * (2 * 4681 + 32_769)),
            (1_000_000, 5, 31, 1 + 2 * (31 * 4681 + 1_000_000)),
        ];
        for (count, height, roots, texels) in cases {
            let tree = tree(&row(count, 0.01));
            let shape = tree.shape;
            assert_eq!((shape.height, shape.root_count, tree.texel_count()), (height, roots, texels), "{count}");
            assert_eq!(shape.everywhere_count, 0);
            assert!(count <= roots << (3 * height));
            assert!(tree.longest_walk() <= 37_449);
            for depth in 0..height {
                let level = tree.level(depth);
                assert_eq!(level.first + level.count, level.child_first);
                assert!(level.child_count <= 8 * level.count);
            }
        }
    }

    #[test]
    fn few_wide_lights_stand_outside_and_many_do_not() {
        let mut lights = row(100, 0.1);
        lights.extend(light(50.0, f32::INFINITY));
        lights.extend(light(50.0, 12.0));
        lights.extend(light(50.0, 13.0));
        let shape = tree(&lights).shape;
        assert_eq!((shape.light_count, shape.everywhere_count, shape.leaf_first), (103, 2, 2 + 1 + 8 + 64));
        assert!(shape.radius_limit > 12.0 && shape.radius_limit < 13.0);
        assert_eq!(tree(&row(50, 40.0)).shape.everywhere_count, 0);
        assert_eq!(tree(&[light(1.0, 2.0), light(1.0, 2.0)].concat()).shape.everywhere_count, 0);
    }

    #[test]
    fn lights_that_no_tile_sees_do_not_stretch_the_box() {
        let mut lights = row(11, 0.1);
        let mut far = light(1e6, 0.1);
        far[2] = [1.0, 0.0, 1.0, 0.0];
        lights.extend(far);
        let shape = tree(&lights).shape;
        assert_eq!((shape.low, shape.scale), ([0.0, 0.0, -5.0], 102.4));
        assert_eq!(tree(&light(3.0, 1.0)).shape.scale, 1.0);
    }

    #[test]
    fn what_does_not_fit_is_refused_in_one_sentence() {
        let lights = row(5000, 0.01);
        let refused = |limits: Limits| LightTree::new(&lights, &limits).expect_err("too small").to_string();
        let bytes = refused(Limits { max_storage_bytes: 100_000, ..Limits::UNLIMITED });
        assert_eq!(bytes, "the hierarchy of 5000 lights needs 309808 bytes, this device binds at most 100000 at once");
        let loops = refused(Limits { max_loop_iterations: 37_449, ..Limits::UNLIMITED });
        assert!(loops.contains("37449 nodes") && !loops.contains('\n'), "{loops}");
        let minimum = Limits { max_loop_iterations: 65_535, ..Limits::MINIMUM };
        assert!(LightTree::new(&lights, &minimum).expect("fits").by_texel);
        assert!(!LightTree::new(&row(40_000, 0.01), &minimum).expect("fits").by_texel);
    }
}
