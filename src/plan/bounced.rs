//! Bounced light: whether it is gathered at all, in how many steps, and everything that is uploaded for it.

use std::sync::Arc;

use glam::DMat4;

use super::effects::Effect;
use super::{EffectName, Gathering, Gi, Iteration, Limits, Plan, Request, Technique};
use crate::error::{Error, Result};
use crate::radiosity::bake::{CodecName, POINTS};
use crate::radiosity::spectrum::Spectrum;
use crate::radiosity::{Bake, Patch};
use crate::scene::LightKind;
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;
use crate::shared::{self, PatchData, PatchLight};

pub mod matrix;

pub use matrix::Matrix;

/// Most gathers: what tolerances ask for beyond that is f32's own error.
pub const MOST_GATHERS: u32 = 64;

/// Storage buffers of one stage, at most: materials, lights, a list and its offsets, and words of the grid.
const STORAGE_BUFFERS: u32 = 5;

/// Each of the first four threads of a group ends a row.
const LEAST_LANES: u32 = 4;

/// Changes are added up so many times before light is gathered afresh: each adds a rounding of 2^-24.
const AFRESH: u32 = 64;
/// Of what a light was: if it is fainter than that light is gathered afresh.
const FAINTER: f64 = 0.1;

/// Points of a patch where few are enough.
const FEW_POINTS: u32 = 4;
/// Patches that light from afar comes back from in equal parts, at least: what few points do to each of them evens out.
const SENDERS: f64 = 32.0;

/// What is made of the light of the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carried {
    /// Nothing.
    Nothing,
    /// Gathers go on from it.
    Light,
    /// What changed is gathered, and added to it.
    Changes,
}

/// What is gathered, and how.
#[derive(Debug, Clone)]
pub struct Bounced {
    /// What was baked.
    pub bake: Arc<Bake>,
    /// Share of the residual and weight of the change of each gather (G. Golub, R. Varga, 1961).
    pub steps: Vec<[f32; 2]>,
    /// The grid and patches in it (`BOUNCED_HEAD_TEXELS`).
    pub places: Vec<[f32; 4]>,
    /// What of patches light does not change, view space.
    pub patches: Vec<PatchData>,
    /// Points of each patch at which direct light is looked at.
    pub points_each: u32,
    /// These points and the normals there, view space.
    pub points: Vec<[[f32; 3]; 2]>,
    /// The matrix.
    pub matrix: Matrix,
    /// A thread adds a row by itself.
    pub thread_rows: bool,
    /// All light and all surfaces are grey: one channel is gathered.
    pub grey: bool,
    /// What is made of the light of the frame before.
    pub carried: Carried,
    /// Nothing of it, this time.
    pub afresh: bool,
    /// Moves since the plan was made.
    moves: u32,
    /// Threads of a group, a power of two of at least four.
    pub lanes: u32,
    /// Cells and lists are more words than a texel buffer holds: shading reads them from a storage buffer.
    pub words_in_storage: bool,
}

/// Bounced light, or why there is none.
pub(super) type Decision = (Option<Bounced>, String);

