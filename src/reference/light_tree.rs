//! CPU twin of the light hierarchy: `glsl/bvh/light_keys.comp`, `light_leaves.comp`, `light_nodes.comp` and the walk of
//! `glsl/inc/light_tree.glsl`, to the bit.

use super::radix_sort;
use crate::shared::{
    CULL_TEXELS, DISTANCE_SLACK, TREE_CELLS, TREE_EMPTY, TREE_ENTRY_TEXELS, TREE_HEADER_TEXELS, TREE_KEY_BITS,
    TREE_KEY_CENTER, TREE_KEY_EMPTY, TREE_KEY_EVERYWHERE, TREE_QUERY_SIZES, TREE_SHIFT, TREE_WIDTH, TreeQuery,
    TreeShape,
};

/// Box of one entry, with its index or number of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Low corner, view space, metres.
    pub low: [f32; 3],
    /// A light's index among the culled ones; 0 for a node.
    pub light: f32,
    /// High corner.
    pub high: [f32; 3],
    /// Lights in it.
    pub light_count: f32,
}

impl Entry {
    /// A node without children.
    const EMPTY: Self = Self { low: [TREE_EMPTY; 3], light: 0.0, high: [-TREE_EMPTY; 3], light_count: 0.0 };

    /// What two texels say.
    fn from_texels(texels: &[[f32; 4]]) -> Self {
        let ([x, y, z, light], [u, v, w, light_count]) = (texels[0], texels[1]);
        Self { low: [x, y, z], light, high: [u, v, w], light_count }
    }

    fn texels(&self) -> [[f32; 4]; 2] {
        let ([x, y, z], [u, v, w]) = (self.low, self.high);
        [[x, y, z, self.light], [u, v, w, self.light_count]]
    }

    fn touches(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        (0..3).all(|axis| self.low[axis] <= high[axis] && low[axis] <= self.high[axis])
    }
}

/// Header and entries as the device has them. `lights` has `CULL_TEXELS` each.
pub fn build(shape: &TreeShape, lights: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let indices: Vec<u32> = (0..shape.light_count).collect();
    let keys: Vec<u32> = indices.iter().map(|&light| key(shape, lights, light)).collect();
    let (_, sorted) = radix_sort::run(&keys, &indices, TREE_KEY_BITS);
    let (outside, inside) = sorted.split_at(shape.everywhere_count as usize);
    let leaves = |list: &[u32]| -> Vec<Entry> { list.iter().map(|&light| leaf(lights, light)).collect() };
    let mut levels = vec![leaves(inside)];
    for depth in (0..shape.height).rev() {
        let count = (shape.root_count << (TREE_SHIFT * depth)) as usize;
        let mut nodes: Vec<_> = levels[levels.len() - 1].chunks(TREE_WIDTH as usize).map(node).collect();
        nodes.resize(count, Entry::EMPTY);
        levels.push(nodes);
    }
    levels.push(leaves(outside));
    let header = [shape.everywhere_count, inside.len() as u32, shape.height, shape.root_count].map(|n| n as f32);
    let entries = levels.iter().rev().flatten().flat_map(Entry::texels);
    std::iter::once(header).chain(entries).collect()
}

/// Bit i goes to bit 3 i.
fn spread(cell: u32) -> u32 {
    (0..10).map(|bit| ((cell >> bit) & 1) << (3 * bit)).sum()
}

fn key(shape: &TreeShape, lights: &[[f32; 4]], light: u32) -> u32 {
    let texel = |i: u32| lights[(light * CULL_TEXELS + i) as usize];
    if is_unseen(texel(2)) {
        return TREE_KEY_EMPTY;
    }
    if texel(1)[2] > shape.radius_limit {
        return TREE_KEY_EVERYWHERE;
    }
    let cell = |axis: usize| {
        let at = (texel(0)[axis] - shape.low[axis]) * shape.scale;
        spread(at.clamp(0.0, (TREE_CELLS - 1) as f32) as u32)
    };
    TREE_KEY_CENTER | cell(0) | (cell(1) << 1) | (cell(2) << 2)
}

/// No tile sees a light whose rectangle is empty.
fn is_unseen([x0, x1, y0, y1]: [f32; 4]) -> bool {
    x0 > x1 || y0 > y1
}

fn leaf(lights: &[[f32; 4]], light: u32) -> Entry {
    let texel = |i: u32| lights[(light * CULL_TEXELS + i) as usize];
    if is_unseen(texel(2)) {
        return Entry { light: light as f32, light_count: 1.0, ..Entry::EMPTY };
    }
    let ([x, y, z, _], radius) = (texel(0), texel(1)[2]);
    let radius = radius + radius * DISTANCE_SLACK;
    let low = [x, y, z].map(|c| c - radius).map(|low| low - low.abs() * DISTANCE_SLACK);
    let high = [x, y, z].map(|c| c + radius).map(|high| high + high.abs() * DISTANCE_SLACK);
    Entry { low, light: light as f32, high, light_count: 1.0 }
}

fn node(children: &[Entry]) -> Entry {
    children.iter().fold(Entry::EMPTY, |mut node, child| {
        for axis in 0..3 {
            node.low[axis] = node.low[axis].min(child.low[axis]);
            node.high[axis] = node.high[axis].max(child.high[axis]);
        }
        node.light_count += child.light_count;
        node
    })
}

