//! Bounding volume hierarchy over triangles, in f64.
//!
//! Built by binned surface-area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
//! 2007).

use std::ops::Range;

use glam::DVec3;

use super::ray::{Crossing, Ray, Sheared};
use crate::scene::Bounds;

/// Most triangles of a leaf.
const LEAF_TRIANGLES: usize = 4;

const BINS: usize = 16;

/// From this depth on a node is halved by count, so that no arrangement of triangles makes the tree deep.
const HALVING_DEPTH: usize = 64;

/// The walk leaves at most one sibling a level behind: `HALVING_DEPTH` levels, then at most 32 halvings of 2^32
/// triangles.
const STACK: usize = HALVING_DEPTH + 32 + 1;

/// Relative to a triangle's largest coordinate.
const PADDING: f64 = 1e-12;

/// The hierarchy and its triangles.
#[derive(Debug, Clone)]
pub struct Bvh {
    corners: Vec<[DVec3; 3]>,
    nodes: Vec<Node>,
    /// Triangle indices, grouped by leaf.
    order: Vec<u32>,
}

/// A node of [`Bvh::threaded`].
#[derive(Debug, Clone, Copy)]
pub struct Threaded<'a> {
    /// Of its box.
    pub min: DVec3,
    /// Of its box.
    pub max: DVec3,
    /// Of a leaf; an inner node has none, and its first child follows it.
    pub triangles: &'a [u32],
    /// What is behind it and all below it.
    pub next: usize,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    min: DVec3,
    max: DVec3,
    /// Leaf: first place in `order`. Inner: the first of two neighbouring children.
    first: u32,
    /// 0 for an inner node.
    count: u32,
}

impl Bvh {
    /// Builds over `corners`; triangles of zero area or with a corner that is not finite are left out. At most
    /// `u32::MAX` triangles.
    pub fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let boxes: Vec<Bounds> = corners.iter().map(padded_box).collect();
        let order = (0..corners.len() as u32).filter(|&id| has_area(&corners[id as usize])).collect();
        let mut build = Build { boxes, order, nodes: Vec::new() };
        build.run();
        Self { corners, nodes: build.nodes, order: build.order }
    }

    /// Nodes in the order of a walk that takes the first child first: box, triangles of a leaf, and the node that comes next where the box is missed.
    pub fn threaded(&self) -> Vec<Threaded<'_>> {
        let mut walk = Vec::with_capacity(self.nodes.len());
        if !self.nodes.is_empty() {
            self.thread(0, &mut walk);
        }
        walk
    }

    /// Adds a node and all below it. Their depth is bounded, see [`STACK`].
    fn thread<'a>(&'a self, index: usize, walk: &mut Vec<Threaded<'a>>) {
        let node = &self.nodes[index];
        let (at, first) = (walk.len(), node.first as usize);
        let leaf = if node.count > 0 { &self.order[first..first + node.count as usize] } else { &[] };
        walk.push(Threaded { min: node.min, max: node.max, triangles: leaf, next: 0 });
        if node.count == 0 {
            self.thread(first, walk);
            self.thread(first + 1, walk);
        }
        walk[at].next = walk.len();
    }

    /// The corners of a triangle, as given.
    pub fn corners(&self, triangle: u32) -> &[DVec3; 3] {
        &self.corners[triangle as usize]
    }

    /// The nearest accepted crossing; of two at the same `t`, that of the lower triangle index.
    pub fn nearest(&self, ray: &Ray, accept: impl Fn(&Crossing) -> bool) -> Option<Crossing> {
        let mut best: Option<Crossing> = None;
        self.walk(ray, |crossing, limit| {
            let nearer = best.is_none_or(|b| (crossing.t, crossing.triangle) < (b.t, b.triangle));
            if nearer && accept(&crossing) {
                *limit = crossing.t;
                best = Some(crossing);
            }
        });
        best
    }

    /// Every accepted crossing, farthest first; of several at the same `t`, that of the higher triangle index comes first.
    pub fn all(&self, ray: &Ray, accept: impl Fn(&Crossing) -> bool) -> Vec<Crossing> {
        let mut found = Vec::new();
        self.walk(ray, |crossing, _| {
            if accept(&crossing) {
                found.push(crossing);
            }
        });
        found.sort_by(|a, b| b.t.total_cmp(&a.t).then(b.triangle.cmp(&a.triangle)));
        found
    }

    /// True where any crossing is accepted.
    pub fn any(&self, ray: &Ray, accept: impl Fn(&Crossing) -> bool) -> bool {
        let mut found = false;
        self.walk(ray, |crossing, limit| {
            if accept(&crossing) {
                found = true;
                *limit = f64::NEG_INFINITY;
            }
        });
        found
    }

    /// Shows every crossing up to the limit to `visit`, which may lower the limit.
    fn walk(&self, ray: &Ray, mut visit: impl FnMut(Crossing, &mut f64)) {
        let sheared = Sheared::new(ray.origin, ray.direction);
        let mut limit = ray.max;
        let Some(near) = self.nodes.first().and_then(|root| sheared.enter(root.min, root.max, ray.min..=limit)) else {
            return;
        };
        let mut stack = [(0u32, near); STACK];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (index, near) = stack[height];
            if near > limit {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                let first = node.first as usize;
                for &triangle in &self.order[first..first + node.count as usize] {
                    let crossing = sheared.cross(&self.corners[triangle as usize], triangle);
                    if let Some(crossing) = crossing.filter(|c| c.t >= ray.min && c.t <= limit) {
                        visit(crossing, &mut limit);
                    }
                }
                continue;
            }
            let [a, b] = [node.first, node.first + 1].map(|child| {
                let node = &self.nodes[child as usize];
                sheared.enter(node.min, node.max, ray.min..=limit).map(|near| (child, near))
            });
            let farther_first = match (a, b) {
                (Some(a), Some(b)) if a.1 < b.1 => [Some(b), Some(a)],
                either => [either.0, either.1],
            };
            for entry in farther_first.into_iter().flatten() {
                stack[height] = entry;
                height += 1;
            }
        }
    }
}

