//! Which lights have shadows: those that ask, or the few that matter most in the picture.

use crate::plan::Request;
use crate::plan::projection::{distance_range, tangent_rectangle};
use crate::scene::LightKind;
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;

/// What was chosen, and why.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Lights with shadows.
    pub chosen: usize,
    /// With the numbers that decided.
    pub why: String,
}

/// Marks the lights that have shadows and puts them in front of the others, each in its order. `extent` is the distance in metres
/// beyond which nothing is drawn.
pub fn select(lighting: &mut Lighting, request: &Request, view: &View, extent: f64) -> Selection {
    let lights = &mut lighting.lights;
    let count = lights.len();
    let asking = lights.iter().filter(|light| light.shadow).count();
    let seen: Vec<f64> = match (request.shadows, asking) {
        (Some(0), _) | (None, 0) => Vec::new(),
        _ => lights.iter().map(|light| importance(light, view, extent)).collect(),
    };
    let reaching = seen.iter().filter(|matters| **matters > 0.0).count();
    let (chosen, why) = match request.shadows {
        None if asking == 0 => (vec![false; count], format!("none of {count} lights asks")),
        Some(0) => (vec![false; count], "--shadows 0".into()),
        None => {
            let chosen: Vec<bool> =
                lights.iter().zip(&seen).map(|(light, matters)| light.shadow && *matters > 0.0).collect();
            let reach = chosen.iter().filter(|chosen| **chosen).count();
            (chosen, format!("{asking} of {count} lights ask, {reach} of these reach what is seen"))
        }
        Some(most) => {
            let mut order: Vec<usize> = (0..count).filter(|&index| seen[index] > 0.0).collect();
            order.sort_by(|&a, &b| seen[b].total_cmp(&seen[a]).then(a.cmp(&b)));
            order.truncate(most as usize);
            let mut chosen = vec![false; count];
            order.iter().for_each(|&index| chosen[index] = true);
            let taken = order.len();
            (chosen, format!("--shadows {most}: {taken} of {reaching} lights that reach what is seen"))
        }
    };
    lights.iter_mut().zip(&chosen).for_each(|(light, chosen)| light.shadow = *chosen);
    lights.sort_by_key(|light| !light.shadow);
    Selection { chosen: chosen.into_iter().filter(|chosen| *chosen).count(), why }
}

/// How much of a picture's light comes from one light: its mean illuminance within its range, in lux, times the share of the picture
/// that its range covers; 0 where it reaches nothing that is seen.
fn importance(light: &ResolvedLight, view: &View, extent: f64) -> f64 {
    let brightness = light.intensity.max_element();
    if light.kind == LightKind::Directional {
        return brightness;
    }
    let center = view.world_to_view.transform_point3(light.position);
    let Some(rectangle) = tangent_rectangle(center, light.range, view) else { return 0.0 };
    if distance_range(center, light.range, view).is_none_or(|[near, _]| f64::from(near) > extent) {
        return 0.0;
    }
    let pixels = f64::from(view.width) * f64::from(view.height);
    let area = f64::from(rectangle.x[1] - rectangle.x[0]) * f64::from(rectangle.y[1] - rectangle.y[0]);
    let share = (area / pixels).clamp(1.0 / pixels, 1.0);
    // Of the directions that a cone shines in.
    let cone = match light.kind {
        LightKind::Spot { outer, .. } => (0.5 * (1.0 - f64::from(outer).cos())).max(1e-6),
        _ => 1.0,
    };
    // The mean of 1 / d^2 in a ball of radius r is 3 / r^2.
    let reach = light.range.min(2.0 * extent).max(1e-6);
    brightness * cone * share * 3.0 / (reach * reach)
}
