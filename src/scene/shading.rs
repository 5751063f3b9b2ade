//! The local shading models of the renderer (DESIGN.md, section 5): three that a picture can ask for, and two more that only materials do.

/// How a surface answers to light. The formulas are in `reference::shade` and, in the same order, in GLSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// Diffuse only: base colour over pi.
    Lambert,
    /// Blinn's half vector, without the division by pi.
    Phong,
    /// Metallic-roughness as glTF 2.0, appendix B, defines it.
    #[default]
    Gltf,
}

impl Shading {
    /// As the command line writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lambert => "lambert",
            Self::Phong => "phong",
            Self::Gltf => "gltf",
        }
    }
}

/// How one material answers to light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Model {
    /// As [`Shading::Lambert`].
    Lambert,
    /// As [`Shading::Phong`].
    Phong,
    /// As [`Shading::Gltf`].
    Gltf,
    /// Two-coloured paint: the base colour head on, a second one at grazing angles, mixed by (n . v)^exponent; for the rest as
    /// [`Model::Gltf`].
    CarPaint,
    /// As [`Model::Gltf`], and light of a second colour towards the silhouette: each light adds its irradiance times colour times
    /// (1 - n . v)^exponent.
    Rim,
}

impl Model {
    /// Every model.
    pub const ALL: [Self; 5] = [Self::Lambert, Self::Phong, Self::Gltf, Self::CarPaint, Self::Rim];

    /// As `extras.lampyris.model` writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lambert => "lambert",
            Self::Phong => "phong",
            Self::Gltf => "gltf",
            Self::CarPaint => "car-paint",
            Self::Rim => "rim",
        }
    }
}

impl From<Shading> for Model {
    fn from(shading: Shading) -> Self {
        match shading {
            Shading::Lambert => Self::Lambert,
            Shading::Phong => Self::Phong,
            Shading::Gltf => Self::Gltf,
        }
    }
}

/// A model with its numbers, which only [`Model::CarPaint`] and [`Model::Rim`] read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnModel {
    /// Which.
    pub model: Model,
    /// Linear RGB: the second colour of paint, the colour of a rim.
    pub color: [f32; 3],
    /// Positive: how soon the second colour comes, how narrow the rim is.
    pub exponent: f32,
}

impl OwnModel {
    /// What an absent colour and exponent mean.
    pub const WHITE: [f32; 3] = [1.0; 3];
    /// See [`OwnModel::WHITE`].
    pub const EXPONENT: f32 = 3.0;

    /// Without numbers of its own.
    pub fn of(model: Model) -> Self {
        Self { model, color: Self::WHITE, exponent: Self::EXPONENT }
    }
}
