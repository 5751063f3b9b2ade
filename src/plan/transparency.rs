//! Transparency: which lights blended surfaces loop over, and what the picture is mixed in.
//!
//! Opaque lists are pruned by the nearest and the farthest opaque sample, and would lose the lights of glass in front of them. With bounds of
//! their own (M. Billeter, O. Olsson, U. Assarsson, "Tiled Forward Shading", GPU Pro 4, 2013) blended surfaces have lists of their own: of
//! tiles that hold blended fragments at all, from the nearest of these to the opaque sample behind it; of clusters that such fragments flag.
//! Merged bounds hold both kinds of samples, and one list serves both. Without bounds, lists of blended surfaces know nothing of depths.

use super::clusters::Clusters;
use super::effects::Effect;
use super::light_parts::Sum;
use super::request::{DepthBounds, Technique, TransparentBounds, TransparentSort};
use super::{Limits, Plan, Request, Tiles};
use crate::error::{Error, Result};
use crate::scene::view::View;
use crate::scene::{AlphaMode, Scene};

/// What a fragment of a blended surface loops over.
#[derive(Debug, Clone)]
pub enum TransparentLists {
    /// All lights.
    AllLights,
    /// The lists of opaque surfaces: nothing is known of depths, or tiles hold both kinds of samples.
    Shared,
    /// Lists of tiles beside those of opaque surfaces.
    Tiles {
        /// What they know of depths.
        bounds: DepthBounds,
    },
    /// Lists of clusters beside those of opaque surfaces: of clusters that blended fragments flag, or of every slice of every tile.
    Clusters(Box<Clusters>),
}

/// What the plan decided about blended surfaces.
#[derive(Debug, Clone)]
pub struct Transparency {
    /// Lists that fragments loop over.
    pub lists: TransparentLists,
    /// What these lists know of depths.
    pub bounds: TransparentBounds,
    /// In which order surfaces are drawn.
    pub sort: TransparentSort,
    /// Lights, or listed ones, are tested for their range before they are shaded.
    pub seek: bool,
    /// Surfaces are mixed in an image of 16-bit floats of their own and then with the picture: this device does not blend 32-bit floats.
    pub layer: bool,
}

impl Transparency {
    /// Decides for the plan's technique; `None` where nothing is blended.
    ///
    /// # Errors
    /// Bounds that the technique does not have, or a loop that the driver cuts short.
    pub(super) fn new(plan: &mut Plan, request: &Request, extent: f64, limits: &Limits) -> Result<Option<Self>> {
        if plan.geometry.blended.is_empty() || plan.shows_surfaces() {
            if request.transparent_bounds.is_some() {
                plan.notes.push("--transparent-bounds: nothing in this scene is blended".into());
            }
            if request.transparent_sort != TransparentSort::Object {
                plan.notes.push("--transparent-sort: nothing in this scene is blended".into());
            }
            return Ok(None);
        }
        let mut bounds = request.transparent_bounds.unwrap_or(TransparentBounds::Own);
        if plan.technique == Technique::Reference && request.transparent_sort != TransparentSort::Object {
            plan.notes.push("--transparent-sort: the reference mixes surfaces in the order of each ray".into());
        }
        check_bounds(plan, request)?;
        let clusters = plan.clusters.as_ref().zip(plan.tiles.as_ref());
        let lists = match (clusters, &plan.tiles) {
            (Some((clusters, _)), _) if !clusters.keyed => TransparentLists::Shared,
            (Some((clusters, tiles)), _) => {
                let flagged = bounds == TransparentBounds::Own && limits.fragment_stores;
                if bounds == TransparentBounds::Own && !flagged {
                    bounds = TransparentBounds::None;
                    plan.notes.push(
                        "this device's fragment shaders write no buffers: every slice of every tile is a cluster of blended surfaces".into(),
                    );
                }
                match clusters.for_blended(tiles, flagged, limits) {
                    Ok(lists) => TransparentLists::Clusters(Box::new(lists)),
                    Err(error) if clusters.tree.is_none() => {
                        let bounds = if flagged { tiles.bounds } else { DepthBounds::Off };
                        plan.notes.push(format!("{error}: blended surfaces have lists of tiles instead"));
                        TransparentLists::Tiles { bounds }
                    }
                    Err(error) => return Err(error),
                }
            }
            (None, Some(tiles)) => of_tiles(tiles, bounds),
            (None, None) => TransparentLists::AllLights,
        };
        if matches!(lists, TransparentLists::Shared) && bounds == TransparentBounds::Own {
            bounds = TransparentBounds::None;
        }
        if let Some(tiles) = plan.tiles.as_mut() {
            tiles.set_farthest(farthest(extent, &plan.view));
            tiles.merged = matches!(lists, TransparentLists::Shared) && bounds == TransparentBounds::Merged;
        }
        let layer = !limits.float_blend && plan.technique != Technique::Reference;
        if layer {
            plan.notes
                .push("this device does not blend 32-bit floats: blended surfaces are mixed in 16-bit floats".into());
        }
        let seek = seek(plan, &lists, limits)?;
        Ok(Some(Self { lists, bounds, sort: request.transparent_sort, seek, layer }))
    }

