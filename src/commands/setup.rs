//! From shared options to scene and request.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::bake;
use crate::cli::{
    AccumulationArg, AssignArg, ClusterBoundsArg, CullArg, DebugViewArg, DeferredLightsArg, DepthBoundsArg,
    DepthReduceArg, FetchArg, GbufferArg, GiArg, GiArgs, IterationArg, LimitsChoice, MatrixPathArg, OnOff, ShadingArg,
    ShadowUpdateArg, Shared, TechniqueChoice, TransparentBoundsArg, TransparentSortArg,
};
use crate::error::{Error, Result};
use crate::plan::overrides;
use crate::plan::{
    Accumulation, AssignChoice, CameraChoice, ClusterBounds, CullTest, DebugView, DeferredLights, DepthBounds,
    FetchChoice, Gathering, GbufferLayout, Gi, Iteration, Limits, MatrixPath, Request, ShadowUpdate, Technique,
    TransparentBounds, TransparentSort,
};
use crate::radiosity::files;
use crate::renderer::Renderer;
use crate::scene::lighting::{Attenuation, LightRules, RangeRule};
use crate::scene::shading::Shading;
use crate::scene::{Scene, builtin, gltf, scatter};

/// Most lights that are scattered: more would not fit into the index type of light lists.
const MOST_LIGHTS: u32 = 1 << 24;

/// Degrees.
const DEFAULT_FOV: f64 = 60.0;

/// Loads a file or builds a scene, by its spelling.
///
/// # Errors
/// An unknown name, or whatever the loader finds.
pub fn load_scene(spec: &str) -> Result<Scene> {
    match spec.strip_prefix("builtin:") {
        Some(name) => builtin::load(name),
        None => gltf::load(Path::new(spec)),
    }
}

/// Replaces the scene's lights with scattered ones, where asked.
///
/// # Errors
/// Too many.
pub fn scatter_lights(scene: &mut Scene, count: Option<u32>, seed: u64) -> Result<()> {
    let Some(count) = count else { return Ok(()) };
    if count > MOST_LIGHTS {
        return Err(Error::usage(format!("--lights {count} passes {MOST_LIGHTS}, the most that can be scattered")));
    }
    scene.lights = scatter::point_lights(&scene.bounds(), count as usize, seed);
    Ok(())
}

/// The scene with its lights as the options want them.
///
/// # Errors
/// See [`load_scene`] and [`scatter_lights`].
pub fn scene(spec: &str, shared: &Shared) -> Result<Scene> {
    let mut scene = load_scene(spec)?;
    scatter_lights(&mut scene, shared.lights, shared.light_seed)?;
    Ok(scene)
}

/// Reflection model.
pub fn shading(arg: ShadingArg) -> Shading {
    match arg {
        ShadingArg::Lambert => Shading::Lambert,
        ShadingArg::Phong => Shading::Phong,
        ShadingArg::Gltf => Shading::Gltf,
    }
}

/// Ranges as `--light-range` gives them.
pub fn range(metres: f64) -> RangeRule {
    if metres == f64::INFINITY { RangeRule::Infinite } else { RangeRule::Fixed(metres) }
}

fn rules(shared: &Shared) -> Result<LightRules> {
    let mut rules = LightRules { emission_lights: shared.bounced.gi != GiArg::Off, ..LightRules::default() };
    if let Some([r, g, b]) = shared.ambient {
        rules.ambient = Vec3::new(r as f32, g as f32, b as f32);
    }
    if let Some([constant, linear, quadratic]) = shared.attenuation {
        rules.attenuation = Attenuation { constant, linear, quadratic };
    }
    rules.range = match (shared.light_range, shared.light_cutoff) {
        (Some(_), Some(_)) => {
            return Err(Error::usage("--light-range and --light-cutoff both decide the range of lights: give one"));
        }
        (Some(metres), None) => range(metres),
        (None, Some(cutoff)) => RangeRule::Cutoff(cutoff),
        (None, None) => rules.range,
    };
    Ok(rules)
}

fn depth_bounds(shared: &Shared) -> Result<Option<DepthBounds>> {
    let bounds = shared.depth_bounds.map(|bounds| match bounds {
        DepthBoundsArg::Off => DepthBounds::Off,
        DepthBoundsArg::Minmax => DepthBounds::MinMax,
        DepthBoundsArg::Mask => DepthBounds::Mask,
    });
    match bounds {
        Some(bounds) if bounds != DepthBounds::Off && shared.prepass == OnOff::Off => Err(Error::usage(format!(
            "--depth-bounds {} needs the depths that --prepass off leaves out",
            bounds.name()
        ))),
        bounds => Ok(bounds),
    }
}

