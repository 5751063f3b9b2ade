//! The device against f64: shading fed with the device's own surfaces, and whole pictures against traced rays.

use std::borrow::Cow;

use glam::DVec3;

use super::Row;
use crate::error::{Error, Result};
use crate::measure::metrics;
use crate::measure::picture::Picture;
use crate::passes;
use crate::passes::surface::LAYERS;
use crate::plan::{Plan, Request};
use crate::reference::render::{self, Reference};
use crate::reference::shade::Shader;
use crate::reference::surface::Surface;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::{AlphaMode, Instance, Scene, builtin, scatter};

/// Bound of the shading error: of the larger of the reference and the picture's mean.
pub const SHADING_BOUND: f64 = 1e-5;

const SHADINGS: [Shading; 3] = [Shading::Lambert, Shading::Phong, Shading::Gltf];

/// What the lights saw at each pixel, as the device stored it; `None` where nothing is.
fn surfaces(scene: &Scene, picture: &Picture) -> Result<Vec<Option<Surface>>> {
    let missing = || Error::new("the surface probe left no layers");
    let mut layers = Vec::new();
    for name in LAYERS {
        layers.push(picture.rgba(name).ok_or_else(missing)?);
    }
    let vector = |v: [f32; 4]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    let surface = |i: usize| {
        let [position, normal, base, emissive] = [layers[0][i], layers[1][i], layers[2][i], layers[3][i]];
        (emissive[3] > 0.5).then(|| Surface {
            position: vector(position),
            // Unit to the last bit of f64: 1 - (n.h)^2 sees each ulp of the length that f32 left, over alpha^2, twice.
            normal: vector(normal).normalize_or_zero(),
            base_color: vector(base),
            alpha: 1.0,
            metallic: f64::from(base[3]),
            roughness: f64::from(position[3]),
            occlusion: f64::from(normal[3]),
            emissive: vector(emissive),
            // What is seen, and four times which material.
            unlit: (emissive[3] % 4.0) > 1.5,
            model: scene.materials.get((emissive[3] / 4.0) as usize).and_then(|material| material.model),
        })
    };
    Ok((0..layers[0].len()).map(surface).collect())
}

fn radiance(picture: &Picture) -> Result<Vec<[f32; 4]>> {
    picture.rgba("radiance").map(<[_]>::to_vec).ok_or_else(|| Error::new("the frame has no radiance"))
}

/// Radiance of one frame, every pixel.
pub(super) fn draw(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<[f32; 4]>> {
    let mut frame = renderer.prepare(scene, plan)?;
    frame.draw(1)?;
    radiance(&frame.read_back()?)
}

/// The plan's lights in f64.
pub(super) fn shader(plan: &Plan) -> Shader<'_> {
    Shader::new(&plan.lighting, &plan.view, plan.shading)
}

/// A frame of the device beside the surfaces that its lights saw.
pub(super) struct Shaded {
    /// Every pixel as stored.
    pub radiance: Vec<[f32; 4]>,
    /// Every pixel; `None` where nothing is.
    pub surfaces: Vec<Option<Surface>>,
}

