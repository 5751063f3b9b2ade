//! Samples a pixel: how many a picture has, given what is asked for and what the device grants.

use super::light_parts::Sum;
use super::request::{Accumulation, GbufferLayout, Technique};
use super::{Effect, Limits, Plan, Request};
use crate::error::{Error, Result};

/// Numbers of samples that can be asked for.
pub const COUNTS: [u32; 4] = [1, 2, 4, 8];

/// The number of samples, and a note where another one was asked for.
///
/// # Errors
/// A number that this device lacks, where replacing it is not wanted.
pub(super) fn decide(request: &Request, limits: &Limits, notes: &mut Vec<String>) -> Result<u32> {
    let asked = request.msaa;
    if request.technique == Technique::Reference || asked == 1 {
        return Ok(asked);
    }
    if request.debug_view.is_some() {
        notes.push(format!("--msaa {asked}: debug views have one sample a pixel"));
        return Ok(1);
    }
    let granted = granted(request.technique, limits);
    if granted & asked != 0 {
        return Ok(asked);
    }
    // The nearest by ratio, of two the smaller.
    let distance = |count: &u32| (count.ilog2().abs_diff(asked.ilog2()), *count);
    let nearest = COUNTS.into_iter().filter(|count| granted & count != 0).min_by_key(distance).unwrap_or(1);
    let what = if request.technique.is_deferred() { "G-buffers" } else { "pictures" };
    let sentence = format!("--msaa {asked}: this device's {what} have no {asked} samples a pixel");
    if request.strict {
        return Err(Error::new(sentence));
    }
    notes.push(format!("{sentence}, {nearest} take their place"));
    Ok(nearest)
}

/// Numbers of samples that a technique's attachments can have, a bit each.
pub(super) fn granted(technique: Technique, limits: &Limits) -> u32 {
    limits.samples[usize::from(technique.is_deferred())]
}

/// Refuses what several samples cannot be combined with.
///
/// # Errors
/// A layout, a sum in 16-bit floats or in parts.
pub(super) fn check(plan: &Plan, request: &Request, limits: &Limits) -> Result<()> {
    if plan.samples == 1 || plan.technique == Technique::Reference {
        return Ok(());
    }
    let refused = |what: &str| Err(Error::usage(format!("--msaa {}: {what}", plan.samples)));
    if plan.deferred.is_some() && request.gbuffer == GbufferLayout::Fat {
        return refused("the fat G-buffer has one sample a pixel");
    }
    if request.accumulation == Accumulation::F16 {
        return refused("light volumes add up one sample a pixel, --accumulation f16 is theirs");
    }
    if plan.light_parts.count > 1 {
        return refused("this driver adds so many lights in several passes, which take one sample a pixel");
    }
    // Samples stand side by side where something is drawn over them.
    let wide = u64::from(plan.view.width) * u64::from(plan.samples);
    if plan.spreads_samples() && wide > u64::from(limits.max_image_dimension) {
        return Err(Error::new(format!(
            "--msaa {}: samples side by side are {wide} texels wide, this device's largest image has {}; a forward technique needs no such image",
            plan.samples, limits.max_image_dimension
        )));
    }
    check_loops(plan, limits)
}

/// A pixel of a G-buffer lights every sample; a position between samples, which no list knows, loops over all lights.
fn check_loops(plan: &Plan, limits: &Limits) -> Result<()> {
    let all = Sum { lights: plan.lights.count, ahead: 0, seek: plan.lights.seek };
    let listed = plan.tiles.as_ref().map(|tiles| {
        let clusters = plan.clusters.as_ref();
        let lights = clusters.map_or(tiles.longest_tile, |clusters| clusters.longest_list);
        Sum { lights, ahead: tiles.grid.first_light, seek: clusters.is_none() && tiles.list_seek && plan.lights.seek }
    });
    let each = if plan.deferred.is_some() { u64::from(plan.samples) } else { 1 };
    let iterations = all.iterations().max(each * listed.unwrap_or(all).iterations());
    if iterations > u64::from(limits.max_loop_iterations) {
        return Err(Error::new(format!(
            "--msaa {}: a pixel may take {iterations} iterations over lights, this driver leaves its loops after {}",
            plan.samples, limits.max_loop_iterations
        )));
    }
    Ok(())
}

/// The effect with its decision.
pub(super) fn effect(plan: &Plan, request: &Request) -> Effect {
    let one = plan.attachment_bytes_of(1);
    let bytes = plan.attachment_bytes_of(plan.samples.max(4)).saturating_sub(one);
    let why = match (plan.samples, request.msaa) {
        (1, 1) => "one sample a pixel is asked for".into(),
        (1, asked) => format!("{asked} samples are asked for, one is there"),
        (count, _) if plan.technique == Technique::Reference => format!("{count} rays a pixel"),
        (count, _) if plan.deferred.is_some() => {
            format!("{count} samples a pixel, shaded one by one where they differ")
        }
        (count, _) => format!("{count} samples a pixel, shaded once a triangle"),
    };
    Effect::new("msaa", plan.samples > 1, why, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn samples_side_by_side_fit_into_an_image() {
        let scene = builtin::load("glass:layers=1").expect("a built-in scene");
        let limits = Limits { samples: [1 | 4; 2], float_blend: true, ..Limits::MINIMUM };
        let planned = |width: u32, technique| {
            Plan::new(&scene, &Request { width, height: 8, msaa: 4, technique, ..Request::default() }, &limits)
        };
        assert!(planned(1024, Technique::TiledDeferred).is_ok());
        let refused = planned(1025, Technique::TiledDeferred).expect_err("4100 texels").to_string();
        assert!(refused.contains("4100") && refused.contains("4096"), "{refused}");
        assert!(planned(1025, Technique::TiledForward).is_ok());
    }

    #[test]
    fn auto_takes_a_technique_that_has_the_samples() {
        let scene = builtin::load("cornell").expect("a built-in scene");
        let plan = Plan::new(&scene, &Request { msaa: 4, ..Request::default() }, &Limits::MINIMUM).expect("a plan");
        assert_eq!((plan.samples, plan.deferred.is_none()), (4, true));
    }

    fn decided(msaa: u32, technique: Technique, strict: bool) -> (Result<u32>, Vec<String>) {
        let mut notes = Vec::new();
        let request = Request { msaa, technique, strict, ..Request::default() };
        (decide(&request, &Limits::MINIMUM, &mut notes), notes)
    }

    #[test]
    fn the_nearest_number_takes_the_place_of_one_that_is_not_there() {
        for (asked, technique, count) in [
            (1, Technique::Forward, 1),
            (2, Technique::Forward, 1),
            (4, Technique::Forward, 4),
            (8, Technique::ClusteredForward, 4),
            (4, Technique::TiledDeferred, 1),
            (8, Technique::Reference, 8),
        ] {
            let (found, notes) = decided(asked, technique, false);
            assert_eq!(found.ok(), Some(count), "{asked}");
            assert_eq!(notes.len(), usize::from(asked != count), "{notes:?}");
            assert_eq!(decided(asked, technique, true).0.is_ok(), asked == count);
        }
    }
}
