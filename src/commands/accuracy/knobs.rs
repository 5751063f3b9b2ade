//! The knobs: their settings, what each is judged by, and the passes that it leaves alone.

use std::sync::Arc;

use super::bakes::{gathers, is_of_bounces, iterations, of_bakes, paths, tolerances};
use crate::cli::{Accuracy, KnobName};
use crate::commands::setup;
use crate::plan::gbuffer::FAT_ATTACHMENTS;
use crate::plan::samples::COUNTS;
use crate::plan::{
    Accumulation, Clusters, CullTest, DeferredLights, DepthBounds, GbufferLayout, Limits, Request, ShadowUpdate,
    Technique, TransparentBounds, TransparentSort,
};
use crate::radiosity::Bake;
use crate::scene::lighting::{DEFAULT_CUTOFF, LightRules, RangeRule};

/// A setting and what is drawn with it.
pub(super) type Setting = (String, Request);

/// Which of the reference's pictures settings are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Against {
    /// The same lights, a ray a pixel.
    Own,
    /// Lights of infinite range: the settings change the lighting.
    Unbounded,
    /// Eight rays a pixel, edges included.
    Samples,
    /// Rays look for what stands in the way of the lights that matter most, of [`SHADOWED`].
    Shadows,
    /// All lights have shadow rays, and paths find what bounces; means of squares of pixels are compared.
    Bounces,
}

impl Against {
    /// In the machine form.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Own => "own ranges",
            Self::Unbounded => "infinite ranges",
            Self::Samples => "own ranges, 8 rays a pixel",
            Self::Shadows => "own ranges, shadow rays",
            Self::Bounces => "own ranges, shadow rays and paths",
        }
    }
}

/// Settings that differ in one thing.
pub(super) struct Knob {
    /// As typed.
    pub(super) name: &'static str,
    /// What it decides.
    pub(super) title: &'static str,
    /// Beginnings of the names of passes that it does not touch.
    pub(super) spared: &'static [&'static str],
    /// What its settings are judged by.
    pub(super) against: Against,
    pub(super) settings: Vec<Setting>,
}

/// Pixels along a tile's side.
const TILES: [u32; 4] = [8, 16, 32, 64];

/// Cut-offs by their typed names.
const CUTOFFS: [(&str, f64); 4] = [("0.1", 0.1), ("5/256", DEFAULT_CUTOFF), ("0.005", 0.005), ("0.001", 0.001)];

/// Slices an octave: more than 32 pass the 512 that a key holds where the eye's near plane is near.
const SLICES: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// Lights whose shadows are judged.
pub(super) const SHADOWED: u32 = 4;

/// Columns of shadow maps.
const SHADOW_SIZES: [u32; 5] = [128, 256, 512, 1024, 2048];

/// Texels of their filter.
const SHADOW_FILTERS: [u32; 5] = [0, 1, 2, 4, 8];

/// The depth pre-pass and the lists of tiles.
const BEFORE: &[&str] = &["depth_prepass", "depth_reduce", "tile_", "bin_"];

/// What is drawn where no knob is turned. What has a G-buffer has the fat one where it fits: it rounds nothing, so that what a knob
/// rounds is seen.
pub(super) fn base(args: &Accuracy, limits: &Limits) -> Request {
    let (width, height) = args.size.unwrap_or(if args.quick { (160, 90) } else { (320, 180) });
    let range = args.light_range.map_or(LightRules::default().range, setup::range);
    let rules = LightRules { range, ..LightRules::default() };
    let shading = setup::shading(args.shading);
    let fat = limits.max_color_attachments >= FAT_ATTACHMENTS;
    let gbuffer = if fat { GbufferLayout::Fat } else { GbufferLayout::Compact };
    Request { width, height, shading, rules, gbuffer, technique: Technique::TiledForward, ..Request::default() }
}

