//! What settings are judged by: the scene traced in f64, and the device's own picture of `forward`.

use super::knobs::{Against, SHADOWED};
use crate::checks;
use crate::commands::measured;
use crate::error::{Error, Result};
use crate::measure::metrics::{self, Difference};
use crate::measure::picture::Picture;
use crate::plan::{Gi, Limits, Plan, Request, Technique};
use crate::reference::render::{self, Paths, Reference};
use crate::reference::shade::Shader;
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::scene::lighting::{LightRules, RangeRule};

/// Pictures of one scene, and the pixels in which they are compared.
pub(super) struct Judge {
    /// Pixels whose 3x3 neighbourhood is one surface.
    interior: Vec<bool>,
    /// Under the lights that the command line gives.
    own: Vec<[f64; 4]>,
    /// Under the same without range and window; `None` where nothing asks for it or it is `own`.
    unbounded: Option<Vec<[f64; 4]>>,
    /// Eight rays a pixel; `None` where nothing asks for it.
    sampled: Option<Vec<[f64; 4]>>,
    /// With shadow rays; `None` where nothing asks for it.
    shadowed: Option<Vec<[f64; 4]>>,
    /// With shadow rays and paths, means of squares of pixels; `None` where nothing asks for it.
    bounced: Option<Vec<[f64; 4]>>,
    size: [usize; 2],
    /// Of the device; `None` where it cannot draw it.
    forward: Option<Vec<[f64; 4]>>,
    /// Why not.
    pub(super) note: Option<String>,
}

impl Judge {
    /// Draws `forward` and traces each lighting once: with its ranges, and as settings are judged `against`.
    ///
    /// # Errors
    /// A scene or a request that cannot be traced, or a lost device.
    pub(super) fn new(
        renderer: &Renderer,
        scene: &Scene,
        request: &Request,
        against: &[Against],
        quick: bool,
    ) -> Result<Self> {
        let unbounded = against.contains(&Against::Unbounded);
        let request = Request { technique: Technique::Forward, ..request.clone() };
        let size = [request.width as usize, request.height as usize];
        let bounced = against.contains(&Against::Bounces).then(|| trace_bounced(scene, &request, quick)).transpose()?;
        let (forward, mut note) = match Plan::new(scene, &request, &renderer.limits()) {
            Ok(plan) => (Some(metrics::widen(&draw(renderer, scene, &plan)?)), None),
            Err(error) => (None, Some(format!("forward, which the others are compared with: {error}"))),
        };
        if let Some((_, error)) = &bounced {
            let own = format!(
                "paths of bounced light are off by {:.2} % of their mean in a square of {SQUARE} pixels",
                100.0 * error
            );
            note = Some(note.map_or(own.clone(), |note| format!("{note}; {own}")));
        }
        let traced = trace(scene, &request, 1)?;
        let several = against.contains(&Against::Samples).then(|| trace(scene, &request, SAMPLES)).transpose()?;
        let with_shadows = Request { shadows: Some(SHADOWED), ..request.clone() };
        let shadowed = against.contains(&Against::Shadows).then(|| trace(scene, &with_shadows, 1)).transpose()?;
        let rules = LightRules { range: RangeRule::Infinite, ..request.rules.clone() };
        let lifted = (unbounded && request.rules != rules).then_some(Request { rules, ..request });
        let unbounded = lifted.map(|request| trace(scene, &request, 1)).transpose()?;
        Ok(Self {
            interior: checks::interior(&traced),
            own: traced.rgba,
            unbounded: unbounded.map(|traced| traced.rgba),
            sampled: several.map(|traced| traced.rgba),
            shadowed: shadowed.map(|traced| traced.rgba),
            bounced: bounced.map(|(picture, _)| squares(&picture, size)),
            size,
            forward,
            note,
        })
    }

    /// Of a picture from the reference, over the interior, or where edges are what differs over every pixel.
    pub(super) fn error(&self, radiance: &[[f32; 4]], against: Against) -> Difference {
        let reference = match against {
            Against::Own => &self.own,
            Against::Shadows => self.shadowed.as_ref().unwrap_or(&self.own),
            Against::Unbounded => self.unbounded.as_ref().unwrap_or(&self.own),
            Against::Bounces => {
                let found = squares(&metrics::widen(radiance), self.size);
                return metrics::compare(self.bounced.as_ref().unwrap_or(&self.own), &found);
            }
            Against::Samples => {
                return metrics::compare(self.sampled.as_ref().unwrap_or(&self.own), &metrics::widen(radiance));
            }
        };
        metrics::compare_masked(reference, &metrics::widen(radiance), &self.interior)
    }

    /// Of a picture from `forward`, over every pixel.
    pub(super) fn beside_forward(&self, radiance: &[[f32; 4]]) -> Option<Difference> {
        Some(metrics::compare(self.forward.as_ref()?, &metrics::widen(radiance)))
    }

    /// Share of the pixels that the error is over.
    pub(super) fn interior_share(&self) -> f64 {
        let inside = self.interior.iter().filter(|inside| **inside).count();
        inside as f64 / self.interior.len().max(1) as f64
    }
}