    /// Clusters of blended surfaces, where they have some.
    pub fn clusters(&self) -> Option<&Clusters> {
        match &self.lists {
            TransparentLists::Clusters(clusters) => Some(clusters),
            _ => None,
        }
    }

    /// Bytes of lists and images that blended surfaces add.
    pub fn bytes(&self, plan: &Plan) -> u64 {
        let lists = match (&self.lists, &plan.tiles) {
            (TransparentLists::Tiles { bounds }, Some(tiles)) => tiles.list_bytes(*bounds),
            (TransparentLists::Clusters(clusters), Some(tiles)) => match &clusters.tree {
                // The tree is there already.
                Some(tree) => clusters.bytes() - tree.bytes(),
                None => clusters.bytes() + tiles.list_bytes(tiles.bounds),
            },
            _ => 0,
        };
        let (pixels, samples) = (plan.pixels(), u64::from(plan.samples));
        let depth = if self.needs_depth(plan) { pixels * samples * super::DEPTH_BYTES } else { 0 };
        // The layer, and the picture that it is mixed into.
        let layer = pixels * (samples * super::RADIANCE_BYTES / 2 + super::RADIANCE_BYTES);
        lists + depth + if self.layer { layer } else { 0 }
    }

    /// The nearest blended fragment of each pixel is asked for.
    pub fn needs_depth(&self, plan: &Plan) -> bool {
        let bounded = |bounds: DepthBounds| bounds != DepthBounds::Off;
        match &self.lists {
            TransparentLists::Tiles { bounds } => bounded(*bounds),
            TransparentLists::Shared => plan.tiles.as_ref().is_some_and(|tiles| tiles.merged),
            TransparentLists::Clusters(clusters) => {
                clusters.keyed
                    && clusters.tree.is_none()
                    && plan.tiles.as_ref().is_some_and(|tiles| bounded(tiles.bounds))
            }
            TransparentLists::AllLights => false,
        }
    }
}

fn check_bounds(plan: &mut Plan, request: &Request) -> Result<()> {
    let Some(asked) = request.transparent_bounds else { return Ok(()) };
    let refused = |why: String| Err(Error::usage(format!("--transparent-bounds {}: {why}", asked.name())));
    let name = plan.technique.name();
    match (&plan.tiles, &plan.clusters) {
        (None, _) if plan.technique.has_lists() => {
            plan.notes
                .push(format!("--transparent-bounds {}: no light ends anywhere, nothing is listed", asked.name()));
            Ok(())
        }
        (None, _) => refused(format!("{name} has no light lists")),
        (_, Some(_)) if asked == TransparentBounds::Merged => {
            refused(format!("{name} keeps blended fragments in clusters of their own; merged bounds are for tiles"))
        }
        (_, Some(clusters)) if !clusters.keyed && asked != TransparentBounds::None => {
            refused("clusters are made of samples only after a depth pre-pass".into())
        }
        (Some(tiles), None) if tiles.bounds == DepthBounds::Off && asked != TransparentBounds::None => {
            refused("these lists know nothing of depths".into())
        }
        _ => Ok(()),
    }
}

