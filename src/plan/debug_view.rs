//! Pictures of intermediate values, and what each of them needs.

use super::{DepthBounds, Plan, Tiles};
use crate::error::{Error, Result};

/// Pictures of intermediate values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DebugView {
    /// Linear base colour.
    Albedo,
    /// View-space shading normal, -1..1 mapped to 0..1.
    Normals,
    /// Distance along the view axis in false colour.
    Depth,
    /// The depth buffer's own value.
    DepthRaw,
    /// Nearest distance of each tile's samples.
    TileMin,
    /// Farthest distance of each tile's samples.
    TileMax,
    /// Length of the list of each pixel's tile.
    TileLights,
    /// Occupied slots of each tile's 2.5D mask.
    TileMask,
    /// Which pixels share a cluster.
    Clusters,
    /// Length of the list of each pixel's cluster.
    ClusterLights,
    /// Slice that each pixel's sample lies in.
    Slices,
    /// Bounding rectangles of lights over the lit picture.
    Quads,
    /// Lights that reach a pixel and are not in its list, over the lit picture.
    Missed,
    /// Listed over reaching lights of each pixel.
    Waste,
    /// Lights that reach each pixel.
    Lights,
    /// Base colour as the G-buffer stores it.
    GbufferAlbedo,
    /// View-space shading normal as the G-buffer stores it.
    GbufferNormal,
    /// Roughness, metalness and occlusion as the G-buffer stores them.
    GbufferMaterial,
    /// Emission as the G-buffer stores it.
    GbufferEmission,
}

impl DebugView {
    /// Every view with its typed name.
    pub const ALL: [(&'static str, Self); 19] = [
        ("albedo", Self::Albedo),
        ("normals", Self::Normals),
        ("depth", Self::Depth),
        ("depth-raw", Self::DepthRaw),
        ("tile-min", Self::TileMin),
        ("tile-max", Self::TileMax),
        ("tile-lights", Self::TileLights),
        ("tile-mask", Self::TileMask),
        ("clusters", Self::Clusters),
        ("cluster-lights", Self::ClusterLights),
        ("slices", Self::Slices),
        ("quads", Self::Quads),
        ("missed", Self::Missed),
        ("waste", Self::Waste),
        ("lights", Self::Lights),
        ("gbuffer-albedo", Self::GbufferAlbedo),
        ("gbuffer-normal", Self::GbufferNormal),
        ("gbuffer-material", Self::GbufferMaterial),
        ("gbuffer-emission", Self::GbufferEmission),
    ];

    /// As typed.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|view| view.1 == self).map_or("", |view| view.0)
    }

    /// Shows what the surface frame stores. For the others the picture is lit.
    pub fn of_surfaces(self) -> bool {
        matches!(self, Self::Albedo | Self::Normals | Self::Depth | Self::DepthRaw)
    }

    /// Shows what the G-buffer of a deferred technique stores.
    pub fn of_gbuffer(self) -> bool {
        matches!(self, Self::GbufferAlbedo | Self::GbufferNormal | Self::GbufferMaterial | Self::GbufferEmission)
    }

    /// Shows numbers of lists, or of the depths that lists are made from.
    pub fn of_lists(self) -> bool {
        !self.of_surfaces() && !self.of_gbuffer() && self != Self::Quads
    }

    /// Shows what only lists of tiles have.
    fn of_tiles(self) -> bool {
        matches!(self, Self::TileMin | Self::TileMax | Self::TileLights | Self::TileMask)
    }

    /// Shows what only a technique with clusters has.
    pub fn of_clusters(self) -> bool {
        matches!(self, Self::Clusters | Self::ClusterLights | Self::Slices)
    }

    /// Shows what the f64 oracle finds.
    pub fn of_oracle(self) -> bool {
        matches!(self, Self::Missed | Self::Waste | Self::Lights)
    }

    /// Is drawn over the lit picture.
    pub fn over_lit(self) -> bool {
        matches!(self, Self::Quads | Self::Missed)
    }

    /// Refuses a view of what the plan does not make.
    ///
    /// # Errors
    /// One sentence: what the view shows, and what is there instead.
    pub(super) fn check(self, plan: &Plan) -> Result<()> {
        let refuse = |why: String| Err(Error::usage(format!("--debug-view {} {why}", self.name())));
        let technique = plan.technique.name();
        match &plan.tiles {
            _ if self.of_gbuffer() && plan.deferred.is_none() => {
                refuse(format!("shows a G-buffer, and {technique} makes none"))
            }
            _ if self.of_clusters() && plan.clusters.is_none() => {
                refuse(format!("shows clusters, and {technique} makes none"))
            }
            _ if self.of_tiles() && plan.walks_tree() => refuse(
                "shows lists of tiles or what they know, and clusters walk through the light hierarchy here".into(),
            ),
            Some(tiles) => self.lack(tiles).map_or(Ok(()), refuse),
            None => match self {
                Self::TileMin | Self::TileMax | Self::TileLights | Self::TileMask | Self::Missed | Self::Waste => {
                    refuse(format!("shows light lists, and {technique} makes none"))
                }
                _ => Ok(()),
            },
        }
    }

    /// What tiles lack that the view shows.
    fn lack(self, tiles: &Tiles) -> Option<String> {
        match (self, tiles.bounds) {
            (Self::TileMin | Self::TileMax, DepthBounds::Off) => {
                Some("shows the depth bounds of tiles, which --depth-bounds off and --prepass off leave out".into())
            }
            (Self::TileMask, DepthBounds::Off | DepthBounds::MinMax) => {
                Some(format!("shows the mask of --depth-bounds 2.5d, which is {} here", tiles.bounds.name()))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Request, Technique};
    use crate::scene::builtin;

    /// Names of the views that are refused.
    fn refused(technique: Technique) -> Vec<&'static str> {
        let scene = builtin::load("cornell").expect("a built-in scene");
        let request = Request { width: 64, height: 64, technique, ..Request::default() };
        let planned =
            |view| Plan::new(&scene, &Request { debug_view: Some(view), ..request.clone() }, &Limits::MINIMUM);
        DebugView::ALL.iter().filter(|view| planned(view.1).is_err()).map(|view| view.0).collect()
    }

    #[test]
    fn views_are_refused_where_nothing_makes_what_they_show() {
        let tiles = ["tile-min", "tile-max", "tile-lights", "tile-mask"];
        let clusters = ["clusters", "cluster-lights", "slices"];
        let lists = [&tiles[..], &clusters, &["missed", "waste"]].concat();
        let gbuffer = ["gbuffer-albedo", "gbuffer-normal", "gbuffer-material", "gbuffer-emission"];
        assert_eq!(refused(Technique::Forward), [&lists[..], &gbuffer].concat());
        assert_eq!(refused(Technique::Deferred), lists);
        assert_eq!(refused(Technique::TiledForward), [&clusters[..], &gbuffer].concat());
        assert_eq!(refused(Technique::TiledDeferred), clusters);
        // Their tiles have no mask unless it is asked for.
        assert_eq!(refused(Technique::ClusteredForward), [&["tile-mask"][..], &gbuffer].concat());
        assert_eq!(refused(Technique::ClusteredDeferred), ["tile-mask"]);
    }
}
