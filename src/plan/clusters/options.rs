//! What clusters take of a request's options, and which of them they refuse.

use crate::error::{Error, Result};
use crate::plan::{AssignChoice, ClusterBounds, DepthBounds, GbufferLayout, Request, Technique};

/// The request as tiles get it: clusters know depths better than a mask, so their candidates have one only where it is asked for.
///
/// # Errors
/// Clusters by normal, where the technique has no normals; a source of candidates where it has no clusters; depth bounds of tiles that make
/// no lists.
pub(in crate::plan) fn asked(technique: Technique, request: Request) -> Result<Request> {
    let bounded = request.depth_bounds.filter(|bounds| *bounds != DepthBounds::Off);
    let assign = match (request.assign, bounded) {
        (AssignChoice::Auto, None) => AssignChoice::Auto,
        (asked, _) if asked != AssignChoice::Auto && !technique.clusters() => {
            let (asked, name) = (asked.name(), technique.name());
            return Err(Error::usage(format!("--assign {asked} is for clusters, which {name} does not make")));
        }
        (AssignChoice::Tree, Some(bounds)) => {
            let bounds = bounds.name();
            return Err(Error::usage(format!(
                "--depth-bounds {bounds} is for lists of tiles, and --assign tree makes none"
            )));
        }
        (AssignChoice::Tree, None) => AssignChoice::Tree,
        // Lists of tiles alone know depth bounds.
        (AssignChoice::Auto, Some(_)) | (AssignChoice::Tiles, _) => AssignChoice::Tiles,
    };
    if request.msaa > 1 && technique.clusters() {
        let refused = |option: &str| {
            let count = request.msaa;
            Err(Error::usage(format!(
                "{option} knows one sample a pixel: clusters of {count} are flagged by their samples"
            )))
        };
        if let Some(bounds) = bounded {
            return refused(&format!("--depth-bounds {}", bounds.name()));
        }
        if request.cluster_bounds == Some(ClusterBounds::Explicit) {
            return refused("--cluster-bounds explicit");
        }
        if request.cluster_normals {
            return refused("--cluster-normals");
        }
        // A position between samples may lie between their depths.
        return Ok(Request { depth_bounds: Some(DepthBounds::Off), assign, ..request });
    }
    let least = technique.clusters().then_some(DepthBounds::MinMax);
    Ok(Request { depth_bounds: request.depth_bounds.or(least), assign, ..request })
}

/// Refuses clusters that tell directions where no codes of normals are, or no samples. `request` is what was typed.
///
/// # Errors
/// Such a request.
pub(in crate::plan) fn check_normals(technique: Technique, request: &Request) -> Result<()> {
    if !request.cluster_normals {
        return Ok(());
    }
    if technique != Technique::ClusteredDeferred {
        let name = technique.name();
        return Err(Error::usage(format!(
            "--cluster-normals is for clusters over a G-buffer, which {name} does not make"
        )));
    }
    if !request.prepass {
        return Err(Error::usage("--cluster-normals is for clusters that are made of samples: it needs a pre-pass"));
    }
    if request.gbuffer != GbufferLayout::Compact {
        return Err(Error::usage("--cluster-normals reads the codes of normals, which --gbuffer fat does not store"));
    }
    Ok(())
}