fn cluster_bounds(shared: &Shared) -> Result<Option<ClusterBounds>> {
    match shared.cluster_bounds {
        Some(ClusterBoundsArg::Explicit) if shared.prepass == OnOff::Off => {
            Err(Error::usage("--cluster-bounds explicit needs the samples that --prepass off leaves out"))
        }
        bounds => Ok(bounds.map(|bounds| match bounds {
            ClusterBoundsArg::Implicit => ClusterBounds::Implicit,
            ClusterBoundsArg::Explicit => ClusterBounds::Explicit,
        })),
    }
}

/// Both, with what was forced and forbidden.
///
/// # Errors
/// See [`scene`] and [`request`]; overrides that contradict each other.
pub fn scene_and_request(spec: &str, shared: &Shared) -> Result<(Scene, Request)> {
    let mut request = request(shared)?;
    let mut scene = scene(spec, shared)?;
    overrides::apply(&mut scene, &mut request, &shared.effects.force, &shared.effects.forbid)?;
    // Unless it is forbidden.
    if let (GiArg::Radiosity(folder), Gi::Radiosity(_)) = (&shared.bounced.gi, request.gi) {
        request.bake = Some(Arc::new(match folder {
            Some(folder) => files::load(folder, &scene.surface_fingerprint())?,
            None => bake::cached(&scene, shared.driver.as_deref())?,
        }));
    }
    Ok((scene, request))
}

/// The request that the options make.
///
/// # Errors
/// Options that contradict each other.
pub fn request(shared: &Shared) -> Result<Request> {
    let camera = match (&shared.camera, shared.look_from, shared.look_at) {
        (Some(name), ..) => CameraChoice::Named(name.clone()),
        (None, Some(from), Some(at)) => CameraChoice::LookAt(
            DVec3::from_array(from),
            DVec3::from_array(at),
            shared.fov.unwrap_or(DEFAULT_FOV).to_radians(),
        ),
        _ => CameraChoice::Default,
    };
    Ok(Request {
        width: shared.size.0,
        height: shared.size.1,
        technique: match shared.technique {
            TechniqueChoice::Auto => Technique::Auto,
            TechniqueChoice::Forward => Technique::Forward,
            TechniqueChoice::Deferred => Technique::Deferred,
            TechniqueChoice::TiledDeferred => Technique::TiledDeferred,
            TechniqueChoice::TiledForward => Technique::TiledForward,
            TechniqueChoice::ClusteredDeferred => Technique::ClusteredDeferred,
            TechniqueChoice::ClusteredForward => Technique::ClusteredForward,
            TechniqueChoice::Reference => Technique::Reference,
        },
        prepass: shared.prepass == OnOff::On,
        shading: shading(shared.shading),
        rules: rules(shared)?,
        fetch: match shared.light_fetch {
            FetchArg::Auto => FetchChoice::Auto,
            FetchArg::Storage => FetchChoice::Storage,
            FetchArg::Uniform => FetchChoice::Uniform,
            FetchArg::Texel => FetchChoice::Texel,
        },
        tile: shared.tile,
        cull: match shared.cull {
            CullArg::Bounds => CullTest::Bounds,
            CullArg::BoundsTextbook => CullTest::BoundsTextbook,
            CullArg::Frustum => CullTest::Frustum,
            CullArg::FrustumAabb => CullTest::FrustumAabb,
        },
        depth_bounds: depth_bounds(shared)?,
        cluster_bounds: cluster_bounds(shared)?,
        slices_per_octave: shared.slices_per_octave,
        assign: match shared.assign {
            AssignArg::Auto => AssignChoice::Auto,
            AssignArg::Tiles => AssignChoice::Tiles,
            AssignArg::Tree => AssignChoice::Tree,
        },
        cluster_normals: shared.cluster_normals,
        deferred_lights: match shared.deferred_lights {
            DeferredLightsArg::Volumes => DeferredLights::Volumes,
            DeferredLightsArg::Fullscreen => DeferredLights::Fullscreen,
            DeferredLightsArg::FullscreenBranch => DeferredLights::FullscreenBranch,
        },
        gbuffer: match shared.gbuffer {
            GbufferArg::Fat => GbufferLayout::Fat,
            GbufferArg::Compact => GbufferLayout::Compact,
        },
        normal_bits: shared.normal_bits,
        group_a_tile: shared.depth_reduce.map(|by| by == DepthReduceArg::Group),
        pixels_a_thread: shared.pixels_a_thread,
        accumulation: match shared.accumulation {
            AccumulationArg::F32 => Accumulation::F32,
            AccumulationArg::F16 => Accumulation::F16,
        },
        msaa: shared.effects.msaa,
        shadows: shared.effects.shadows,
        shadow_size: shared.effects.shadow_size,
        lights_move: false,
        shadow_update: match shared.effects.shadow_update {
            ShadowUpdateArg::Once => ShadowUpdate::Once,
            ShadowUpdateArg::Frame => ShadowUpdate::Frame,
        },
        shadow_filter: shared.effects.shadow_filter,
        overrides: Vec::new(),
        strict: shared.effects.strict,
        transparent_bounds: shared.effects.transparent_bounds.map(|bounds| match bounds {
            TransparentBoundsArg::Own => TransparentBounds::Own,
            TransparentBoundsArg::Merged => TransparentBounds::Merged,
            TransparentBoundsArg::None => TransparentBounds::None,
        }),
        transparent_sort: match shared.effects.transparent_sort {
            TransparentSortArg::Object => TransparentSort::Object,
            TransparentSortArg::Triangle => TransparentSort::Triangle,
        },
        gi: gi(&shared.bounced)?,
        bake: None,
        show_lights: shared.show_lights,
        camera,
        debug_view: shared.debug_view.map(|view| match view {
            DebugViewArg::Albedo => DebugView::Albedo,
            DebugViewArg::Normals => DebugView::Normals,
            DebugViewArg::Depth => DebugView::Depth,
            DebugViewArg::DepthRaw => DebugView::DepthRaw,
            DebugViewArg::TileMin => DebugView::TileMin,
            DebugViewArg::TileMax => DebugView::TileMax,
            DebugViewArg::TileLights => DebugView::TileLights,
            DebugViewArg::TileMask => DebugView::TileMask,
            DebugViewArg::Clusters => DebugView::Clusters,
            DebugViewArg::ClusterLights => DebugView::ClusterLights,
            DebugViewArg::Slices => DebugView::Slices,
            DebugViewArg::Quads => DebugView::Quads,
            DebugViewArg::Missed => DebugView::Missed,
            DebugViewArg::Waste => DebugView::Waste,
            DebugViewArg::Lights => DebugView::Lights,
            DebugViewArg::GbufferAlbedo => DebugView::GbufferAlbedo,
            DebugViewArg::GbufferNormal => DebugView::GbufferNormal,
            DebugViewArg::GbufferMaterial => DebugView::GbufferMaterial,
            DebugViewArg::GbufferEmission => DebugView::GbufferEmission,
        }),
    })
}