fn has_area(corners: &[DVec3; 3]) -> bool {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    normal.is_finite() && normal != DVec3::ZERO
}

fn padded_box(corners: &[DVec3; 3]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    corners.iter().for_each(|&corner| bounds.include(corner));
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let padding = DVec3::splat(largest * PADDING + f64::MIN_POSITIVE);
    Bounds { min: bounds.min - padding, max: bounds.max + padding }
}

fn join(a: Bounds, b: &Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}

fn half_area(bounds: &Bounds) -> f64 {
    let e = bounds.max - bounds.min;
    e.x * e.y + e.y * e.z + e.z * e.x
}

struct Build {
    boxes: Vec<Bounds>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Build {
    fn run(&mut self) {
        if self.order.is_empty() {
            return;
        }
        self.push(0..self.order.len());
        let mut open = vec![(0usize, 0..self.order.len(), 0usize)];
        while let Some((node, range, depth)) = open.pop() {
            if range.len() <= LEAF_TRIANGLES {
                continue;
            }
            let middle = self.split(&range, depth);
            let children = self.nodes.len();
            self.nodes[node].first = children as u32;
            self.nodes[node].count = 0;
            for (k, part) in [range.start..middle, middle..range.end].into_iter().enumerate() {
                self.push(part.clone());
                open.push((children + k, part, depth + 1));
            }
        }
    }

    /// Adds the range as a leaf.
    fn push(&mut self, range: Range<usize>) {
        let bounds = self.order[range.clone()].iter().fold(Bounds::EMPTY, |b, &id| join(b, &self.boxes[id as usize]));
        let (first, count) = (range.start as u32, range.len() as u32);
        self.nodes.push(Node { min: bounds.min, max: bounds.max, first, count });
    }

    /// Reorders the range and returns the first place of its second part; neither part is empty.
    fn split(&mut self, range: &Range<usize>, depth: usize) -> usize {
        let boxes = &self.boxes;
        let order = &mut self.order[range.clone()];
        let mut centers = Bounds::EMPTY;
        order.iter().for_each(|&id| centers.include(boxes[id as usize].center()));
        let extent = centers.max - centers.min;
        let axis = extent.max_position();
        let place = |id: u32| boxes[id as usize].center()[axis];
        let scale = BINS as f64 / extent[axis];
        let bin = |id: u32| (((place(id) - centers.min[axis]) * scale) as usize).min(BINS - 1);
        let cut = if depth < HALVING_DEPTH && extent[axis] > 0.0 { best_cut(order, boxes, bin) } else { None };
        let Some(cut) = cut else {
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |&a, &b| place(a).total_cmp(&place(b)));
            return range.start + half;
        };
        let mut middle = 0;
        for i in 0..order.len() {
            if bin(order[i]) <= cut {
                order.swap(i, middle);
                middle += 1;
            }
        }
        range.start + middle
    }
}