impl Bounced {
    /// `None` where none is wanted, or where there would be none worth a pass.
    ///
    /// # Errors
    /// No bake; a matrix or a grid that this device does not bind.
    pub(super) fn new(request: &Request, view: &View, lighting: &Lighting, limits: &Limits) -> Result<Decision> {
        let Gi::Radiosity(Gathering { gathers, tolerance, iteration, path, thread_rows, feedback }) = request.gi else {
            return Ok((None, format!("--gi {}", request.gi.name())));
        };
        let surfaces = request.debug_view.is_some_and(super::DebugView::of_surfaces);
        if surfaces || request.technique == Technique::Reference {
            return Ok((None, "rays or surfaces are drawn instead".into()));
        }
        let bake = request.bake.clone().ok_or_else(|| Error::usage("--gi radiosity needs a bake"))?;
        let brightest = bake.patches.list.iter().map(|p| p.reflectance.max_element()).fold(0.0, f64::max);
        let emits = bake.patches.list.iter().any(|p| p.emission.max_element() > 0.0);
        let most = brightest * bake.factors.most_seen;
        let forced = request.overrides.iter().any(|o| o.effect == EffectName::Radiosity && o.forced);
        if !emits && most <= tolerance && !forced {
            let why = format!("at most {most:.4} of the light is reflected, less than the tolerance {tolerance}");
            return Ok((None, why));
        }
        let Spectrum { smallest, largest } = bake.spectrum;
        // Where nothing emits, bounces are at most so much of all light.
        let share = if emits { 1.0 } else { largest.max(-smallest).min(1.0) };
        if feedback && bake.settings.codec.is_summed() {
            let codec = bake.settings.codec.name();
            return Err(Error::usage(format!(
                "--gi-feedback: bounces are summed in {codec}, nothing is left to the next frame"
            )));
        }
        let (steps, how) = if feedback {
            let count = gathers.unwrap_or(1);
            let a_frame = largest.max(-smallest).powi(count as i32);
            let how = format!(
                "{count} gathers a frame on top of the light of the frame before; after each at most {a_frame:.3} of what light had changed is left"
            );
            (steps(Iteration::Neumann, smallest, largest, count), how)
        } else if bake.settings.codec.is_summed() {
            let bounces = bake.settings.bounces.map_or("all".into(), |count| count.to_string());
            (vec![[1.0; 2]], format!("one product, {bounces} bounces are summed in it"))
        } else {
            let most = gathers.unwrap_or(MOST_GATHERS);
            let left = |count: &u32| share * left_after(*count, iteration, smallest, largest) <= tolerance;
            let count = gathers.unwrap_or_else(|| (1..most).find(left).unwrap_or(most));
            let why = match gathers {
                Some(_) => "as asked for".into(),
                None if emits => format!("leave {tolerance} of what bounces and is emitted"),
                None => format!("leave {tolerance} of all light, of which at most {share:.3} has bounced"),
            };
            let how = format!(
                "{count} gathers ({}) {why}; reflection has eigenvalues from {smallest:.3} to {largest:.3}",
                iteration.name()
            );
            (steps(iteration, smallest, largest, count), how)
        };
        let is_grey = |c: glam::DVec3| c.x == c.y && c.y == c.z;
        let surfaces = bake.patches.list.iter().all(|p| is_grey(p.reflectance) && is_grey(p.emission));
        // Lamps that move may be replaced by coloured ones.
        let lit_grey = !request.lights_move && lighting.lights.iter().all(|light| is_grey(light.intensity));
        let grey = surfaces && lit_grey && !bake.settings.codec.is_summed();
        let how = if grey { format!("{how}; one channel, for all is grey") } else { how };
        let carried = match () {
            () if feedback => Carried::Light,
            () if request.lights_move && bake.settings.codec.is_summed() => Carried::Changes,
            () => Carried::Nothing,
        };
        let how = match carried {
            Carried::Changes => format!("{how}, of columns whose light changed"),
            _ => how,
        };
        // Lamps may light one patch alone.
        let from_afar = lighting.lights.iter().all(|light| light.kind == LightKind::Directional);
        let is_few = gathers.is_none() && !feedback && from_afar && few_are_enough(share, tolerance);
        let points_each = if is_few { FEW_POINTS } else { POINTS };
        let how = if is_few { format!("{how}; {FEW_POINTS} points a patch, about half as much again") } else { how };
        let matrix = Matrix::new(&bake, path, limits)?;
        let planned = Self {
            steps,
            places: places(&bake, view),
            patches: bake.patches.list.iter().map(|patch| patch_data(patch, view)).collect(),
            points_each,
            points: points(&bake.points, points_each).map(|point| point_data(point, view)).collect(),
            matrix,
            lanes: limits.subgroup_size.clamp(LEAST_LANES, shared::GATHER_LANES).next_power_of_two(),
            thread_rows: thread_rows && bake.settings.codec == CodecName::Classical,
            carried,
            afresh: carried == Carried::Changes,
            moves: 0,
            grey,
            words_in_storage: bake.transfer.words.len() as u64 > limits.max_texel_elements,
            bake,
        };
        planned.check(limits)?;
        let bake = &planned.bake;
        let (patches, codec) = (bake.patches.list.len(), bake.settings.codec.name());
        let why = format!("{patches} patches, {codec} ({:.3} bytes an element): {how}", bake.bytes_an_element());
        Ok((Some(planned), why))
    }