/// The knob of that name, turned on `base`, and on bakes where it is one of bounced light.
pub(super) fn knob(name: KnobName, base: &Request, bakes: &[Arc<Bake>]) -> Knob {
    let against = match name {
        KnobName::LightCutoff => Against::Unbounded,
        KnobName::Msaa => Against::Samples,
        KnobName::ShadowSize | KnobName::ShadowFilter => Against::Shadows,
        name if is_of_bounces(name) => Against::Bounces,
        _ => Against::Own,
    };
    let spared: &[&str] = match name {
        KnobName::Tile | KnobName::DepthBounds => &["depth_prepass"],
        KnobName::Cull | KnobName::LightCutoff => &["depth_prepass", "depth_reduce"],
        KnobName::Accumulation => &["depth_prepass", "gbuffer"],
        KnobName::Gbuffer | KnobName::Slices => BEFORE,
        KnobName::ClusterNormals => &["depth_prepass", "depth_reduce", "tile_", "bin_", "gbuffer"],
        KnobName::Msaa => &["tile_", "bin_"],
        KnobName::ShadowSize | KnobName::ShadowFilter => BEFORE,
        KnobName::TransparentBounds => &["depth_prepass", "tile_bin", "bin_"],
        KnobName::TransparentSort => &["depth_prepass", "forward"],
        KnobName::GiGathers | KnobName::GiTolerance | KnobName::GiIteration | KnobName::GiPath | KnobName::GiCodec => {
            &["depth_prepass", "depth_reduce", "tile_", "bin_", "shadow_map", "patch_light"]
        }
        KnobName::GiPatches => &["depth_prepass", "depth_reduce", "tile_", "bin_", "shadow_map"],
    };
    let (name, title, settings) = match name {
        KnobName::Tile => ("tile", "pixels along a tile's side, of tiled-forward", tiles(base)),
        KnobName::Cull => ("cull", "which lights a tile takes, of tiled-forward", culls(base)),
        KnobName::DepthBounds => {
            ("depth-bounds", "what culling knows of a tile's depths, of tiled-forward", bounds(base))
        }
        KnobName::Gbuffer => ("gbuffer", "what the G-buffer stores, of tiled-deferred", gbuffers(base)),
        KnobName::LightCutoff => {
            ("light-cutoff", "cut-off from which ranges are solved, of tiled-forward", cutoffs(base))
        }
        KnobName::Accumulation => ("accumulation", "what light volumes add in, of deferred", accumulations(base)),
        KnobName::Slices => ("slices", "depth of clusters, of clustered-forward", slices(base)),
        KnobName::ClusterNormals => {
            ("cluster-normals", "whether clusters tell normals apart, of clustered-deferred", normals(base))
        }
        KnobName::Msaa => ("msaa", "samples a pixel, of tiled-forward", counts(base)),
        KnobName::ShadowSize => {
            ("shadow-size", "columns of the shadow maps of 4 lights, of tiled-forward", shadow_sizes(base))
        }
        KnobName::ShadowFilter => {
            ("shadow-filter", "texels that edges of shadows are spread over, of tiled-forward", shadow_filters(base))
        }
        KnobName::TransparentBounds => (
            "transparent-bounds",
            "what light lists of blended surfaces know of depths, of tiled-forward",
            transparent_bounds(base),
        ),
        KnobName::TransparentSort => {
            ("transparent-sort", "what of blended surfaces is put in order, of forward", transparent_sorts(base))
        }
        KnobName::GiGathers => ("gi-gathers", "gathers of bounced light, of tiled-forward", gathers(base, bakes)),
        KnobName::GiTolerance => (
            "gi-tolerance",
            "share of light that bounced light may leave out, of tiled-forward",
            tolerances(base, bakes),
        ),
        KnobName::GiIteration => {
            ("gi-iteration", "how gathers of bounced light are put together, of tiled-forward", iterations(base, bakes))
        }
        KnobName::GiPath => {
            ("gi-path", "what the matrix of bounced light is read from, of tiled-forward", paths(base, bakes))
        }
        KnobName::GiPatches => (
            "gi-patches",
            "patches of bounced light, of tiled-forward",
            of_bakes(base, bakes, |bake| bake.patches.list.len().to_string()),
        ),
        KnobName::GiCodec => (
            "gi-codec",
            "how the matrix of bounced light is stored, of tiled-forward",
            of_bakes(base, bakes, |bake| {
                format!("{}, {:.3} bytes an element", bake.settings.codec.name(), bake.bytes_an_element())
            }),
        ),
    };
    Knob { name, title, spared, against, settings }
}

impl Knob {
    /// A pass whose time may differ from setting to setting.
    pub(super) fn touches(&self, pass: &str) -> bool {
        !self.spared.iter().any(|spared| pass.starts_with(spared))
    }
}