fn gi(args: &GiArgs) -> Result<Gi> {
    let of_paths = args.spp.is_some() || args.gi_seed.is_some();
    let of_iteration = args.gi_gathers.is_some() || args.gi_tolerance.is_some() || args.gi_iteration.is_some();
    let of_gathers = of_iteration || args.gi_path.is_some() || args.gi_feedback;
    if args.gi_feedback && (args.gi_tolerance.is_some() || args.gi_iteration.is_some()) {
        return Err(Error::usage("--gi-feedback gathers --gi-gathers times a frame, bounce by bounce"));
    }
    match args.gi {
        GiArg::Path => {}
        _ if of_paths => return Err(Error::usage("--spp and --gi-seed are options of --gi path")),
        _ => {}
    }
    match args.gi {
        GiArg::Radiosity(_) => Ok(Gi::Radiosity(Gathering {
            gathers: args.gi_gathers,
            tolerance: args.gi_tolerance.unwrap_or(Gathering::TOLERANCE),
            iteration: match args.gi_iteration {
                Some(IterationArg::Neumann) => Iteration::Neumann,
                Some(IterationArg::Chebyshev) | None => Iteration::Chebyshev,
            },
            path: match args.gi_path {
                None | Some(MatrixPathArg::Auto) => MatrixPath::Auto,
                Some(MatrixPathArg::Buffer) => MatrixPath::Buffer,
                Some(MatrixPathArg::Texel) => MatrixPath::Texel,
                Some(MatrixPathArg::Sampled) => MatrixPath::Sampled,
            },
            thread_rows: false,
            feedback: args.gi_feedback,
        })),
        _ if of_gathers => Err(Error::usage(
            "--gi-gathers, --gi-tolerance, --gi-iteration, --gi-path and --gi-feedback are options of --gi radiosity",
        )),
        GiArg::Off => Ok(Gi::Off),
        GiArg::Path => Ok(Gi::Path { paths: args.spp.unwrap_or(Gi::PATHS), seed: args.gi_seed.unwrap_or(Gi::SEED) }),
    }
}

/// The limits that plans are made for.
pub fn limits(shared: &Shared, renderer: Option<&Renderer>) -> Limits {
    match (shared.limits, renderer) {
        (LimitsChoice::Device, Some(renderer)) => renderer.limits(),
        (LimitsChoice::Device, None) => Limits::UNLIMITED,
        (LimitsChoice::Minimum, _) => Limits::MINIMUM,
    }
}
