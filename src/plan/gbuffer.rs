//! The G-buffer: what it stores, how many bytes that takes, and how lights are added over it.

use super::light_volumes::LightVolumes;
use super::lights::check_loops;
use super::request::{Accumulation, DeferredLights, GbufferLayout, Technique};
use super::{Effect, Limits, Plan, Request};
use crate::error::{Error, Result};
use crate::scene::LightKind;
use crate::scene::view::View;
use crate::shared::MAX_HALF;

/// Colour attachments of the fat layout.
pub const FAT_ATTACHMENTS: u32 = 5;

/// What a pixel of the G-buffer holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gbuffer {
    /// Fat: everything in 32-bit floats. Compact: position from depth, codes for the rest.
    pub layout: GbufferLayout,
    /// Of each of the two codes of a normal in the compact layout: 8, 10 or 16.
    pub normal_bits: u32,
    /// The compact layout has an image of emission.
    pub emission: bool,
    /// It says which material is seen: beside the normals' codes in the compact layout, in the flag of the fat one.
    pub material: bool,
}

impl Gbuffer {
    /// Bytes a pixel, depth not counted.
    pub fn texel_bytes(&self) -> u64 {
        match self.layout {
            GbufferLayout::Fat => u64::from(FAT_ATTACHMENTS) * 16,
            GbufferLayout::Compact => {
                let normals = match (self.material, self.normal_bits) {
                    (true, _) => 8,
                    (false, 8) => 2,
                    (false, _) => 4,
                };
                // Base colour and material are 4 each.
                8 + normals + if self.emission { 8 } else { 0 }
            }
        }
    }

    fn new(plan: &mut Plan, request: &Request, limits: &Limits) -> Result<Self> {
        let compact = request.gbuffer == GbufferLayout::Compact;
        let most = limits.max_color_attachments;
        if !compact && most < FAT_ATTACHMENTS {
            return Err(Error::new(format!(
                "--gbuffer fat needs {FAT_ATTACHMENTS} colour attachments, this device grants {most}"
            )));
        }
        let brightest = brightest_emission(plan);
        if compact && brightest > MAX_HALF {
            plan.notes.push(format!(
                "emission up to {brightest:e} is clamped once to {MAX_HALF}, the most that the compact G-buffer holds"
            ));
        }
        let emission = compact && brightest > 0.0;
        let material = plan.stores_material();
        let most = if compact { 1 << 16 } else { 1 << 24 };
        if material && plan.materials.data.len() > most {
            return Err(Error::new(format!(
                "{} materials with models of their own: a {} G-buffer tells {most} apart",
                plan.materials.data.len(),
                request.gbuffer.name()
            )));
        }
        Ok(Self { layout: request.gbuffer, normal_bits: request.normal_bits, emission, material })
    }
}

/// Largest emission of what is drawn lit, maps not counted.
fn brightest_emission(plan: &Plan) -> f32 {
    let lit = plan.geometry.draws.iter().filter(|d| !d.variant.unlit);
    lit.flat_map(|d| plan.materials.data[d.material].emissive).fold(0.0, f32::max)
}

/// How lights are added over the G-buffer; every form adds them in the order of ids and gives the same picture.
#[derive(Debug, Clone)]
pub enum LightPass {
    /// Light by light, by blending.
    Volumes(LightVolumes),
    /// One pass that loops over all of them.
    Fullscreen {
        /// Lights out of range are stepped over.
        branch: bool,
    },
    /// A compute pass that loops over the lights of each tile.
    Tiles {
        /// 1, or 4 of a column, which share what is read of each light.
        pixels_a_thread: u32,
    },
    /// A compute pass that loops over the lights of each cluster.
    Clusters,
}

/// The deferred part of a plan.
#[derive(Debug, Clone)]
pub struct Deferred {
    /// What is stored.
    pub gbuffer: Gbuffer,
    /// How it is lit.
    pub light_pass: LightPass,
    /// What volumes add in; `F32` for every other form, which stores its sum once.
    pub accumulation: Accumulation,
}

