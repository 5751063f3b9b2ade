//! Sums over more lights than a driver's loops go round: how many passes continue one sum, and how many lights each of them adds.
//!
//! A shader invocation makes at most `Limits::max_loop_iterations` iterations, all its loops together. The seeking loops of shade.glsl and
//! shade_list.glsl test n lights and shade at most n; each group of 32 ends two inner loops and goes round the outer one, and that ends
//! once: 2 n + 3 ceil(n / 32) + 1. The plain loops go round once a light.

use super::{Limits, Plan, Technique};
use crate::error::{Error, Result};

/// Lights that the seeking loops test at once; parts of them are whole groups.
const GROUP: u32 = 32;

/// Lights of a sum that is drawn in parts: their number stands in the alpha channel between passes, an f32.
const MOST_LIGHTS: u32 = 1 << 24;

/// Passes of one sum, at most: each takes descriptors, two timestamps and a draw of the whole scene.
const MOST_PARTS: u32 = 256;

/// How a sum over lights is parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightParts {
    /// Passes: 1 nearly always.
    pub count: u32,
    /// Lights that each of them adds, at most.
    pub lights: u32,
}

/// A loop over lights, as long as it may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sum {
    /// Lights of the loop.
    pub lights: u32,
    /// Lights that the first pass adds before it, one by one.
    pub ahead: u32,
    /// It seeks.
    pub seek: bool,
}

impl Sum {
    /// Iterations of a pass that adds everything.
    pub fn iterations(&self) -> u64 {
        let (lights, ahead) = (u64::from(self.lights), u64::from(self.ahead));
        ahead + if self.seek { 2 * lights + 3 * lights.div_ceil(u64::from(GROUP)) + 1 } else { lights }
    }

    /// One pass carries it out.
    pub fn fits(&self, limits: &Limits) -> bool {
        self.iterations() <= u64::from(limits.max_loop_iterations)
    }

    /// Lights that a pass can add beside those ahead.
    fn most_lights(&self, limits: &Limits) -> u32 {
        let left = limits.max_loop_iterations.saturating_sub(self.ahead);
        if self.seek { left.saturating_sub(1) / (2 * GROUP + 3) * GROUP } else { left }
    }
}

impl LightParts {
    /// A sum that one pass adds up.
    pub const WHOLE: Self = Self { count: 1, lights: u32::MAX };

    /// As few parts as the driver's loops allow; `None` where parts do not help.
    pub(super) fn of(sum: &Sum, limits: &Limits) -> Option<Self> {
        if sum.fits(limits) {
            return Some(Self::WHOLE);
        }
        let lights = sum.most_lights(limits);
        if lights == 0 || sum.lights > MOST_LIGHTS {
            return None;
        }
        let count = sum.lights.div_ceil(lights);
        (count <= MOST_PARTS).then_some(Self { count, lights })
    }

    /// Decides for a plan whose lights and lists are known, and notes what is unusual.
    ///
    /// # Errors
    /// Loops that the driver would cut short, where the technique has no parts or where they do not help.
    pub(super) fn new(plan: &mut Plan, limits: &Limits) -> Result<Self> {
        let Some((sum, what)) = longest_sum(plan) else { return Ok(Self::WHOLE) };
        let in_parts =
            matches!(plan.technique, Technique::Forward | Technique::TiledForward | Technique::ClusteredForward);
        let parts = if in_parts { Self::of(&sum, limits) } else { sum.fits(limits).then_some(Self::WHOLE) };
        let (lights, most) = (sum.lights, limits.max_loop_iterations);
        let Some(parts) = parts else {
            let iterations = sum.iterations();
            let way_out = if plan.tiles.is_some() { "; smaller tiles have shorter lists" } else { ", in parts too" };
            return Err(Error::new(format!(
                "{what} {lights} lights, which take up to {iterations} iterations; this driver leaves its loops after {most}{way_out}"
            )));
        };
        if parts.count > 1 {
            plan.notes.push(format!(
                "{what} {lights} lights, which {} passes add up: this driver leaves its loops after {most} iterations",
                parts.count
            ));
        }
        Ok(parts)
    }
}

/// The longest loop over lights of any sample, and in words what loops; `None` where there is none, or plan/gbuffer.rs has seen to it.
fn longest_sum(plan: &Plan) -> Option<(Sum, &'static str)> {
    let whole = |seek| Sum { lights: plan.lights.count, ahead: 0, seek };
    let listed = |lights, seek| {
        let ahead = plan.tiles.as_ref().map_or(0, |tiles| tiles.grid.first_light);
        Sum { lights, ahead, seek }
    };
    match (plan.technique, &plan.clusters, &plan.tiles) {
        _ if plan.shows_surfaces() => None,
        (_, Some(clusters), _) => Some((listed(clusters.longest_list, false), "a cluster may hold")),
        (_, None, Some(tiles)) => Some((listed(tiles.longest_tile, tiles.list_seek), "a tile may hold")),
        (Technique::Forward | Technique::TiledForward | Technique::ClusteredForward, ..) => {
            Some((whole(plan.lights.seek), "a fragment loops over"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(max_loop_iterations: u32) -> Limits {
        Limits { max_loop_iterations, ..Limits::MINIMUM }
    }

    fn sum(lights: u32, ahead: u32, seek: bool) -> Sum {
        Sum { lights, ahead, seek }
    }

    #[test]
    fn one_part_wherever_one_pass_goes_round() {
        for (lights, ahead, seek) in [(31_298, 0, true), (65_535, 0, false), (65_530, 5, false), (0, 65_535, false)] {
            assert_eq!(LightParts::of(&sum(lights, ahead, seek), &limits(65_535)), Some(LightParts::WHOLE), "{lights}");
        }
        assert_eq!(LightParts::of(&sum(1 << 30, 7, true), &Limits::MINIMUM), Some(LightParts::WHOLE));
    }

    #[test]
    fn parts_go_round_and_hold_every_light() {
        for (lights, ahead, seek) in
            [(31_299, 0, true), (1_000_000, 0, true), (65_536, 0, false), (1_000_000, 3, false), (4_000_000, 40, true)]
        {
            let parts = LightParts::of(&sum(lights, ahead, seek), &limits(65_535)).expect("parts help");
            assert!(parts.count > 1 && u64::from(parts.count) * u64::from(parts.lights) >= u64::from(lights));
            assert!(parts.lights < lights && sum(parts.lights, ahead, seek).fits(&limits(65_535)));
            assert!(!seek || parts.lights.is_multiple_of(GROUP));
            let fewer = lights.div_ceil(parts.count - 1).next_multiple_of(if seek { GROUP } else { 1 });
            assert!(!sum(fewer, ahead, seek).fits(&limits(65_535)), "{lights}: a part too many");
        }
        let million = LightParts::of(&sum(1_000_000, 0, true), &limits(65_535));
        assert_eq!(million, Some(LightParts { count: 32, lights: 31_296 }));
    }

    #[test]
    fn where_parts_do_not_help_there_are_none() {
        // No group fits; no light fits beside those ahead; more passes or lights than there may be.
        for (lights, ahead, seek, most) in
            [(33, 0, true, 67), (100, 50, false, 50), (257 * 100, 0, false, 100), ((1 << 24) + 1, 0, false, 1 << 20)]
        {
            assert_eq!(LightParts::of(&sum(lights, ahead, seek), &limits(most)), None, "{lights}");
        }
        assert_eq!(LightParts::of(&sum(33, 0, true), &limits(68)), Some(LightParts { count: 2, lights: 32 }));
    }
}