    /// Other lights: what is known of the light of patches is taken over, but from time to time, and where a light became so much fainter that
    /// rounding of what it gave would be seen.
    ///
    /// # Errors
    /// A lamp in a picture that was planned for light from afar alone.
    pub(super) fn go_on(&mut self, before: &Lighting, after: &Lighting) -> Result<()> {
        if self.points_each < POINTS && after.lights.iter().any(|light| light.kind != LightKind::Directional) {
            return Err(Error::usage(
                "a lamp where all light was directional is another picture, which has to be planned anew",
            ));
        }
        self.moves += 1;
        let brightness = |light: &ResolvedLight| light.intensity.max_element();
        let fainter = before.lights.len() != after.lights.len()
            || before.lights.iter().zip(&after.lights).any(|(a, b)| brightness(b) < FAINTER * brightness(a));
        self.afresh = self.carried == Carried::Changes && (fainter || self.moves.is_multiple_of(AFRESH));
        Ok(())
    }

    /// Lights are read from a storage buffer: with the light of the frame before that makes one more than the least that devices bind.
    ///
    /// # Errors
    /// Light that is to go on from frame to frame, on such a device.
    pub(super) fn with_lights_in_storage(&mut self, limits: &Limits) -> Result<()> {
        match self.carried {
            _ if limits.max_stage_storage_buffers >= STORAGE_BUFFERS => {}
            Carried::Nothing => {}
            Carried::Changes => (self.carried, self.afresh) = (Carried::Nothing, false),
            Carried::Light => {
                return Err(Error::new(format!(
                    "--gi-feedback: light of the frame before is the last of {STORAGE_BUFFERS} storage buffers of a stage, this device has {}",
                    limits.max_stage_storage_buffers
                )));
            }
        }
        Ok(())
    }

    fn check(&self, limits: &Limits) -> Result<()> {
        if self.words_in_storage && limits.max_stage_storage_buffers < STORAGE_BUFFERS {
            return Err(Error::new(format!(
                "--gi radiosity: a grid of {} words takes one of {STORAGE_BUFFERS} storage buffers of a stage, this device has {}; bake fewer patches",
                self.bake.transfer.words.len(),
                limits.max_stage_storage_buffers
            )));
        }
        let lights = self.patches.len() * shared::BOUNCED_LIGHT_TEXELS as usize;
        let texels = [self.places.len(), lights];
        match texels.into_iter().find(|n| *n as u64 > limits.max_texel_elements) {
            Some(texels) => Err(Error::new(format!(
                "--gi radiosity: {texels} texels for {} patches, this device's texel buffers have {}; bake fewer patches",
                self.patches.len(),
                limits.max_texel_elements
            ))),
            None => Ok(()),
        }
    }

    /// Bytes of all buffers of bounced light.
    pub fn bytes(&self) -> u64 {
        let buffers = if self.carried != Carried::Nothing && self.steps.len() > 1 { 3 } else { 2 };
        let light = buffers * size_of::<PatchLight>() * self.patches.len();
        let texels = 16 * self.places.len() + 24 * self.points.len();
        let words = 4 * self.bake.transfer.words.len();
        self.matrix.bytes() + (light + texels + words + size_of_val(self.patches.as_slice())) as u64
    }
}

/// What is left of the bounces after so many steps, at most, relative to all of them, in the norm of areas and reflectance.
pub fn left_after(gathers: u32, iteration: Iteration, smallest: f64, largest: f64) -> f64 {
    if iteration == Iteration::Neumann {
        return largest.max(-smallest).powi(gathers as i32);
    }
    let sigma = (largest - smallest) / (2.0 - largest - smallest);
    if sigma <= 0.0 {
        return 0.0;
    }
    let c = (1.0 - (1.0 - sigma * sigma).max(0.0).sqrt()) / sigma;
    let power = c.powi(gathers as i32);
    2.0 * power / (1.0 + power * power)
}

