//! What the user asked for, free of how it was typed.

mod choices;

use std::sync::Arc;

use glam::DVec3;

use super::DebugView;
use super::overrides::Override;
use crate::error::{Error, Result};
use crate::radiosity::Bake;
use crate::scene::lighting::LightRules;
use crate::scene::shading::Shading;
use crate::scene::{Camera, Projection, Scene};

pub use choices::{
    Accumulation, AssignChoice, ClusterBounds, CullTest, DeferredLights, DepthBounds, FetchChoice, Gathering,
    GbufferLayout, Gi, Iteration, MatrixPath, ShadowUpdate, TransparentBounds, TransparentSort,
};

/// Ways to light a picture. Each draws what `Forward` defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Technique {
    /// The plan chooses.
    Auto,
    /// Every fragment loops over all lights.
    Forward,
    /// Lights are added over a G-buffer, one after the other or all in one pass.
    Deferred,
    /// Every pixel of a G-buffer loops over the lights of its screen tile.
    TiledDeferred,
    /// Every fragment loops over the lights of its screen tile.
    TiledForward,
    /// Every pixel of a G-buffer loops over the lights of its cluster: a slice of its screen tile.
    ClusteredDeferred,
    /// Every fragment loops over the lights of its cluster.
    ClusteredForward,
    /// Rays in f64 on the CPU.
    Reference,
}

impl Technique {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Forward => "forward",
            Self::Deferred => "deferred",
            Self::TiledDeferred => "tiled-deferred",
            Self::TiledForward => "tiled-forward",
            Self::ClusteredDeferred => "clustered-deferred",
            Self::ClusteredForward => "clustered-forward",
            Self::Reference => "reference",
        }
    }

    /// Lights are listed, by tile or by cluster.
    pub fn has_lists(self) -> bool {
        self.clusters() || matches!(self, Self::TiledDeferred | Self::TiledForward)
    }

    /// Lights meet a G-buffer.
    pub fn is_deferred(self) -> bool {
        matches!(self, Self::Deferred | Self::TiledDeferred | Self::ClusteredDeferred)
    }

    /// Light lists are those of clusters.
    pub fn clusters(self) -> bool {
        matches!(self, Self::ClusteredDeferred | Self::ClusteredForward)
    }
}

/// How the camera is chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraChoice {
    /// The scene's first, else one that frames the scene.
    Default,
    /// By name or index.
    Named(String),
    /// At a place, looking at another, with a vertical field of view in radians.
    LookAt(DVec3, DVec3, f64),
}

/// A picture that is wanted.
#[derive(Debug, Clone)]
pub struct Request {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// How to light.
    pub technique: Technique,
    /// Depth first.
    pub prepass: bool,
    /// BRDF.
    pub shading: Shading,
    /// Ambient, falloff, ranges.
    pub rules: LightRules,
    /// Light data.
    pub fetch: FetchChoice,
    /// Pixels along each side of a tile: 8, 16, 32 or 64.
    pub tile: u32,
    /// Which lights a tile takes.
    pub cull: CullTest,
    /// What it knows of its depths; `None`: as much as there is.
    pub depth_bounds: Option<DepthBounds>,
    /// What bounds a cluster; `None`: as much as there is.
    pub cluster_bounds: Option<ClusterBounds>,
    /// Slices of clusters in each doubling of distance, a power of two; `None`: about as deep as the tile is wide.
    pub slices_per_octave: Option<u32>,
    /// Where clusters find their candidates.
    pub assign: AssignChoice,
    /// Clusters tell directions of normals apart, and leave out lights behind all of theirs.
    pub cluster_normals: bool,
    /// How `deferred` adds lights.
    pub deferred_lights: DeferredLights,
    /// What the G-buffer stores.
    pub gbuffer: GbufferLayout,
    /// Of each of a normal's two codes in the compact G-buffer: 8, 10 or 16.
    pub normal_bits: u32,
    /// A group of threads reduces the depths of a tile, else one thread; `None`: as the profile has it quicker.
    pub group_a_tile: Option<bool>,
    /// Pixels that a thread of `tiled-deferred` shades, 1 or 4; `None`: as the profile has it quicker.
    pub pixels_a_thread: Option<u32>,
    /// What light volumes add in.
    pub accumulation: Accumulation,
    /// Samples a pixel: 1, 2, 4 or 8.
    pub msaa: u32,
    /// So many lights, those that matter most, have shadows; `None`: those that ask.
    pub shadows: Option<u32>,
    /// Columns and rows of a shadow map.
    pub shadow_size: u32,
    /// When maps are drawn.
    pub shadow_update: ShadowUpdate,
    /// Lights will turn, or be switched ([`Plan::relit`](super::Plan::relit)): shadow maps have places for all that they may come to show, and lamps that
    /// are off keep theirs. Lists of lights have the room that lights need as they are planned at first: lamps should be on then.
    pub lights_move: bool,
    /// Texels that the edge of a shadow is spread over, 0 to 8.
    pub shadow_filter: u32,
    /// Effects that were forced or forbidden (`plan/overrides.rs`).
    pub overrides: Vec<Override>,
    /// What this device lacks is refused instead of replaced.
    pub strict: bool,
    /// What lists of blended surfaces know of depths; `None`: what is best where there are lists.
    pub transparent_bounds: Option<TransparentBounds>,
    /// What of blended surfaces is put in order.
    pub transparent_sort: TransparentSort,
    /// Bounced light.
    pub gi: Gi,
    /// What [`Gi::Radiosity`] gathers with.
    pub bake: Option<Arc<Bake>>,
    /// A small sphere where each light stands.
    pub show_lights: bool,
    /// Which camera.
    pub camera: CameraChoice,
    /// Instead of radiance.
    pub debug_view: Option<DebugView>,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            technique: Technique::Auto,
            prepass: true,
            shading: Shading::Gltf,
            rules: LightRules::default(),
            fetch: FetchChoice::Auto,
            tile: 16,
            cull: CullTest::FrustumAabb,
            depth_bounds: None,
            cluster_bounds: None,
            slices_per_octave: None,
            assign: AssignChoice::Auto,
            cluster_normals: false,
            deferred_lights: DeferredLights::Volumes,
            gbuffer: GbufferLayout::Compact,
            normal_bits: 16,
            group_a_tile: None,
            pixels_a_thread: None,
            accumulation: Accumulation::F32,
            msaa: 1,
            shadows: None,
            shadow_size: super::shadows::DEFAULT_SIZE,
            shadow_update: ShadowUpdate::Once,
            lights_move: false,
            shadow_filter: super::shadows::DEFAULT_FILTER,
            overrides: Vec::new(),
            strict: false,
            transparent_bounds: None,
            transparent_sort: TransparentSort::Object,
            gi: Gi::Off,
            bake: None,
            show_lights: false,
            camera: CameraChoice::Default,
            debug_view: None,
        }
    }
}

