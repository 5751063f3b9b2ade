//! Structs and numbers that shaders and Rust both see, declared here once. `build.rs` turns this file into GLSL and proves every
//! offset against the SPIR-V; layouts are scalar, so a field lies where Rust's `repr(C)` puts it.

/// Two floats, 4-byte aligned.
pub type Vec2 = [f32; 2];
/// Three floats, 4-byte aligned.
pub type Vec3 = [f32; 3];
/// Four floats, 4-byte aligned.
pub type Vec4 = [f32; 4];
/// Four columns.
pub type Mat4 = [[f32; 4]; 4];
/// Three columns.
pub type Mat3 = [[f32; 3]; 3];

/// Light data is an array of RGBA32F texels, so that storage, uniform and texel fetches read the same bytes.
/// Texel 0: position (point, spot) or direction to the light (directional) in view space; w 1 / range^2 (0: no window).
/// Texel 1: intensity; w an integer below 2^24, exact in f32: what rounding took from the position, three times 7 bits of 1/128 of the
/// largest position's ulp (bias 64), then the light's `KIND_*` bit. An f64 position would otherwise be off by half an ulp, which a surface
/// 0.1 m away sees as 1e-5 of the light.
/// Texel 2 (only where spots exist): axis in view space; w 1 - cos(outer).
/// Texel 3: x 1 / max(0.001, cos(inner) - cos(outer)).
pub const LIGHT_TEXELS_POINT: u32 = 2;
/// Texels a light where the scene has spots.
pub const LIGHT_TEXELS_SPOT: u32 = 4;
/// Bits of each packed remainder.
pub const REMAINDER_BITS: u32 = 7;
/// Value that stands for a remainder of 0.
pub const REMAINDER_BIAS: u32 = 64;

/// Bit of LIGHT_KINDS and value of a light's kind.
pub const KIND_POINT: u32 = 1;
/// See `KIND_POINT`.
pub const KIND_SPOT: u32 = 2;
/// See `KIND_POINT`.
pub const KIND_DIRECTIONAL: u32 = 4;

/// How light texels are read: value of LIGHT_FETCH.
pub const FETCH_STORAGE: u32 = 0;
/// See `FETCH_STORAGE`.
pub const FETCH_UNIFORM: u32 = 1;
/// See `FETCH_STORAGE`.
pub const FETCH_TEXEL: u32 = 2;

/// Value of SHADING.
pub const SHADING_LAMBERT: u32 = 0;
/// See `SHADING_LAMBERT`.
pub const SHADING_PHONG: u32 = 1;
/// See `SHADING_LAMBERT`.
pub const SHADING_GLTF: u32 = 2;

/// Smallest squared distance to a light, m^2: nearer than 1e-18 m the direction fades to 0.
pub const MIN_DISTANCE2: f32 = 1e-36;
/// Largest radiance that is stored: sums past f32 are clamped to it, once.
pub const MAX_RADIANCE: f32 = 3.4028234e38;
/// Smallest denominator of the falloff (scene/lighting.rs).
pub const MIN_FALLOFF: f32 = 1e-8;
/// Smallest roughness that is shaded; below it the lobe outruns f32.
pub const MIN_ROUGHNESS: f32 = 0.045;
/// Squared length under which an interpolated normal or tangent counts as zero.
pub const MIN_NORMAL2: f32 = 1e-12;

/// Material has this texture: bits of TEXTURES.
pub const TEXTURE_BASE_COLOR: u32 = 1;
/// See `TEXTURE_BASE_COLOR`.
pub const TEXTURE_METALLIC_ROUGHNESS: u32 = 2;
/// See `TEXTURE_BASE_COLOR`.
pub const TEXTURE_NORMAL: u32 = 4;
/// See `TEXTURE_BASE_COLOR`.
pub const TEXTURE_OCCLUSION: u32 = 8;
/// See `TEXTURE_BASE_COLOR`.
pub const TEXTURE_EMISSIVE: u32 = 16;

/// One picture's constants.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    /// View to clip; world to view is folded into the instances in f64.
    pub view_to_clip: Mat4,
    /// Radiance from everywhere, linear RGB.
    pub ambient: Vec3,
    /// Lights to loop over.
    pub light_count: u32,
    /// Constant, linear, quadratic of the distance law.
    pub attenuation: Vec3,
    /// 1 for a perspective lens, 0 for an orthographic one.
    pub perspective: f32,
    /// Ratio of squared distance to squared range from which a light is stepped over: 1 and a proven margin.
    pub light_seek_limit: f32,
    /// Metres a step of the packed remainders of light positions; a power of two.
    pub light_remainder_step: f32,
}

/// One instance of a mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct InstanceData {
    /// Object to view, columns; made in f64.
    pub object_to_view_x: Vec3,
    /// Second column.
    pub object_to_view_y: Vec3,
    /// Third column.
    pub object_to_view_z: Vec3,
    /// Translation.
    pub object_to_view_w: Vec3,
    /// Cofactors of the linear part times the determinant's sign, scaled to largest element 1: turns normals.
    pub normal_x: Vec3,
    /// Second column.
    pub normal_y: Vec3,
    /// Third column.
    pub normal_z: Vec3,
    /// Index of the material.
    pub material: u32,
    /// 1, or -1 where the instance mirrors: sign of the bitangent.
    pub handedness: f32,
}

/// One material's factors and texture maps.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MaterialData {
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// Radiance factor.
    pub emissive: Vec3,
    /// Factor.
    pub metallic: f32,
    /// Factor.
    pub roughness: f32,
    /// Factor of the normal map's x and y.
    pub normal_scale: f32,
    /// Strength.
    pub occlusion_strength: f32,
    /// Alpha below this does not exist; negative: no mask.
    pub alpha_cutoff: f32,
    /// UV transforms, two rows a texture, in the order of the `TEXTURE_*` bits.
    pub uv_base_color_u: Vec3,
    /// Second row.
    pub uv_base_color_v: Vec3,
    /// First row.
    pub uv_metallic_roughness_u: Vec3,
    /// Second row.
    pub uv_metallic_roughness_v: Vec3,
    /// First row.
    pub uv_normal_u: Vec3,
    /// Second row.
    pub uv_normal_v: Vec3,
    /// First row.
    pub uv_occlusion_u: Vec3,
    /// Second row.
    pub uv_occlusion_v: Vec3,
    /// First row.
    pub uv_emissive_u: Vec3,
    /// Second row.
    pub uv_emissive_v: Vec3,
}