impl Deferred {
    /// Decides for the plan's technique; `None` where it is not a deferred one. No geometry is farther than `extent` metres from the eye.
    ///
    /// # Errors
    /// A G-buffer or a loop that this device does not grant, or few bits for a technique that adds nothing by blending.
    pub fn new(plan: &mut Plan, request: &Request, extent: f64, limits: &Limits) -> Result<Option<Self>> {
        check_accumulation(plan, request)?;
        if request.pixels_a_thread.is_some() && plan.technique != Technique::TiledDeferred {
            let name = plan.technique.name();
            return Err(Error::usage(format!("--pixels-a-thread is for tiled-deferred, the plan has {name}")));
        }
        let light_pass = match plan.technique {
            Technique::Deferred => light_pass(plan, request, extent, limits)?,
            // No light is listed: what there is shines everywhere.
            Technique::TiledDeferred | Technique::ClusteredDeferred if plan.tiles.is_none() => {
                check_loops(plan.lights.count, false, limits)?;
                LightPass::Fullscreen { branch: false }
            }
            Technique::TiledDeferred => LightPass::Tiles { pixels_a_thread: pixels_a_thread(plan, request, limits)? },
            Technique::ClusteredDeferred => LightPass::Clusters,
            _ => return Ok(None),
        };
        Ok(Some(Self { gbuffer: Gbuffer::new(plan, request, limits)?, light_pass, accumulation: request.accumulation }))
    }

    /// Pixels that a thread shades, where lights are listed by tile.
    pub fn pixels_a_thread(&self) -> Option<u32> {
        match self.light_pass {
            LightPass::Tiles { pixels_a_thread } => Some(pixels_a_thread),
            _ => None,
        }
    }

    /// The volumes, where lights are added by them.
    pub fn volumes(&self) -> Option<&LightVolumes> {
        match &self.light_pass {
            LightPass::Volumes(volumes) => Some(volumes),
            _ => None,
        }
    }
}

/// As asked, or what the profile has as quicker.
fn pixels_a_thread(plan: &Plan, request: &Request, limits: &Limits) -> Result<u32> {
    // Four pixels seek in a list together or not at all.
    let seeks = plan.lights.seek && plan.tiles.as_ref().is_some_and(|tiles| tiles.list_seek);
    if seeks && request.pixels_a_thread == Some(4) {
        return Err(Error::usage(
            "--pixels-a-thread 4 needs lists that hold little in vain: --cull frustum-aabb, a pre-pass, and depth bounds",
        ));
    }
    if plan.samples > 1 {
        // Pixels differ in how many of their samples are lit.
        return match request.pixels_a_thread {
            Some(4) => Err(Error::usage("--pixels-a-thread 4 lights one sample a pixel; --msaa asks for more")),
            _ => Ok(1),
        };
    }
    let profile = limits.profile.clone().unwrap_or_default();
    let quicker = if !seeks && profile.shared_pair < profile.deferred_pair { 4 } else { 1 };
    Ok(request.pixels_a_thread.unwrap_or(quicker))
}

fn check_accumulation(plan: &mut Plan, request: &Request) -> Result<()> {
    if request.accumulation == Accumulation::F32 {
        return Ok(());
    }
    if plan.technique != Technique::Deferred || request.deferred_lights != DeferredLights::Volumes {
        return Err(Error::usage(
            "--accumulation f16 is for --technique deferred --deferred-lights volumes: everything else stores its sum once",
        ));
    }
    plan.notes.push(format!(
        "light is added in 16-bit floats: each sum is rounded to 11 bits, and past {MAX_HALF} it is infinite"
    ));
    Ok(())
}

