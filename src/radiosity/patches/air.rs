//! The air of a cell: which places of it are joined by a way that no surface crosses.

use glam::DVec3;

use super::OFF_GRID;
use crate::reference::render::Reference;

/// Nodes along each axis of a cell.
const NODES: usize = 8;

/// Nodes of a cell, each with the number of the part of the air that it lies in. Neighbours that see each other are of one part: a wall without a hole
/// parts the air however thin it is.
pub(super) struct Air {
    low: DVec3,
    step: f64,
    parts: Vec<usize>,
}

impl Air {
    /// Of a cell of such a width.
    pub(super) fn new(cell: [i64; 3], occluders: &Reference, size: f64) -> Self {
        Self::from(DVec3::from_array(cell.map(|x| x as f64)).map(|x| (x - OFF_GRID) * size), occluders, size)
    }

    fn from(low: DVec3, occluders: &Reference, size: f64) -> Self {
        let mut air = Self { low, step: size / NODES as f64, parts: (0..NODES.pow(3)).collect() };
        for index in 0..air.parts.len() {
            for stride in [1, NODES, NODES * NODES] {
                let is_last = index / stride % NODES == NODES - 1;
                if !is_last && !occluders.is_blocked(air.node(index), air.node(index + stride)) {
                    let [a, b] = [index, index + stride].map(|node| air.root(node));
                    air.parts[a.max(b)] = a.min(b);
                }
            }
        }
        for index in 0..air.parts.len() {
            air.parts[index] = air.root(index);
        }
        air
    }

    fn node(&self, index: usize) -> DVec3 {
        let at = [index % NODES, index / NODES % NODES, index / (NODES * NODES)];
        self.low + (DVec3::from_array(at.map(|x| x as f64)) + 0.5) * self.step
    }

    fn root(&self, mut index: usize) -> usize {
        while self.parts[index] != index {
            index = self.parts[index];
        }
        index
    }

    /// The part of the air about a place: that of the nearest node it sees, of those next to it.
    pub(super) fn of(&self, place: DVec3, occluders: &Reference) -> Option<usize> {
        let at = ((place - self.low) / self.step).floor();
        let mut near: Vec<(f64, usize)> = (0..27)
            .filter_map(|k| {
                let beside = at + DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) - 1.0;
                let inside = beside.min_element() >= 0.0 && beside.max_element() < NODES as f64;
                let [x, y, z] = beside.to_array().map(|x| x.max(0.0) as usize);
                inside.then_some((z * NODES + y) * NODES + x)
            })
            .map(|index| (self.node(index).distance_squared(place), index))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let seen = near.into_iter().find(|(_, index)| !occluders.is_blocked(place, self.node(*index)));
        seen.map(|(_, index)| self.parts[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;
    use crate::scene::view::View;

    /// R14: a wall of no thickness parts the air, one with a door does not.
    #[test]
    fn a_closed_wall_parts_the_air() {
        for (spec, parted) in [("corridor:door=0", true), ("corridor", false)] {
            let scene = builtin::load(spec).expect("a built-in scene");
            let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
            // About the middle of the wall at x = 0.
            let air = Air::from(DVec3::new(-1.2, 0.1, -1.2), &occluders, 2.4);
            let of = |x: f64| air.of(DVec3::new(x, 1.0, 0.5), &occluders).expect("air");
            assert_eq!(of(-0.7) != of(0.7), parted, "{spec}");
        }
    }
}
