//! What `--counters` and debug views of lights want beside the picture: lists made once more and judged, rectangles.

use glam::DVec3;

use crate::commands::report;
use crate::error::Result;
use crate::graph::checker::Violation;
use crate::lists::{self, Counters};
use crate::math::srgb;
use crate::measure::picture::Picture;
use crate::measure::views::{Numbers, Outline, View};
use crate::plan::projection::PixelRect;
use crate::plan::{CullTest, DebugView, Plan};
use crate::reference::light_pairs::PairCounts;
use crate::renderer::Renderer;
use crate::scene::{LightKind, Scene};

/// What was found beside the picture.
#[derive(Default)]
pub(super) struct Found {
    /// `None` where they were not asked for.
    pub(super) counters: Option<Counters>,
    pub(super) violations: Vec<Violation>,
}

/// Makes and judges the plan's lists where counters or the debug view want it, and adds the view's numbers to `picture`.
pub(super) fn look(
    renderer: &Renderer,
    scene: &Scene,
    plan: &Plan,
    counters: bool,
    picture: &mut Picture,
) -> Result<Found> {
    let view = plan.debug_view.filter(|view| view.of_lists());
    if !counters && view.is_none() {
        return Ok(Found::default());
    }
    let made = lists::make(renderer, scene, plan)?;
    let judged = counters || view.is_some_and(DebugView::of_oracle);
    let counts = if judged { made.judge(plan) } else { PairCounts::default() };
    if let Some((name, numbers)) = view.and_then(|view| made.numbers(view, plan, &counts)) {
        picture.add_layer(name, numbers);
    }
    let counters = counters.then(|| Counters::new(&made.cells, &counts, lists::directional(plan)));
    Ok(Found { counters, violations: made.violations })
}

/// How a view's numbers are shown; `None` for a view of something else. Names of layers are those of [`lists::Made::numbers`].
pub(super) fn shown(view: DebugView, plan: &Plan) -> Option<View> {
    let none = Numbers::default();
    Some(View::Numbers(match view {
        DebugView::TileMin => {
            Numbers { layer: "tile_min", text: "metres to the tile's nearest sample", logarithmic: true, ..none }
        }
        DebugView::TileMax => {
            Numbers { layer: "tile_max", text: "metres to the tile's farthest sample", logarithmic: true, ..none }
        }
        DebugView::TileMask => Numbers {
            layer: "tile_slots",
            text: "slots of the tile's depth range that hold samples",
            low: Some(0.0),
            high: plan.tiles.as_ref().map(|tiles| f64::from(tiles.slots)),
            ..none
        },
        DebugView::TileLights => {
            Numbers { layer: "list_length", text: "lights in the list of the pixel's tile", low: Some(0.0), ..none }
        }
        DebugView::Clusters => return Some(View::Identities("cluster", "clusters")),
        DebugView::ClusterLights => Numbers {
            layer: "cluster_lights",
            text: "lights in the list of the pixel's cluster",
            low: Some(0.0),
            ..none
        },
        DebugView::Slices => Numbers {
            layer: "slice",
            text: "slice that the pixel's sample lies in, 0 nearest",
            low: Some(0.0),
            high: plan.clusters.as_ref().map(|clusters| f64::from(clusters.grid.slices - 1)),
            ..none
        },
        DebugView::Lights => Numbers { layer: "lights", text: "lights that reach the pixel", low: Some(0.0), ..none },
        DebugView::Waste => Numbers {
            layer: "waste",
            text: "lights in the pixel's list for each that reaches it",
            infinite: "lights are listed and none reaches",
            low: Some(1.0),
            logarithmic: true,
            ..none
        },
        _ => return None,
    }))
}

/// Outlines of the lights' rectangles in each light's hue, and what they are.
pub(super) fn outlines(plan: &Plan) -> (Vec<Outline>, String) {
    let rectangles = lists::rectangles(plan);
    let outline = |(rect, intensity): &(PixelRect, DVec3)| {
        let hue = (*intensity / intensity.max_element()).to_array();
        Outline {
            columns: pixels(rect.x, plan.view.width),
            rows: pixels(rect.y, plan.view.height),
            color: hue.map(|x| (srgb::encode(x.clamp(0.0, 1.0)) * 255.0).round() as u8),
        }
    };
    let placed = plan.lighting.lights.iter().filter(|light| light.kind != LightKind::Directional).count();
    let form = match &plan.tiles {
        Some(tiles) if tiles.cull == CullTest::BoundsTextbook => "the textbook's divisions",
        _ => "tangents",
    };
    let text = format!(
        "bounding rectangles by {form}: {} of {} in the picture",
        rectangles.len(),
        report::count(placed, "light")
    );
    (rectangles.iter().map(outline).collect(), text)
}

/// First and last pixel of a closed range of coordinates in a picture of `size` pixels.
fn pixels([low, high]: [f32; 2], size: u32) -> [u32; 2] {
    let last = size.saturating_sub(1);
    let first = (low.floor() as u32).min(last);
    [first, ((high.ceil() as u32).saturating_sub(1)).clamp(first, last)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_become_the_pixels_that_they_touch() {
        let cases: [([f32; 2], [u32; 2]); 6] = [
            ([0.0, 8.0], [0, 7]),
            ([1.5, 3.5], [1, 3]),
            ([2.0, 4.0], [2, 3]),
            ([2.0, 2.0], [2, 2]),
            ([8.0, 8.0], [7, 7]),
            ([0.0, 0.0], [0, 0]),
        ];
        for (range, expected) in cases {
            assert_eq!(pixels(range, 8), expected, "{range:?}");
        }
    }
}
