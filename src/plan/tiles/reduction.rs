//! What reduces the depths of a tile: one thread, or a group of them.

use crate::error::{Error, Result};
use crate::plan::{DepthBounds, Limits, Plan, Request};

/// What has no depths to reduce refuses a way to do it.
///
/// # Errors
/// A way that was asked for.
pub(in crate::plan) fn check_reduction(plan: &Plan, request: &Request) -> Result<()> {
    let reduces = plan.tiles.as_ref().is_some_and(|tiles| tiles.bounds != DepthBounds::Off);
    if request.group_a_tile.is_some() && !reduces {
        let name = plan.technique.name();
        return Err(Error::usage(format!(
            "--depth-reduce is for lists of tiles with depth bounds, which {name} as it is asked for does not make"
        )));
    }
    Ok(())
}

/// As asked, or what the profile has as quicker.
pub(super) fn group_a_tile(request: &Request, limits: &Limits) -> bool {
    let quicker = || limits.profile.as_ref().is_some_and(|profile| profile.group_bounds < profile.bounds);
    request.group_a_tile.unwrap_or_else(quicker)
}
