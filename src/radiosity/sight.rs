//! Who looks whether anything stands between two points of surfaces: the CPU in f64, or a device that leaves to the CPU what f32 cannot tell.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::reference::render::Reference;

/// In the place of a triangle's index: the point lies on none.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Pairs of patches that are looked at together on the CPU: enough for all cores.
const BATCH_PAIRS: usize = 1 << 14;

/// From one point of a surface to another, world space, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins.
    pub from: DVec3,
    /// Where it ends.
    pub to: DVec3,
    /// The triangles that both lie on, counted over all instances of the scene, or [`NO_TRIANGLE`]: they are not in the way.
    pub triangles: [u32; 2],
}

/// See the module. All give the same answers.
pub trait Sight: Sync {
    /// Of each segment of each list: nothing stands in the way.
    ///
    /// # Errors
    /// A lost device.
    fn open(&self, segments: &[&[Segment]]) -> Result<Vec<Vec<bool>>>;

    /// Pairs of patches worth looking at together.
    fn batch_pairs(&self) -> usize;
}

impl Sight for Reference<'_> {
    fn open(&self, segments: &[&[Segment]]) -> Result<Vec<Vec<bool>>> {
        let of = |run: &&[Segment]| run.iter().map(|s| !self.is_blocked_past(s.from, s.to, s.triangles)).collect();
        Ok(segments.par_iter().map(of).collect())
    }

    fn batch_pairs(&self) -> usize {
        BATCH_PAIRS
    }
}