/// A hierarchy as the device left it.
#[derive(Debug, Clone, Copy)]
pub struct Tree<'a> {
    texels: &'a [[f32; 4]],
    everywhere_count: u32,
    /// Lights below the roots.
    light_count: u32,
    height: u32,
    root_count: u32,
}

impl<'a> Tree<'a> {
    /// Reads the header; `None` where there is not even that.
    pub fn new(texels: &'a [[f32; 4]]) -> Option<Self> {
        let [everywhere_count, light_count, height, root_count] = texels.first()?.map(|n| n as u32);
        Some(Self { texels, everywhere_count, light_count, height, root_count })
    }

    /// An entry: first those outside the hierarchy, then level by level.
    pub fn entry(&self, entry: u32) -> Entry {
        Entry::from_texels(&self.texels[(TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * entry) as usize..])
    }

    /// Entries of a level in their order, without those that only fill it up.
    pub fn level(&self, depth: u32) -> Vec<Entry> {
        let nodes = |depth: u32| self.root_count << (TREE_SHIFT * depth);
        let first = self.everywhere_count + (0..depth).map(nodes).sum::<u32>();
        let count = self.light_count.div_ceil(1 << (TREE_SHIFT * (self.height - depth)));
        (first..first + count).map(|entry| self.entry(entry)).collect()
    }

    /// Lights whose boxes touch the box from `low` to `high`, in the order of a walk below `root`, and the nodes that it visits.
    pub fn walk(&self, root: u32, low: [f32; 3], high: [f32; 3]) -> (Vec<u32>, u32) {
        let (mut found, mut visited) = (Vec::new(), 0);
        if root == 0 {
            visited += self.everywhere_count;
            let outside = (0..self.everywhere_count).map(|entry| self.entry(entry));
            found.extend(outside.filter(|e| e.touches(low, high)).map(|e| e.light as u32));
        }
        if root < self.root_count {
            self.descend((0, root, self.everywhere_count), (low, high), &mut found, &mut visited);
        }
        (found, visited)
    }

    /// The node at depth, index and the level's first entry, and all below it: the order that the device keeps without a stack.
    fn descend(
        &self,
        (depth, index, first): (u32, u32, u32),
        (low, high): ([f32; 3], [f32; 3]),
        found: &mut Vec<u32>,
        visited: &mut u32,
    ) {
        *visited += 1;
        let entry = self.entry(first + index);
        if !entry.touches(low, high) {
            return;
        }
        if depth == self.height {
            found.push(entry.light as u32);
            return;
        }
        let below = first + (self.root_count << (TREE_SHIFT * depth));
        let end = self.light_count.div_ceil(1 << (TREE_SHIFT * (self.height - depth - 1)));
        for child in (index * TREE_WIDTH..end).take(TREE_WIDTH as usize) {
            self.descend((depth + 1, child, below), (low, high), found, visited);
        }
    }
}

/// Corners of a box that `glsl/bvh/light_query.comp` asks for.
pub fn query_box(queries: &TreeQuery, query: u32) -> ([f32; 3], [f32; 3]) {
    let size = query % TREE_QUERY_SIZES;
    let side = size.checked_sub(1).map_or(0.0, |bits| queries.step * (1u32 << bits) as f32);
    let low = [397, 631, 883u32].map(|factor| query.wrapping_mul(factor) % TREE_CELLS);
    let low = std::array::from_fn(|axis| queries.low[axis] + queries.step * low[axis] as f32);
    (low, low.map(|x: f32| x + side))
}

/// What the probe writes for a walk: how many lights, the sums of their numbers and of those squared, and the nodes visited.
pub fn probe(lights: &[u32], visited: u32) -> [u32; 4] {
    let numbers = || lights.iter().map(|light| light + 1);
    let sum = numbers().fold(0, u32::wrapping_add);
    let squares = numbers().fold(0, |sum: u32, n| sum.wrapping_add(n.wrapping_mul(n)));
    [lights.len() as u32, sum, squares, visited]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_bits_do_not_overlap() {
        let all = spread(TREE_CELLS - 1);
        assert_eq!(all | all << 1 | all << 2, (1 << 30) - 1);
        assert_eq!(all & all << 1, 0);
        assert_eq!(spread(0b101), 0b1_000_001);
    }

    #[test]
    fn a_box_holds_its_sphere_exactly() {
        let mut random = crate::math::random::Random::new(5);
        for _ in 0..100_000 {
            let mut value = || (random.range(-30.0, 30.0).exp() * random.range(-1.0, 1.0)) as f32;
            let (center, radius) = ([value(), value(), value()], value().abs());
            let [x, y, z] = center;
            let made = leaf(&[[x, y, z, 0.0], [0.0, 1.0, radius, 0.0], [0.0; 4]], 0);
            let holds = |axis: usize| {
                let (c, r) = (f64::from(center[axis]), f64::from(radius));
                f64::from(made.low[axis]) <= c - r && c + r <= f64::from(made.high[axis])
            };
            assert!((0..3).all(holds), "{center:?} {radius}");
        }
    }

    #[test]
    fn queries_are_points_and_cubes_up_to_the_whole() {
        let queries = TreeQuery { low: [1.0, 2.0, 3.0], step: 0.5, query_count: 12 };
        assert_eq!(query_box(&queries, 0), ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]));
        let (low, high) = query_box(&queries, 11);
        assert_eq!(high[0] - low[0], 512.0);
        assert_eq!(probe(&[0, 2], 7), [2, 4, 10, 7]);
    }
}