/// The last bin of the cheaper side, or `None` where all triangles share a bin.
fn best_cut(order: &[u32], boxes: &[Bounds], bin: impl Fn(u32) -> usize) -> Option<usize> {
    let mut bins = [(0usize, Bounds::EMPTY); BINS];
    for &id in order {
        let (count, bounds) = &mut bins[bin(id)];
        *count += 1;
        *bounds = join(*bounds, &boxes[id as usize]);
    }
    let mut right_cost = [0.0; BINS];
    let mut right = (0usize, Bounds::EMPTY);
    for i in (1..BINS).rev() {
        right = (right.0 + bins[i].0, join(right.1, &bins[i].1));
        right_cost[i] = if right.0 > 0 { right.0 as f64 * half_area(&right.1) } else { f64::INFINITY };
    }
    let mut left = (0usize, Bounds::EMPTY);
    let mut best: Option<(f64, usize)> = None;
    for (i, (count, bounds)) in bins.iter().enumerate().take(BINS - 1) {
        left = (left.0 + count, join(left.1, bounds));
        if left.0 == 0 {
            continue;
        }
        let cost = left.0 as f64 * half_area(&left.1) + right_cost[i + 1];
        if cost.is_finite() && best.is_none_or(|(lowest, _)| cost < lowest) {
            best = Some((cost, i));
        }
    }
    best.map(|(_, cut)| cut)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in -1..1 (a 64-bit linear congruential generator, Knuth's constants).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn point(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    /// Moller and Trumbore's test, which shares nothing with the one under test.
    fn distance(ray: &Ray, [a, b, c]: &[DVec3; 3]) -> Option<f64> {
        let (ab, ac) = (*b - *a, *c - *a);
        let p = ray.direction.cross(ac);
        let determinant = ab.dot(p);
        let s = ray.origin - *a;
        let q = s.cross(ab);
        let (u, v, t) = (s.dot(p) / determinant, ray.direction.dot(q) / determinant, ac.dot(q) / determinant);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.min && t <= ray.max).then_some(t)
    }

    fn ray(origin: DVec3, direction: DVec3) -> Ray {
        Ray { origin, direction, min: 0.0, max: f64::INFINITY }
    }

    #[test]
    fn equals_brute_force() {
        let mut numbers = Numbers(1);
        let corners: Vec<[DVec3; 3]> = (0..500)
            .map(|_| {
                let center = numbers.point() * 2.0;
                std::array::from_fn(|_| center + numbers.point() * 0.3)
            })
            .collect();
        let bvh = Bvh::new(corners.clone());
        let mut hits = 0;
        for _ in 0..500 {
            let ray = Ray { max: 3.0, ..ray(numbers.point() * 3.0, numbers.point()) };
            let all = corners.iter().enumerate().filter_map(|(id, c)| distance(&ray, c).map(|t| (t, id as u32)));
            let expected = all.min_by(|a, b| a.0.total_cmp(&b.0));
            let found = bvh.nearest(&ray, |_| true);
            assert_eq!(found.map(|c| c.triangle), expected.map(|(_, id)| id));
            assert_eq!(bvh.any(&ray, |_| true), expected.is_some());
            if let (Some(found), Some((t, id))) = (found, expected) {
                hits += 1;
                assert!((found.t - t).abs() < 1e-9 * t.max(1.0), "{} against {t}", found.t);
                // With the nearest refused, the next one is found or nothing.
                assert!(bvh.nearest(&ray, |c| c.triangle != id).is_none_or(|next| next.t >= found.t));
            }
        }
        assert!(hits > 50, "only {hits} of 500 rays hit: the comparison shows nothing");
    }

    #[test]
    fn a_grid_of_flat_quads_does_not_leak() {
        const SIDE: u32 = 16;
        let corner = |i: u32, j: u32| DVec3::new(f64::from(i) / 3.0, f64::from(j) / 7.0, -5.0);
        let mut corners = Vec::new();
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
            corners.push([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)]);
            corners.push([corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]);
        }
        let bvh = Bvh::new(corners);
        // Corners of the grid are hit exactly, both along the axis and from one point.
        for (i, j) in (0..=SIDE).flat_map(|i| (0..=SIDE).map(move |j| (i, j))) {
            let target = corner(i, j);
            let along = ray(DVec3::new(target.x, target.y, 0.0), DVec3::NEG_Z);
            let from = DVec3::new(0.1, 0.2, 0.3);
            assert!(bvh.any(&along, |_| true) && bvh.any(&ray(from, target - from), |_| true), "{i} {j}");
        }
    }

    #[test]
    fn equal_and_degenerate_triangles() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let mut corners = vec![line; 3];
        corners.extend([triangle; 100]);
        corners.push([DVec3::NAN, DVec3::X, DVec3::Y]);
        let bvh = Bvh::new(corners);
        let down = ray(DVec3::new(0.2, 0.2, 1.0), DVec3::NEG_Z);
        assert_eq!(bvh.nearest(&down, |_| true).map(|c| c.triangle), Some(3));
        assert_eq!(bvh.order.len(), 100);
        assert!(bvh.nodes.iter().all(|node| node.count as usize <= LEAF_TRIANGLES));
        assert!(!Bvh::new(vec![line]).any(&down, |_| true));
        assert!(!Bvh::new(Vec::new()).any(&down, |_| true));
    }
}
