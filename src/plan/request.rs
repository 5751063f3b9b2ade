//! What the user asked for, free of how it was typed.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::scene::lighting::LightRules;
use crate::scene::shading::Shading;
use crate::scene::{Camera, Projection, Scene};

/// Ways to light a picture. Each draws what `Forward` defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Technique {
    /// The plan chooses.
    Auto,
    /// Every fragment loops over all lights.
    Forward,
    /// Rays in f64 on the CPU.
    Reference,
}

impl Technique {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Forward => "forward",
            Self::Reference => "reference",
        }
    }
}

/// How light data is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FetchChoice {
    /// The plan chooses.
    Auto,
    /// Storage buffer.
    Storage,
    /// Uniform buffer; refused where the lights do not fit.
    Uniform,
    /// Uniform texel buffer; refused where the lights do not fit.
    Texel,
}

/// Pictures of intermediate values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DebugView {
    /// Linear base colour.
    Albedo,
    /// View-space shading normal, -1..1 mapped to 0..1.
    Normals,
    /// Distance along the view axis in false colour.
    Depth,
    /// The depth buffer's own value.
    DepthRaw,
}

impl DebugView {
    /// Every view with its typed name.
    pub const ALL: [(&'static str, Self); 4] =
        [("albedo", Self::Albedo), ("normals", Self::Normals), ("depth", Self::Depth), ("depth-raw", Self::DepthRaw)];
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

    /// The fetch that matters: none does for the reference.
    pub fn fetch_or_default(&self) -> FetchChoice {
        if self.technique == Technique::Reference { FetchChoice::Storage } else { self.fetch }
    }

    /// The technique that `auto` stands for, and why.
    pub fn technique_or_default(&self) -> (Technique, String) {
        match self.technique {
            Technique::Auto => (Technique::Forward, "auto: forward is the one device technique so far".into()),
            asked => (asked, "asked for".into()),
        }
    }
}
