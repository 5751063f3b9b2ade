//! Small spheres that show where lights are (`--show-lights`).

use crate::scene::LightKind;
use crate::scene::lighting::Lighting;
use crate::scene::view::View;
use crate::shared::LightMarker;

/// Radius relative to the light's range.
const RADIUS: f64 = 0.02;
/// Smallest and largest radius, metres.
const RADII: [f64; 2] = [0.01, 0.2];
/// Radius of lights of infinite range, metres.
const UNBOUNDED_RADIUS: f64 = 0.05;

/// A marker for each light that has a place. Its radiance is the light's colour with a largest component of 1.
pub(super) fn markers(lighting: &Lighting, view: &View) -> Vec<LightMarker> {
    let placed = lighting.lights.iter().filter(|l| l.kind != LightKind::Directional);
    placed
        .map(|light| {
            let radius = if light.range.is_finite() {
                (light.range * RADIUS).clamp(RADII[0], RADII[1])
            } else {
                UNBOUNDED_RADIUS
            };
            LightMarker {
                center: view.world_to_view.transform_point3(light.position).as_vec3().to_array(),
                radius: radius as f32,
                color: (light.intensity / light.intensity.max_element()).as_vec3().to_array(),
            }
        })
        .collect()
}
