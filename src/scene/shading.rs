//! The three local shading models of the renderer (DESIGN.md, section 5).

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