fn tiles(base: &Request) -> Vec<Setting> {
    TILES.map(|tile| (tile.to_string(), Request { tile, ..base.clone() })).to_vec()
}

fn culls(base: &Request) -> Vec<Setting> {
    CullTest::ALL.map(|cull| (cull.name().to_string(), Request { cull, ..base.clone() })).to_vec()
}

fn bounds(base: &Request) -> Vec<Setting> {
    let of = |bounds: DepthBounds| (bounds.name().to_string(), Request { depth_bounds: Some(bounds), ..base.clone() });
    DepthBounds::ALL.map(of).to_vec()
}

fn gbuffers(base: &Request) -> Vec<Setting> {
    let base = Request { technique: Technique::TiledDeferred, ..base.clone() };
    let fat = ("fat".to_string(), Request { gbuffer: GbufferLayout::Fat, ..base.clone() });
    let compact = |normal_bits: u32| {
        let request = Request { gbuffer: GbufferLayout::Compact, normal_bits, ..base.clone() };
        (format!("compact, normals in 2 x {normal_bits} bits"), request)
    };
    vec![fat, compact(16), compact(10), compact(8)]
}

fn cutoffs(base: &Request) -> Vec<Setting> {
    let of = |(name, cutoff): (&str, f64)| {
        let rules = LightRules { range: RangeRule::Cutoff(cutoff), ..base.rules.clone() };
        (name.to_string(), Request { rules, ..base.clone() })
    };
    CUTOFFS.map(of).to_vec()
}

fn accumulations(base: &Request) -> Vec<Setting> {
    let base = Request { technique: Technique::Deferred, deferred_lights: DeferredLights::Volumes, ..base.clone() };
    let of = |accumulation: Accumulation| (accumulation.name().to_string(), Request { accumulation, ..base.clone() });
    Accumulation::ALL.map(of).to_vec()
}

fn slices(base: &Request) -> Vec<Setting> {
    let base = Request { technique: Technique::ClusteredForward, ..base.clone() };
    let of = |slices: u32| (slices.to_string(), Request { slices_per_octave: Some(slices), ..base.clone() });
    std::iter::once(("auto".to_string(), base.clone())).chain(SLICES.map(of)).collect()
}

fn normals(base: &Request) -> Vec<Setting> {
    // Codes of normals are what tells.
    let base = Request { technique: Technique::ClusteredDeferred, gbuffer: GbufferLayout::Compact, ..base.clone() };
    let of = |(name, cluster_normals): (&str, bool)| (name.to_string(), Request { cluster_normals, ..base.clone() });
    [("off", false), ("on", true)].map(of).to_vec()
}

fn counts(base: &Request) -> Vec<Setting> {
    let of = |msaa: u32| (msaa.to_string(), Request { msaa, strict: true, ..base.clone() });
    COUNTS.map(of).to_vec()
}

/// Maps are drawn in every frame, so that their time is seen.
fn shadowed(base: &Request) -> Request {
    Request { shadows: Some(SHADOWED), shadow_update: ShadowUpdate::Frame, ..base.clone() }
}

fn shadow_sizes(base: &Request) -> Vec<Setting> {
    let of = |shadow_size: u32| (shadow_size.to_string(), Request { shadow_size, ..shadowed(base) });
    SHADOW_SIZES.map(of).to_vec()
}

fn shadow_filters(base: &Request) -> Vec<Setting> {
    let of = |shadow_filter: u32| (shadow_filter.to_string(), Request { shadow_filter, ..shadowed(base) });
    SHADOW_FILTERS.map(of).to_vec()
}

fn transparent_bounds(base: &Request) -> Vec<Setting> {
    let of = |bounds: TransparentBounds| {
        (bounds.name().to_string(), Request { transparent_bounds: Some(bounds), ..base.clone() })
    };
    TransparentBounds::ALL.map(of).to_vec()
}

fn transparent_sorts(base: &Request) -> Vec<Setting> {
    let base = Request { technique: Technique::Forward, ..base.clone() };
    let of = |transparent_sort: TransparentSort| {
        (transparent_sort.name().to_string(), Request { transparent_sort, ..base.clone() })
    };
    TransparentSort::ALL.map(of).to_vec()
}

/// Turned on a scene that has nothing blended, the knob does nothing.
pub(super) fn needs_blended(name: KnobName) -> bool {
    matches!(name, KnobName::TransparentBounds | KnobName::TransparentSort)
}