fn of_tiles(tiles: &Tiles, bounds: TransparentBounds) -> TransparentLists {
    match (tiles.bounds, bounds) {
        (DepthBounds::Off, _) | (_, TransparentBounds::Merged) => TransparentLists::Shared,
        (known, TransparentBounds::Own) => TransparentLists::Tiles { bounds: known },
        (_, TransparentBounds::None) => TransparentLists::Tiles { bounds: DepthBounds::Off },
    }
}

/// Whether the loop of a blended fragment seeks. It is never parted: what lies behind would be mixed in more than once.
fn seek(plan: &Plan, lists: &TransparentLists, limits: &Limits) -> Result<bool> {
    if plan.technique == Technique::Reference {
        return Ok(false);
    }
    let ahead = plan.tiles.as_ref().map_or(0, |tiles| tiles.grid.first_light);
    let of_clusters = |clusters: &Clusters| Sum { lights: clusters.longest_list, ahead, seek: false };
    let sum = match (lists, &plan.clusters, &plan.tiles) {
        (TransparentLists::Clusters(clusters), ..) => of_clusters(clusters),
        (TransparentLists::Shared, Some(clusters), _) => of_clusters(clusters),
        (_, _, Some(tiles)) => Sum { lights: tiles.longest_tile, ahead, seek: tiles.list_seek && plan.lights.seek },
        (_, _, None) => Sum { lights: plan.lights.count, ahead: 0, seek: plan.lights.seek },
    };
    let ways = [sum, Sum { seek: false, ..sum }];
    match ways.into_iter().find(|sum| sum.fits(limits)) {
        Some(sum) => Ok(sum.seek),
        None => Err(Error::new(format!(
            "a blended surface may loop over {} lights, and its sum cannot be parted; this driver leaves its loops after {} iterations",
            sum.lights, limits.max_loop_iterations
        ))),
    }
}

/// The effect with its decision.
pub(super) fn effect(plan: &Plan, scene: &Scene) -> Effect {
    let count = scene.materials.iter().filter(|m| m.alpha == AlphaMode::Blend).count();
    let (runs, why, bytes) = match &plan.transparency {
        _ if count == 0 => (false, format!("none of {} materials is blended", scene.materials.len()), 0),
        _ if plan.geometry.blended.is_empty() => {
            (false, format!("no surface has one of the {count} blended materials"), 0)
        }
        None => (false, "this view shows opaque surfaces".into(), 0),
        Some(planned) => {
            let why = format!(
                "{count} of {} materials are blended: {} draws, back to front by {}; {}",
                scene.materials.len(),
                plan.geometry.blended.len(),
                planned.sort.name(),
                lists_in_words(plan, planned)
            );
            (true, why, planned.bytes(plan))
        }
    };
    Effect::new("transparency", runs, why, bytes)
}

fn lists_in_words(plan: &Plan, planned: &Transparency) -> String {
    match &planned.lists {
        _ if plan.technique == Technique::Reference => "in the order of each ray".into(),
        TransparentLists::AllLights => "each fragment loops over all lights".into(),
        TransparentLists::Shared if planned.bounds == TransparentBounds::Merged => {
            "one list a tile, bounded by both kinds of samples".into()
        }
        TransparentLists::Shared => "the lists of opaque surfaces, which know nothing of depths".into(),
        TransparentLists::Tiles { bounds: DepthBounds::Off } => "lists of tiles without depth bounds".into(),
        TransparentLists::Tiles { .. } => "lists of their own for tiles that hold them".into(),
        TransparentLists::Clusters(clusters) if clusters.keyed => {
            format!("lists of the clusters that they flag, of {}", clusters.grid.capacity)
        }
        TransparentLists::Clusters(clusters) => format!("lists of all {} clusters", clusters.grid.capacity),
    }
}

/// Farthest distance that a sample can have: nothing is drawn behind it.
fn farthest(extent: f64, view: &View) -> f64 {
    view.zfar.map_or(extent, |far| far.min(extent)).max(view.znear)
}
