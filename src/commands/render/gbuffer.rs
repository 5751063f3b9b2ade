//! What debug views of the G-buffer want beside the picture: the G-buffer made once more and read back.

use crate::error::Result;
use crate::gbuffer::{self, ALBEDO, EMISSION, MATERIAL, NORMAL};
use crate::graph::checker::Violation;
use crate::measure::picture::Picture;
use crate::measure::views::View;
use crate::plan::{DebugView, GbufferLayout, Plan};
use crate::renderer::Renderer;
use crate::scene::Scene;

/// Makes the plan's G-buffer where the debug view shows it, and adds the view's layer to `picture`; what the checker found.
pub(super) fn look(renderer: &Renderer, scene: &Scene, plan: &Plan, picture: &mut Picture) -> Result<Vec<Violation>> {
    let Some(name) = plan.debug_view.and_then(layer) else { return Ok(Vec::new()) };
    let (decoded, violations) = gbuffer::make(renderer, scene, plan)?;
    if let Some(values) = decoded.layer(name) {
        picture.add_layer(name, values.to_vec());
    }
    Ok(violations)
}

/// `None` for a view of something else.
fn layer(view: DebugView) -> Option<&'static str> {
    match view {
        DebugView::GbufferAlbedo => Some(ALBEDO),
        DebugView::GbufferNormal => Some(NORMAL),
        DebugView::GbufferMaterial => Some(MATERIAL),
        DebugView::GbufferEmission => Some(EMISSION),
        _ => None,
    }
}

/// How a view's layer is shown; `None` for a view of something else.
pub(super) fn shown(view: DebugView, plan: &Plan) -> Option<View> {
    let fat = plan.deferred.as_ref().is_some_and(|deferred| deferred.gbuffer.layout == GbufferLayout::Fat);
    let emission = if fat { "emission and ambient light in nits" } else { "emission in nits" };
    layer(view).map(|name| match view {
        DebugView::GbufferAlbedo => View::Color(name),
        DebugView::GbufferNormal => View::Direction(name),
        DebugView::GbufferMaterial => View::Shares(name, "roughness red, metalness green, occlusion blue"),
        _ => View::Brightness(name, emission),
    })
}