/// Share of the residual and weight of each step.
pub fn steps(iteration: Iteration, smallest: f64, largest: f64, count: u32) -> Vec<[f32; 2]> {
    if iteration == Iteration::Neumann {
        return vec![[1.0; 2]; count as usize];
    }
    let step = 2.0 / (2.0 - largest - smallest);
    let sigma2 = ((largest - smallest) / (2.0 - largest - smallest)).powi(2);
    let mut weight = 1.0;
    (0..count)
        .map(|k| {
            weight = match k {
                0 => 1.0,
                1 => 1.0 / (1.0 - 0.5 * sigma2),
                _ => 1.0 / (1.0 - 0.25 * sigma2 * weight),
            };
            [step as f32, weight as f32]
        })
        .collect()
}

/// Whether [`FEW_POINTS`] of a patch leave out about half of `tolerance` of all light, root mean square, of which bounces are a `share`: half of n
/// independent points in shadow are off by 1 / (2 sqrt n), and what [`SENDERS`] patches send by less.
fn few_are_enough(share: f64, tolerance: f64) -> bool {
    share * 0.5 / (f64::from(FEW_POINTS) * SENDERS).sqrt() <= 0.5 * tolerance
}

/// `each` of the points of every patch, from equal runs of its strata; where in a run differs from patch to patch, since triangles that strata lie in
/// are in the same order in many.
pub fn points(all: &[[glam::DVec3; 2]], each: u32) -> impl Iterator<Item = &[glam::DVec3; 2]> {
    let run = (POINTS / each) as usize;
    all.chunks(run).enumerate().filter_map(move |(at, points)| {
        let (patch, stratum) = (at / each as usize, at % each as usize);
        points.get((7 * patch + 5 * stratum) % run)
    })
}

fn point_data([at, normal]: &[glam::DVec3; 2], view: &View) -> [[f32; 3]; 2] {
    let normal = view.world_to_view.transform_vector3(*normal).normalize_or_zero();
    [view.world_to_view.transform_point3(*at).as_vec3().to_array(), normal.as_vec3().to_array()]
}

fn patch_data(patch: &Patch, view: &View) -> PatchData {
    PatchData {
        normal: view.world_to_view.transform_vector3(patch.normal).normalize_or_zero().as_vec3().to_array(),
        area: patch.area as f32,
        reflectance: patch.reflectance.as_vec3().to_array(),
        emission: patch.emission.as_vec3().to_array(),
    }
}

fn places(bake: &Bake, view: &View) -> Vec<[f32; 4]> {
    let transfer = &bake.transfer;
    let to_cells = DMat4::from_scale((1.0 / transfer.cell) * glam::DVec3::ONE)
        * DMat4::from_translation(-transfer.origin)
        * view.world_to_view.inverse();
    let [x, y, z] = transfer.size.map(|n| n as f32);
    let mut texels: Vec<[f32; 4]> = (0..3).map(|row| to_cells.row(row).as_vec4().to_array()).collect();
    texels.extend([[x, y, z, transfer.reach as f32], [transfer.cell as f32, 0.0, 0.0, 0.0]]);
    for patch in &bake.patches.list {
        let center = (patch.center - transfer.origin) / transfer.cell;
        // Only ratios of areas matter.
        let area = patch.area / bake.patches.size.powi(2);
        texels.push(center.extend(area).as_vec4().to_array());
        texels.push(patch.normal.extend(0.0).as_vec4().to_array());
    }
    texels
}

/// The effect with its decision.
pub(super) fn effect(plan: &Plan) -> Effect {
    let bytes = plan.bounced.as_ref().map_or(0, Bounced::bytes);
    Effect::new("radiosity", plan.bounced.is_some(), plan.bounced_why.clone(), bytes)
}

const _: () = assert!(POINTS == shared::PATCH_POINTS);

#[cfg(test)]
mod tests;