/// A setting's name with what the plan made of it.
pub(super) fn planned(setting: &str, clusters: &Clusters) -> String {
    let grid = &clusters.grid;
    let octave = f64::from(23 - grid.slice_shift as i32).exp2();
    let slices = match octave.to_string() {
        // A lens without perspective has slices of one depth.
        _ if grid.slice_top == 0 => setting.to_string(),
        octave if octave == setting => format!("{octave} an octave"),
        octave => format!("{setting} ({octave} an octave)"),
    };
    format!("{slices}, {}-bit keys", clusters.key_bits)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::passes;
    use crate::plan::Plan;
    use crate::scene::builtin;

    fn request() -> Request {
        Request { width: 64, height: 36, technique: Technique::TiledForward, ..Request::default() }
    }

    fn scene_for(name: KnobName) -> crate::scene::Scene {
        let spec = if needs_blended(name) { "glass:layers=2" } else { "cornell" };
        builtin::load(spec).expect("a built-in scene")
    }

    /// Limits of a device that every knob can be turned on.
    fn able() -> Limits {
        Limits {
            max_color_attachments: 5,
            float_blend: true,
            samples: [1 | 2 | 4 | 8; 2],
            max_stage_storage_buffers: 8,
            ..Limits::MINIMUM
        }
    }

    fn bakes(name: KnobName, scene: &crate::scene::Scene) -> Vec<Arc<Bake>> {
        super::super::bakes::of_knob(name, scene, true).expect("bakes")
    }

    #[test]
    fn every_setting_is_planned_and_has_passes_that_its_knob_touches_and_others() {
        let limits = able();
        for name in KnobName::value_variants() {
            let scene = scene_for(*name);
            let knob = knob(*name, &request(), &bakes(*name, &scene));
            let typed = name.to_possible_value().expect("a value");
            assert_eq!(knob.name, typed.get_name());
            assert!(knob.settings.len() > 1, "{}", knob.name);
            for (setting, request) in &knob.settings {
                let plan = Plan::new(&scene, request, &limits).expect("a plan");
                let graph = passes::frame(&plan).graph;
                let passes: Vec<&str> = graph.nodes[graph.frame_range()].iter().map(|node| &*node.name).collect();
                let touched = passes.iter().filter(|pass| knob.touches(pass)).count();
                assert!(touched > 0 && touched < passes.len(), "{} {setting}: {touched} of {passes:?}", knob.name);
            }
        }
    }

    #[test]
    fn each_knob_has_the_default_among_its_settings() {
        let limits = able();
        for name in KnobName::value_variants() {
            let scene = scene_for(*name);
            let knob = knob(*name, &request(), &bakes(*name, &scene));
            let frame = |request: &Request| {
                let plan = Plan::new(&scene, request, &limits).expect("a plan");
                let blended = plan.transparency.as_ref().map(|planned| (planned.bounds, planned.sort));
                let parts =
                    [format!("{:?}", plan.tiles), format!("{:?}", plan.lighting), format!("{:?}", plan.deferred)];
                let maps = plan.shadows.as_ref().map(|shadows| (shadows.size, shadows.filter));
                let light = plan.bounced.as_ref().map(|of| (of.steps.clone(), of.patches.len(), of.bake.settings));
                (parts, plan.samples, blended, maps, light)
            };
            let Request { technique, shadows, shadow_update, gi, .. } = knob.settings[0].1;
            let (bake, rules) = (knob.settings[0].1.bake.clone(), knob.settings[0].1.rules.clone());
            let rules = if bake.is_some() { rules } else { request().rules };
            let default = frame(&Request { technique, shadows, shadow_update, gi, bake, rules, ..request() });
            assert!(knob.settings.iter().any(|(_, request)| frame(request) == default), "{}", knob.name);
        }
    }

    #[test]
    fn slices_are_named_by_what_was_planned() {
        let scene = builtin::load("cornell").expect("a built-in scene");
        let named = |setting: &str, slices: Option<u32>| {
            let request = Request { technique: Technique::ClusteredForward, slices_per_octave: slices, ..request() };
            let plan = Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan");
            planned(setting, &plan.clusters.expect("clusters"))
        };
        assert!(named("2", Some(2)).starts_with("2 an octave, "));
        assert!(named("auto", None).starts_with("auto (") && named("auto", None).ends_with("-bit keys"));
    }
}
