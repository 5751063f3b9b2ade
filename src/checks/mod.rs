//! Hard cases and equalities as rows that anyone can run on their driver: `check` prints them, tests assert them.

mod agreement;
mod bytes;
mod clusters;
mod deferred;
mod equalities;
mod hard;
mod judge;
mod layout;
mod light_tree;
mod list_sort;
mod lists;
mod million;
mod msaa;
mod octahedral;
mod oracle;
mod prims;
mod radiosity;
mod shadows;
mod shapes;
mod spots;
mod subsets;
mod textured;
mod transparent;
mod waste;

use crate::error::Result;
use crate::plan::{Request, Technique};
use crate::renderer::Renderer;

pub use judge::{Judged, judge};
pub use oracle::{interior, scenes, shading_error, whole_picture_error};
#[cfg(test)]
pub(crate) use subsets::scene_of_every_effect;

/// Result of one check.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Short name; starts with the row of the table of hard cases where there is one.
    pub name: String,
    /// Held or not.
    pub passed: bool,
    /// The figure and its bound.
    pub detail: String,
}

impl Row {
    /// A row whose figure must not pass `bound`.
    pub fn at_most(name: impl Into<String>, figure: f64, bound: f64) -> Self {
        // A figure that is not a number has failed.
        Self { name: name.into(), passed: figure <= bound, detail: format!("{figure:.3e}, at most {bound:.0e}") }
    }

    /// A row whose count must be 0.
    pub fn none(name: impl Into<String>, count: usize, what: &str) -> Self {
        Self { name: name.into(), passed: count == 0, detail: format!("{count} {what}") }
    }
}

/// A check: gives its rows or says why it could not run.
pub type Check = fn(&Renderer) -> Result<Vec<Row>>;

/// Checks that take minutes, run besides by `check --deep`.
pub const DEEP: &[(&str, Check)] = &[
    ("projection_deep", hard::culling::projection_deep),
    ("million", million::million),
    ("twins_deep", hard::twins::twins_deep),
    ("waste_deep", waste::waste_deep),
    ("shapes_deep", shapes::shapes),
];

/// What most checks draw: `auto` would choose by cost.
fn forward() -> Request {
    Request { technique: Technique::Forward, ..Request::default() }
}

/// Every check with its name.
pub const ALL: &[(&str, Check)] = &[
    ("layout", layout::layout),
    ("prepass", equalities::prepass),
    ("fetch", equalities::fetch),
    ("still", equalities::still),
    ("agreement", agreement::agreement),
    ("fetches", agreement::fetches),
    ("octahedral", octahedral::octahedral),
    ("sort", prims::sort),
    ("scan", prims::scan),
    ("tiled", lists::tiled),
    ("tile_lists", lists::tile_lists),
    ("tile_waste", waste::tile_waste),
    ("waste", waste::waste),
    ("twenty_runs", bytes::twenty_runs),
    ("given_bounds", bytes::given_bounds),
    ("given_depth", bytes::given_depth),
    ("clustered", clusters::clustered),
    ("cluster_lists", clusters::cluster_lists),
    ("cluster_waste", clusters::cluster_waste),
    ("cluster_slices", clusters::cluster_slices),
    ("cluster_cases", clusters::cluster_cases),
    ("cluster_trees", clusters::cluster_trees),
    ("cluster_normals", clusters::cluster_normals),
    ("deferred", deferred::deferred),
    ("markers", deferred::markers),
    ("volumes", deferred::volumes),
    ("light_tree", light_tree::light_tree),
    ("list_sort", list_sort::list_sort),
    ("shading", oracle::shading),
    ("picture", oracle::picture),
    ("samplers", textured::samplers),
    ("material_maps", textured::maps),
    ("material_modes", textured::modes),
    ("parallax", textured::parallax),
    ("material_models", textured::material_models),
    ("subsets", subsets::subsets),
    ("spot_lists", spots::spot_lists),
    ("shadow_error", shadows::shadow_error),
    ("shadow_acne", shadows::shadow_acne),
    ("shadow_leaks", shadows::shadow_leaks),
    ("shadow_cones", shadows::shadow_cones),
    ("shadows_still", shadows::shadows_still),
    ("shadow_agreement", shadows::shadow_agreement),
    ("shadow_maps", shadows::shadow_maps),
    ("radiosity_twin", radiosity::radiosity_twin),
    ("radiosity_direct", radiosity::radiosity_direct),
    ("radiosity_furnace", radiosity::radiosity_furnace),
    ("radiosity_leaks", radiosity::radiosity_leaks),
    ("radiosity_agreement", radiosity::radiosity_agreement),
    ("radiosity_path", radiosity::radiosity_path),
    ("radiosity_moving", radiosity::radiosity_moving),
    ("radiosity_sight", radiosity::radiosity_sight),
    ("radiosity_hard", radiosity::radiosity_hard),
    ("msaa", msaa::msaa),
    ("msaa_bar", msaa::msaa_bar),
    ("msaa_edges", msaa::msaa_edges),
    ("transparency", transparent::transparency),
    ("transparent_bounds", transparent::transparent_bounds),
    ("transparent_layer", transparent::transparent_layer),
    ("projection", hard::culling::projection),
    ("tiles", hard::tiles::tiles),
    ("gap", hard::tiles::gap),
    ("depths", hard::tiles::depths),
    ("spot_cones", hard::cones::spot_cones),
    ("range_edge", hard::ranges::range_edge),
    ("light_on_surface", hard::ranges::light_on_surface),
    ("attenuations", hard::ranges::attenuations),
    ("many_lights", hard::sums::many_lights),
    ("long_loops", hard::sums::long_loops),
    ("light_parts", hard::parts::light_parts),
    ("lights_65536", million::many),
    ("radiance_range", hard::sums::radiance_range),
    ("surface_fallbacks", hard::surfaces::surface_fallbacks),
    ("far_camera", hard::views::far_camera),
    ("lenses", hard::views::lenses),
    ("node_transforms", hard::nodes::node_transforms),
];