impl Shaded {
    /// Draws the plan's frame, and the same geometry again for the surface probe.
    ///
    /// # Errors
    /// A lost device.
    pub fn draw(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Self> {
        let radiance = draw(renderer, scene, plan)?;
        let mut probe = renderer.prepare_frame(scene, plan, passes::surface_frame(plan))?;
        probe.draw(1)?;
        Ok(Self { radiance, surfaces: surfaces(scene, &probe.read_back()?)? })
    }

    /// Pixels with a channel that is NaN or infinite.
    pub fn not_finite(&self) -> usize {
        self.radiance.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count()
    }

    /// Largest difference from `shader` at the device's surfaces, relative to the larger of its value and its mean; infinite
    /// where there is no surface.
    pub fn error(&self, shader: &Shader) -> f64 {
        let pairs: Vec<(DVec3, [f32; 4])> = self
            .surfaces
            .iter()
            .zip(&self.radiance)
            .filter_map(|(surface, pixel)| Some((shader.radiance(surface.as_ref()?), *pixel)))
            .collect();
        if pairs.is_empty() {
            return f64::INFINITY;
        }
        let mean = pairs.iter().map(|p| p.0.element_sum() / 3.0).sum::<f64>() / pairs.len() as f64;
        let error = |(reference, pixel): &(DVec3, [f32; 4])| {
            (0..3).map(|i| (f64::from(pixel[i]) - reference[i]).abs() / reference[i].abs().max(mean)).fold(0.0, larger)
        };
        pairs.iter().map(error).fold(0.0, larger)
    }
}

/// Largest error of the device's shading against f64 fed with the device's surfaces, relative to the larger of the reference
/// and its mean.
///
/// # Errors
/// A lost device.
pub fn shading_error(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<f64> {
    let scene = &opaque(scene);
    let plan = Plan::new(scene, request, &renderer.limits())?;
    Ok(Shaded::draw(renderer, scene, &plan)?.error(&shader(&plan)))
}

/// The scene without its blended surfaces, behind which the probe sees.
fn opaque(scene: &Scene) -> Cow<'_, Scene> {
    let blends = |instance: &Instance| scene.materials[scene.meshes[instance.mesh].material].alpha == AlphaMode::Blend;
    if !scene.instances.iter().any(blends) {
        return Cow::Borrowed(scene);
    }
    let mut left = scene.clone();
    left.instances.retain(|instance| !blends(instance));
    Cow::Owned(left)
}

/// Maximum that a NaN wins.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// Pixels in which a picture is compared with rays: those whose 3x3 neighbourhood is one surface.
pub fn interior(traced: &render::Picture) -> Vec<bool> {
    let mut mask = metrics::interior_mask(&traced.surface_id, traced.width, traced.height);
    // The sky is no surface: tips thinner than a pixel stand before it in one picture and not in the other.
    mask.iter_mut().zip(&traced.surface_id).for_each(|(m, id)| *m &= *id != u32::MAX);
    mask
}

/// Mean relative error of a picture against rays through `scene` as `plan` sees it, over pixels whose 3x3 neighbourhood is one
/// surface; and the share of such pixels.
pub(super) fn against_rays(radiance: &[[f32; 4]], scene: &Scene, plan: &Plan) -> Result<(f64, f64)> {
    let reference = Reference::new(scene, &plan.view)?;
    let traced = reference.render(&shader(plan), &|_| {});
    let mask = interior(&traced);
    let share = mask.iter().filter(|m| **m).count() as f64 / mask.len().max(1) as f64;
    Ok((metrics::compare_masked(&traced.rgba, &metrics::widen(radiance), &mask).mean_relative, share))
}

/// Mean relative error of the device's picture against traced rays, over pixels whose 3x3 neighbourhood is one surface; and the
/// share of such pixels.
///
/// # Errors
/// A lost device.
pub fn whole_picture_error(renderer: &Renderer, scene: &Scene, request: &Request) -> Result<(f64, f64)> {
    let plan = Plan::new(scene, request, &renderer.limits())?;
    against_rays(&draw(renderer, scene, &plan)?, scene, &plan)
}

/// Seeds of scattered lights that `scenes` tries beside the default.
const OTHER_SEEDS: [u64; 5] = [2, 3, 4, 5, 7];

/// Bound of the whole picture's mean relative error, by the driver's sub-pixel bits.
pub fn picture_bound(renderer: &Renderer) -> f64 {
    if renderer.device().facts.limits.sub_pixel_precision_bits >= 8 { 1e-3 } else { 5e-3 }
}

/// A scene under the lights that `render --lights N --light-seed SEED` scatters.
fn lit(name: &str, lights: usize, seed: u64) -> Result<Scene> {
    let mut scene = builtin::load(name)?;
    scene.lights = scatter::point_lights(&scene.bounds(), lights, seed);
    Ok(scene)
}

/// Shading of three scenes, all models.
pub fn shading(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in ["cornell", "corridor"] {
        let scene = lit(name, 64, 1)?;
        for shading in SHADINGS {
            let request = Request { width: 160, height: 90, shading, ..crate::checks::forward() };
            let error = shading_error(renderer, &scene, &request)?;
            rows.push(Row::at_most(format!("shading {} against f64, {name}", shading.name()), error, SHADING_BOUND));
        }
    }
    Ok(rows)
}

/// Whole pictures against traced rays.
pub fn picture(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for name in ["cornell", "furnace"] {
        let scene = lit(name, 16, 1)?;
        let request = Request { width: 320, height: 180, ..crate::checks::forward() };
        let (error, _) = whole_picture_error(renderer, &scene, &request)?;
        rows.push(Row::at_most(format!("picture against rays, {name}"), error, picture_bound(renderer)));
    }
    Ok(rows)
}

/// Every built-in scene under 64 scattered lights, in every shading model, 320x180: shading against f64 and pictures against rays.
/// Too slow for [`ALL`](super::ALL).
///
/// # Errors
/// A lost device.
pub fn scenes(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, _) in builtin::NAMES {
        let scene = lit(name, 64, 1)?;
        for shading in SHADINGS {
            let request = Request { width: 320, height: 180, shading, ..crate::checks::forward() };
            let plan = Plan::new(&scene, &request, &renderer.limits())?;
            let shaded = Shaded::draw(renderer, &scene, &plan)?;
            let (mean, share) = against_rays(&shaded.radiance, &scene, &plan)?;
            let error = match opaque(&scene) {
                Cow::Borrowed(_) => shaded.error(&shader(&plan)),
                Cow::Owned(left) => shading_error(renderer, &left, &request)?,
            };
            let mut picture = Row::at_most(
                format!("picture against rays, {name}, {}", shading.name()),
                mean,
                picture_bound(renderer),
            );
            picture.detail += &format!(", over {:.1} % of the pixels", 100.0 * share);
            rows.push(Row::at_most(format!("shading {} against f64, {name}", shading.name()), error, SHADING_BOUND));
            rows.push(picture);
        }
        for seed in OTHER_SEEDS {
            let request = Request { width: 320, height: 180, ..crate::checks::forward() };
            let error = shading_error(renderer, &lit(name, 64, seed)?, &request)?;
            rows.push(Row::at_most(format!("shading gltf against f64, {name}, seed {seed}"), error, SHADING_BOUND));
        }
    }
    Ok(rows)
}