impl Request {
    /// The camera of the picture.
    ///
    /// # Errors
    /// A camera that the scene does not have.
    pub fn camera(&self, scene: &Scene, notes: &mut Vec<String>) -> Result<Camera> {
        let aspect = f64::from(self.width) / f64::from(self.height);
        match &self.camera {
            CameraChoice::LookAt(from, at, yfov) => {
                if !(from.is_finite() && at.is_finite()) || from == at {
                    return Err(Error::usage(format!("--look-from {from} and --look-at {at} give no direction")));
                }
                Ok(Camera::looking(*from, *at, *yfov))
            }
            CameraChoice::Named(name) => {
                let by_name = scene.cameras.iter().find(|c| c.name == *name);
                let by_index = || name.parse().ok().and_then(|i: usize| scene.cameras.get(i));
                by_name.or_else(by_index).cloned().ok_or_else(|| {
                    let known: Vec<_> = scene.cameras.iter().map(|c| format!("\"{}\"", c.name)).collect();
                    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                    Error::new(format!("{}: no camera \"{name}\"; it has: {known}", scene.name))
                })
            }
            CameraChoice::Default => Ok(scene.cameras.first().cloned().unwrap_or_else(|| {
                notes.push("the scene has no camera: one that frames it is used".into());
                let camera = Camera::framing(scene, aspect);
                debug_assert!(matches!(camera.projection, Projection::Perspective { .. }));
                camera
            })),
        }
    }

    /// The rules of light, under which lights that are off stay where lights move.
    pub fn light_rules(&self) -> LightRules {
        LightRules { keep_absent: self.rules.keep_absent || self.lights_move, ..self.rules.clone() }
    }

    /// The fetch that matters: none does for the reference.
    pub fn fetch_or_default(&self) -> FetchChoice {
        if self.technique == Technique::Reference { FetchChoice::Storage } else { self.fetch }
    }

    /// Depths are known only after a pre-pass.
    pub fn depth_bounds_or_default(&self) -> DepthBounds {
        match self.depth_bounds {
            _ if !self.prepass => DepthBounds::Off,
            asked => asked.unwrap_or(DepthBounds::Mask),
        }
    }

    /// Lists of tiles hold little in vain: a thread that looks at each light once may shade several pixels of a tile.
    pub fn culls_tightly(&self) -> bool {
        self.cull == CullTest::FrustumAabb && self.depth_bounds_or_default() != DepthBounds::Off
    }

    /// A thread of `tiled-deferred` may shade four pixels.
    pub fn may_share_lights(&self) -> bool {
        self.culls_tightly() && self.pixels_a_thread != Some(1)
    }

    /// Samples are known only after a pre-pass.
    pub fn cluster_bounds_or_default(&self) -> ClusterBounds {
        match self.cluster_bounds {
            _ if !self.prepass => ClusterBounds::Implicit,
            asked => asked.unwrap_or(ClusterBounds::Explicit),
        }
    }
}