fn light_pass(plan: &mut Plan, request: &Request, extent: f64, limits: &Limits) -> Result<LightPass> {
    let mut form = request.deferred_lights;
    // Every device blends into 16-bit floats (Vulkan 1.3, "Required Format Support").
    let blends = limits.float_blend || request.accumulation == Accumulation::F16;
    if form == DeferredLights::Volumes && plan.samples > 1 {
        let count = plan.samples;
        plan.notes.push(format!(
            "--msaa {count}: light volumes add up one sample a pixel, --deferred-lights fullscreen-branch stands in for them"
        ));
        form = DeferredLights::FullscreenBranch;
    }
    if form == DeferredLights::Volumes && !blends {
        plan.notes.push(
            "this device cannot blend into 32-bit floats: --deferred-lights fullscreen-branch stands in for volumes, to the same bits up to what f32 holds"
                .into(),
        );
        form = DeferredLights::FullscreenBranch;
    }
    if form == DeferredLights::Volumes {
        let directional = plan.lighting.lights.iter().filter(|l| l.kind == LightKind::Directional).count();
        check_loops(directional as u32, false, limits)?;
        return Ok(LightPass::Volumes(LightVolumes::new(&plan.lighting, &plan.view, extent, limits)?));
    }
    let branch = form == DeferredLights::FullscreenBranch && plan.lights.seek;
    check_loops(plan.lights.count, branch, limits)?;
    Ok(LightPass::Fullscreen { branch })
}

/// Offset and scale that turn stored depth into distance. Perspective: distance = offset / (depth + scale). Orthographic: distance =
/// offset - depth * scale.
pub fn depth_terms(view: &View) -> [f32; 2] {
    let clip = view.view_to_clip();
    let (scale, offset) = (clip.z_axis.z, clip.w_axis.z);
    let terms = if view.lens.is_perspective() { [offset, scale] } else { [offset / scale, 1.0 / scale] };
    terms.map(|x| x as f32)
}

/// Whether there is a G-buffer, and what it takes.
pub(super) fn effect(plan: &Plan) -> Effect {
    let planned = plan.deferred.as_ref().map(|d| d.gbuffer);
    let default = Gbuffer {
        layout: GbufferLayout::Compact,
        normal_bits: 16,
        emission: brightest_emission(plan) > 0.0,
        material: plan.stores_material(),
    };
    let bytes = planned.unwrap_or(default).texel_bytes();
    let why = match planned {
        None => format!("{} needs none", plan.technique.name()),
        Some(Gbuffer { layout: GbufferLayout::Fat, .. }) => format!("fat, {bytes} bytes a pixel: all in 32-bit floats"),
        Some(Gbuffer { normal_bits, emission, material, .. }) => {
            let emission = if emission { ", with emission" } else { ", nothing emits" };
            let material = if material { ", which material is seen" } else { "" };
            format!("compact, {bytes} bytes a pixel: normals in 2 x {normal_bits} bits{material}{emission}")
        }
    };
    Effect::new("gbuffer", planned.is_some(), why, bytes * plan.pixels())
}

