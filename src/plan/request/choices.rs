//! What single options choose between.

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

/// Which lights a tile takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CullTest {
    /// Those whose screen rectangle touches it; rectangles from tangents.
    Bounds,
    /// The same with rectangles from the textbook's divisions, which lose lights: kept to show it.
    BoundsTextbook,
    /// Those that reach between its four planes.
    Frustum,
    /// Those that reach between its planes and touch its view-space box.
    FrustumAabb,
}

impl CullTest {
    /// Every test.
    pub const ALL: [Self; 4] = [Self::Bounds, Self::BoundsTextbook, Self::Frustum, Self::FrustumAabb];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bounds => "bounds",
            Self::BoundsTextbook => "bounds-textbook",
            Self::Frustum => "frustum",
            Self::FrustumAabb => "frustum-aabb",
        }
    }
}

/// What culling knows of the depths in a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthBounds {
    /// Nothing.
    Off,
    /// Nearest and farthest sample.
    MinMax,
    /// These and which of the slots between them hold samples.
    Mask,
}

impl DepthBounds {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Off, Self::MinMax, Self::Mask];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::MinMax => "minmax",
            Self::Mask => "2.5d",
        }
    }
}

/// How `deferred` adds lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeferredLights {
    /// Each light blends into the pixels that its volume covers.
    Volumes,
    /// One pass in which every pixel loops over all lights.
    Fullscreen,
    /// The same with a range test that skips.
    FullscreenBranch,
}

impl DeferredLights {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::Volumes, Self::Fullscreen, Self::FullscreenBranch];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Volumes => "volumes",
            Self::Fullscreen => "fullscreen",
            Self::FullscreenBranch => "fullscreen-branch",
        }
    }
}

/// What the G-buffer stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GbufferLayout {
    /// Position, normal, albedo, specular and ambient in 32-bit floats.
    Fat,
    /// Position from depth, the rest in few bits.
    Compact,
}

impl GbufferLayout {
    /// Every layout.
    pub const ALL: [Self; 2] = [Self::Fat, Self::Compact];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fat => "fat",
            Self::Compact => "compact",
        }
    }
}

/// Numbers that light volumes add in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accumulation {
    /// 32-bit floats: what every other technique adds in.
    F32,
    /// 16-bit floats: half the bytes of the picture, and a sum rounded to 11 bits after each light.
    F16,
}

impl Accumulation {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::F32, Self::F16];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
        }
    }
}

/// Where clusters find their candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssignChoice {
    /// The plan chooses.
    Auto,
    /// In the lists of their tiles.
    Tiles,
    /// In the light hierarchy.
    Tree,
}

impl AssignChoice {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Tiles => "tiles",
            Self::Tree => "tree",
        }
    }
}

/// What bounds a cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClusterBounds {
    /// Its tile and slice.
    Implicit,
    /// The box of its samples.
    Explicit,
}

impl ClusterBounds {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Implicit => "implicit",
            Self::Explicit => "explicit",
        }
    }
}

/// What the light lists of blended surfaces know of depths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransparentBounds {
    /// Lists of their own, between the nearest blended fragment and the opaque sample behind it.
    Own,
    /// One list for both kinds of surfaces, bounded by the samples of both.
    Merged,
    /// Lists of their own that know nothing of depths.
    None,
}

impl TransparentBounds {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Own, Self::Merged, Self::None];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Merged => "merged",
            Self::None => "none",
        }
    }
}

/// What is put in order from back to front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransparentSort {
    /// Objects, by the middle of their box.
    Object,
    /// The triangles of all of them, by their middle.
    Triangle,
}

impl TransparentSort {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::Object, Self::Triangle];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Triangle => "triangle",
        }
    }
}

/// When shadow maps are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowUpdate {
    /// Before the first frame: nothing moves.
    Once,
    /// In every frame, as if something had moved.
    Frame,
}

impl ShadowUpdate {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Once, Self::Frame];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Once => "once",
            Self::Frame => "frame",
        }
    }
}

/// Diffuse light that did not come straight from a punctual light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gi {
    /// None.
    Off,
    /// Paths on the CPU.
    Path {
        /// Of each pixel.
        paths: u32,
        /// Of their directions.
        seed: u64,
    },
    /// Between patches that were baked ([`super::Request::bake`]).
    Radiosity(Gathering),
}

/// How light is gathered between patches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gathering {
    /// `None`: as many as the tolerance needs.
    pub gathers: Option<u32>,
    /// Share of all light that may be left out; of bounced light, where surfaces emit.
    pub tolerance: f64,
    /// How gathers are put together.
    pub iteration: Iteration,
    /// What the matrix is read from.
    pub path: MatrixPath,
    /// A thread adds a row by itself, as in the thesis, instead of a group four of them; only where elements have 32 bits.
    pub thread_rows: bool,
    /// Each frame goes on from the light of the frame before, with as many gathers as are asked for, or one: light settles over some frames.
    pub feedback: bool,
}

impl Gathering {
    /// That share where nothing is said.
    pub const TOLERANCE: f64 = 0.005;
}

impl Default for Gathering {
    fn default() -> Self {
        Self {
            gathers: None,
            tolerance: Self::TOLERANCE,
            iteration: Iteration::Chebyshev,
            path: MatrixPath::Auto,
            thread_rows: false,
            feedback: false,
        }
    }
}

/// How gathers of bounces are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Iteration {
    /// By Chebyshev's polynomials, from the eigenvalues that the bake has found.
    Chebyshev,
    /// Bounce by bounce: Neumann's series.
    Neumann,
}

impl Iteration {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chebyshev => "chebyshev",
            Self::Neumann => "neumann",
        }
    }
}

/// What a matrix is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixPath {
    /// What is quickest on the device.
    Auto,
    /// Words of a storage buffer.
    Buffer,
    /// Words of a texel buffer.
    Texel,
    /// Texels of an image, which a sampler decompresses.
    Sampled,
}

impl MatrixPath {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Buffer => "buffer",
            Self::Texel => "texel",
            Self::Sampled => "sampled",
        }
    }
}

impl Gi {
    /// Paths of a pixel where nothing is said.
    pub const PATHS: u32 = 64;
    /// Seed where nothing is said.
    pub const SEED: u64 = 1;

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Path { .. } => "path",
            Self::Radiosity(_) => "radiosity",
        }
    }
}