/// Radiance of a read-back picture.
pub(super) fn radiance(picture: &Picture) -> Result<&[[f32; 4]]> {
    picture.rgba("radiance").ok_or_else(|| Error::new("the frame has no radiance"))
}

fn draw(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<[f32; 4]>> {
    let mut prepared = renderer.prepare(scene, plan)?;
    prepared.draw(1)?;
    Ok(radiance(&prepared.read_back()?)?.to_vec())
}

/// Rays of a pixel whose edges are judged.
const SAMPLES: u32 = 8;

/// Pixels along a side of what is compared where paths are noisy.
const SQUARE: usize = 10;

/// Paths a pixel, and of a quick run.
const PATHS: [u32; 2] = [128, 32];

/// Means of squares of pixels; those that a picture's end cuts have fewer.
fn squares(picture: &[[f64; 4]], [width, height]: [usize; 2]) -> Vec<[f64; 4]> {
    let columns = width.div_ceil(SQUARE);
    let mut sums = vec![([0.0; 4], 0.0); columns * height.div_ceil(SQUARE)];
    for (index, pixel) in picture.iter().enumerate() {
        let (sum, count) = &mut sums[index / width / SQUARE * columns + index % width / SQUARE];
        (0..4).for_each(|c| sum[c] += pixel[c]);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum.map(|x| x / count)).collect()
}

/// Direct light with shadow rays for all lights, and what paths find of all that bounces; and the error of a square of pixels.
fn trace_bounced(scene: &Scene, request: &Request, quick: bool) -> Result<(Vec<[f64; 4]>, f64)> {
    let paths = PATHS[usize::from(quick)];
    let request = Request {
        technique: Technique::Reference,
        gi: Gi::Path { paths, seed: Gi::SEED },
        rules: LightRules { emission_lights: true, ..request.rules.clone() },
        ..request.clone()
    };
    let plan = Plan::new(scene, &request, &Limits::UNLIMITED)?;
    let reference = Reference::new(scene, &plan.view)?;
    let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
    let mut picture = reference.render(&shader, &|_| ()).rgba;
    let bar = measured::progress(u64::from(plan.view.height), "tracing paths, rows");
    let found = reference.bounced(&shader, Paths { count: paths, seed: Gi::SEED }, &|rows| bar.set_position(rows));
    bar.finish_and_clear();
    for (pixel, added) in picture.iter_mut().zip(&found.rgb) {
        (0..3).for_each(|c| pixel[c] += added[c]);
    }
    Ok((picture, found.standard_error.unwrap_or(f64::NAN) / SQUARE as f64))
}

fn trace(scene: &Scene, request: &Request, samples: u32) -> Result<render::Picture> {
    let request = Request { technique: Technique::Reference, ..request.clone() };
    let plan = Plan::new(scene, &request, &Limits::UNLIMITED)?;
    let reference = Reference::new(scene, &plan.view)?.of_samples(samples);
    let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
    let bar = measured::progress(u64::from(plan.view.height), "tracing rows");
    let picture = reference.render(&shader, &|rows| bar.set_position(rows));
    bar.finish_and_clear();
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge() -> Judge {
        let pixel = |x: f64| [x, x, x, 1.0];
        Judge {
            interior: vec![true, true, true, false],
            own: vec![pixel(1.0), pixel(2.0), pixel(4.0), pixel(1.0)],
            unbounded: Some(vec![pixel(2.0); 4]),
            sampled: Some(vec![pixel(3.0); 4]),
            shadowed: Some(vec![pixel(2.5); 4]),
            bounced: Some(vec![pixel(3.0)]),
            size: [2, 2],
            forward: Some(vec![pixel(1.0), pixel(2.0), pixel(4.0), pixel(8.0)]),
            note: None,
        }
    }

    #[test]
    fn errors_are_over_the_interior_and_by_the_lighting_that_was_asked_for() {
        let picture = [1.0, 2.0, 5.0, 9.0].map(|x: f32| [x, x, x, 1.0]);
        let error = judge().error(&picture, Against::Own);
        assert_eq!((error.pixels, error.max_relative), (3, 0.25));
        assert_eq!(judge().error(&picture, Against::Unbounded).max_relative, 1.5);
        assert_eq!(judge().error(&picture, Against::Samples).max_relative, 2.0);
        assert_eq!(judge().error(&picture, Against::Shadows).max_relative, 1.0);
        // The mean of all four pixels, 17 / 4.
        assert!((judge().error(&picture, Against::Bounces).max_relative - 1.25 / 3.0).abs() < 1e-12);
        let only_own = Judge { unbounded: None, ..judge() };
        assert_eq!(only_own.error(&picture, Against::Unbounded).max_relative, 0.25);
        assert_eq!(judge().interior_share(), 0.75);
    }

    #[test]
    fn forward_is_compared_everywhere() {
        let picture = [1.0, 2.0, 4.0, 9.0].map(|x: f32| [x, x, x, 1.0]);
        let difference = judge().beside_forward(&picture).expect("forward was drawn");
        assert_eq!((difference.differing_pixels, difference.pixels, difference.max_relative), (1, 4, 0.125));
        assert!(Judge { forward: None, ..judge() }.beside_forward(&picture).is_none());
    }
}