/// Whether light volumes are drawn, and how many.
pub(super) fn volumes_effect(plan: &Plan) -> Effect {
    let (why, bytes) = match plan.deferred.as_ref().map(|d| (d, d.volumes())) {
        None => (format!("{} adds no light by blending", plan.technique.name()), 0),
        Some((_, Some(volumes))) => (volumes.why(), volumes.bytes()),
        Some((Deferred { light_pass: LightPass::Tiles { .. }, .. }, _)) => ("lights are listed by tile".into(), 0),
        Some((Deferred { light_pass: LightPass::Clusters, .. }, _)) => ("lights are listed by cluster".into(), 0),
        Some(_) => ("one pass loops over all lights".into(), 0),
    };
    let runs = plan.deferred.as_ref().is_some_and(|d| d.volumes().is_some());
    Effect::new("light_volumes", runs, why, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, builtin};

    /// Pixels that a thread of tiled-deferred shades.
    fn pixels(request: Request, shared_pair: f64) -> crate::error::Result<Option<u32>> {
        let mut scene = crate::scene::builtin::load("cornell").expect("a built-in scene");
        scene.lights = crate::scene::scatter::point_lights(&scene.bounds(), 8, 1);
        let profile = crate::plan::profile::Profile { shared_pair, ..Default::default() };
        let limits = Limits { profile: Some(profile), ..Limits::MINIMUM };
        let plan = Plan::new(&scene, &Request { width: 32, height: 32, ..request }, &limits)?;
        Ok(plan.deferred.and_then(|deferred| deferred.pixels_a_thread()))
    }

    #[test]
    fn a_thread_shades_as_many_pixels_as_are_quicker_or_asked_for() {
        let tiled = Request { technique: Technique::TiledDeferred, ..Request::default() };
        assert_eq!(pixels(tiled.clone(), 0.0).expect("a plan"), Some(4));
        assert_eq!(pixels(tiled.clone(), 1e9).expect("a plan"), Some(1));
        for asked in [1, 4] {
            let request = Request { pixels_a_thread: Some(asked), ..tiled.clone() };
            assert_eq!(pixels(request, 0.0).expect("a plan"), Some(asked));
        }
        let loose = Request { prepass: false, ..tiled.clone() };
        assert_eq!(pixels(loose.clone(), 0.0).expect("a plan"), Some(1));
        let refused = pixels(Request { pixels_a_thread: Some(4), ..loose }, 0.0).expect_err("lists seek").to_string();
        assert!(refused.contains("pre-pass"), "{refused}");
        let other = Request { technique: Technique::ClusteredDeferred, pixels_a_thread: Some(1), ..tiled };
        assert!(pixels(other, 0.0).expect_err("another technique").to_string().contains("clustered-deferred"));
    }

    fn scene() -> Scene {
        builtin::load("cornell").expect("a built-in scene")
    }

    fn plan(request: &Request, limits: &Limits) -> Result<Plan> {
        Plan::new(&scene(), request, limits)
    }

    fn deferred() -> Request {
        Request { technique: Technique::Deferred, ..Request::default() }
    }

    #[test]
    fn the_fat_layout_is_refused_where_four_attachments_are_all() {
        let request = Request { gbuffer: GbufferLayout::Fat, ..deferred() };
        let refused = plan(&request, &Limits::MINIMUM).expect_err("too many attachments").to_string();
        assert!(refused.contains("--gbuffer fat") && refused.contains('5') && refused.contains('4'), "{refused}");
        let limits = Limits { max_color_attachments: 5, ..Limits::MINIMUM };
        let gbuffer = plan(&request, &limits).expect("a plan").deferred.expect("deferred").gbuffer;
        assert_eq!(gbuffer.texel_bytes(), 80);
    }

    #[test]
    fn bytes_go_with_normals_and_emission() {
        let bytes = |normal_bits, emission| {
            Gbuffer { layout: GbufferLayout::Compact, normal_bits, emission, material: false }.texel_bytes()
        };
        assert_eq!([bytes(8, false), bytes(10, false), bytes(16, false), bytes(16, true)], [10, 12, 12, 20]);
        let planned = plan(&deferred(), &Limits::MINIMUM).expect("a plan").deferred.expect("deferred");
        // The lamp of the room emits.
        assert!(planned.gbuffer.emission);
    }

    #[test]
    fn without_float_blending_the_branching_loop_stands_in() {
        let without = plan(&deferred(), &Limits::MINIMUM).expect("a plan");
        assert!(without.notes.iter().any(|n| n.contains("cannot blend")));
        assert!(without.deferred.is_some_and(|d| matches!(d.light_pass, LightPass::Fullscreen { branch: true })));
        let limits = Limits { float_blend: true, ..Limits::MINIMUM };
        let with = plan(&deferred(), &limits).expect("a plan");
        assert!(with.deferred.is_some_and(|d| d.volumes().is_some()));
    }

    #[test]
    fn halves_are_for_volumes_and_blend_everywhere() {
        let halves = Request { accumulation: Accumulation::F16, ..deferred() };
        let planned = plan(&halves, &Limits::MINIMUM).expect("a plan");
        assert!(planned.notes.iter().any(|n| n.contains("16-bit floats")));
        let whole = plan(&deferred(), &Limits { float_blend: true, ..Limits::MINIMUM }).expect("a plan");
        assert_eq!(whole.attachment_bytes() - planned.attachment_bytes(), 8 * planned.pixels());
        assert!(planned.deferred.is_some_and(|d| d.volumes().is_some()));
        let fullscreen = Request { deferred_lights: DeferredLights::Fullscreen, ..halves.clone() };
        let forward = Request { technique: Technique::Forward, ..halves };
        for request in [fullscreen, forward] {
            let refused = plan(&request, &Limits::MINIMUM).expect_err("nothing blends").to_string();
            assert!(refused.contains("--accumulation f16"), "{refused}");
        }
    }
}
