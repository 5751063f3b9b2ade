//! Which lights have shadows: those that ask, or the few that matter most in the picture.

use super::maps::{World, reaches_scene, shines_into_view};
use crate::plan::projection::{distance_range, tangent_rectangle};
use crate::plan::{EffectName, Gi, Request};
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;
use crate::scene::{LightKind, Scene};

/// What was chosen, and why.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Lights with shadows.
    pub chosen: usize,
    /// With the numbers that decided.
    pub why: String,
}

/// Marks the lights that have shadows and puts them in front of the others, each in its order. `extent` is the distance in metres
/// from the eye beyond which nothing is drawn.
pub fn select(lighting: &mut Lighting, scene: &Scene, request: &Request, view: &View, extent: f64) -> Selection {
    let forced = request.overrides.iter().any(|o| o.effect == EffectName::Shadows && o.forced);
    let lights = &mut lighting.lights;
    let count = lights.len();
    let asking = lights.iter().filter(|light| light.shadow).count();
    let wanted = forced || request.gi != Gi::Off;
    let idle = matches!((request.shadows, asking, wanted), (Some(0), ..) | (None, 0, false));
    let seen: Vec<f64> = if idle || scene.bounds().is_empty() {
        vec![0.0; count]
    } else {
        let world = World::new(scene, view, extent, request.gi != Gi::Off);
        // One that matters nothing now may be switched on.
        let least = if request.lights_move { f64::MIN_POSITIVE } else { 0.0 };
        lights.iter().map(|light| importance(light, view, &world, request.gi != Gi::Off).max(least)).collect()
    };
    let reaching = seen.iter().filter(|matters| **matters > 0.0).count();
    let asking_seen: Vec<bool> =
        lights.iter().zip(&seen).map(|(light, matters)| light.shadow && *matters > 0.0).collect();
    let asking_reaching = asking_seen.iter().filter(|chosen| **chosen).count();
    let most_important = |most: usize| {
        let mut order: Vec<usize> = (0..count).filter(|&index| seen[index] > 0.0).collect();
        order.sort_by(|&a, &b| seen[b].total_cmp(&seen[a]).then(a.cmp(&b)));
        order.truncate(most);
        let mut chosen = vec![false; count];
        order.iter().for_each(|&index| chosen[index] = true);
        chosen
    };
    let (chosen, why) = match request.shadows {
        None if forced && asking_reaching == 0 => {
            (most_important(1), format!("the light that matters most of {reaching} that reach what is seen"))
        }
        None if request.gi != Gi::Off => {
            (most_important(count), format!("--gi {}: all {reaching} lights that reach the scene", request.gi.name()))
        }
        None if asking == 0 => (vec![false; count], format!("none of {count} lights asks")),
        Some(0) => (vec![false; count], "--shadows 0".into()),
        None => (asking_seen, format!("{asking} of {count} lights ask, {asking_reaching} of these reach what is seen")),
        Some(most) => {
            let chosen = most_important(most as usize);
            let taken = chosen.iter().filter(|chosen| **chosen).count();
            (chosen, format!("--shadows {most}: {taken} of {reaching} lights that reach what is seen"))
        }
    };
    lights.iter_mut().zip(&chosen).for_each(|(light, chosen)| light.shadow = *chosen);
    lights.sort_by_key(|light| !light.shadow);
    Selection { chosen: chosen.into_iter().filter(|chosen| *chosen).count(), why }
}

/// How much of a picture's light comes from one light: its mean illuminance within its range, in lux, times the share of the picture
/// that its range covers; 0 where it reaches nothing that is seen, as far as boxes and planes tell.
fn importance(light: &ResolvedLight, view: &View, world: &World, everywhere: bool) -> f64 {
    let brightness = light.intensity.max_element();
    if light.kind == LightKind::Directional {
        return brightness;
    }
    let center = view.world_to_view.transform_point3(light.position);
    if everywhere && !reaches_scene(light, world) {
        return 0.0;
    }
    if everywhere {
        let apart = center.length().max(1e-6);
        return brightness / (apart * apart);
    }
    let Some(rectangle) = tangent_rectangle(center, light.range, view) else { return 0.0 };
    let nearest = distance_range(center, light.range, view).map_or(f64::INFINITY, |[near, _]| f64::from(near));
    if nearest > world.farthest || !reaches_scene(light, world) || !shines_into_view(light, world) {
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
    let reach = light.range.min(2.0 * world.farthest).max(1e-6);
    brightness * cone * share * 3.0 / (reach * reach)
}
