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

/// Value of CULL: integer rectangles of tiles, made beforehand.
pub const CULL_RECTANGLE: u32 = 0;
/// Four planes of the tile through the eye, and the depth range.
pub const CULL_PLANES: u32 = 1;
/// The planes, and the view-space box of what depth bounds and light leave of the tile.
pub const CULL_PLANES_BOX: u32 = 2;

/// Value of DEPTH_BOUNDS: the whole of the view.
pub const BOUNDS_OFF: u32 = 0;
/// Nearest and farthest sample of the tile.
pub const BOUNDS_MIN_MAX: u32 = 1;
/// The same, and a mask of the slots between them that hold samples (Harada, "A 2.5D culling for Forward+", SIGGRAPH Asia 2012).
pub const BOUNDS_MASK: u32 = 2;

/// Value of WORD_FETCH: lists are read from storage buffers.
pub const WORDS_STORAGE: u32 = 0;
/// Lists are read from uniform texel buffers.
pub const WORDS_TEXEL: u32 = 1;

/// Tiles along each side of a bin.
pub const BIN_TILES: u32 = 8;
/// Lights that one thread of `tile_bin_count` looks at.
pub const LIGHT_CHUNK: u32 = 512;
/// Entries of a bin's list that one thread of `tile_count` looks at.
pub const LIST_CHUNK: u32 = 8192;
/// RGBA32F texels a culled light: centre and squared radius; distance range and radius; tile rectangle (first and last column, first
/// and last row; empty where first passes last).
pub const CULL_TEXELS: u32 = 3;
/// Farthest distance that bounds can say, metres: products with it stay finite.
pub const FAR_LIMIT: f32 = 1e18;
/// Relative widening of the distances between which a tile's samples lie: 2^-20.
pub const DISTANCE_SLACK: f32 = 9.536743e-7;

/// The grid of screen tiles and how stored depth becomes distance.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TileGrid {
    /// Pixels of the picture.
    pub width: u32,
    /// Pixels of the picture.
    pub height: u32,
    /// Tiles in a row.
    pub columns: u32,
    /// Tiles in a column.
    pub rows: u32,
    /// Bins in a row.
    pub bin_columns: u32,
    /// Bins in a column.
    pub bin_rows: u32,
    /// Lights ahead of the culled ones, which every sample adds: the directional ones.
    pub first_light: u32,
    /// Culled lights.
    pub light_count: u32,
    /// Runs of `LIGHT_CHUNK` lights.
    pub light_chunks: u32,
    /// Runs of `LIST_CHUNK` entries that the longest bin has; tile t's list starts at offset `t * list_chunks`.
    pub list_chunks: u32,
    /// 1: distance = depth_offset / (depth + depth_scale); 0: distance = depth_offset - depth * depth_scale.
    pub perspective: u32,
    /// See `perspective`.
    pub depth_offset: f32,
    /// See `perspective`.
    pub depth_scale: f32,
    /// What a stored depth may differ by from that of the position which is shaded.
    pub depth_slack: f32,
    /// Nearest distance of the view, metres.
    pub near: f32,
    /// Farthest distance of the view or `FAR_LIMIT`, metres.
    pub far: f32,
}

/// Items that one thread of a scan walks through.
pub const SCAN_RUN: u32 = 64;
/// Keys that one thread of a radix sort walks through.
pub const RADIX_BLOCK: u32 = 256;
/// Bits of a digit.
pub const RADIX_BITS: u32 = 4;
/// Values of a digit.
pub const RADIX_DIGITS: u32 = 16;

/// Value of MOVED: keys and values side by side.
pub const MOVED_PAIRS: u32 = 0;
/// Keys alone.
pub const MOVED_KEYS: u32 = 1;
/// Values alone.
pub const MOVED_VALUES: u32 = 2;

/// Value of KIND: every key alike.
pub const KEYS_EQUAL: u32 = 0;
/// Keys that grow with their index.
pub const KEYS_ASCENDING: u32 = 1;
/// Keys that fall with their index.
pub const KEYS_DESCENDING: u32 = 2;
/// A hash of the index; all distinct.
pub const KEYS_HASHED: u32 = 3;
/// The largest key and 0 by turns.
pub const KEYS_EXTREME: u32 = 4;
/// Step from key to key where they grow or fall: a prime, so that all digits vary; 2^20 steps stay below 2^32.
pub const KEYS_STEP: u32 = 4093;
/// The key where every one is alike.
pub const KEYS_ALIKE: u32 = 0xA5A5_A5A5;

/// What the passes of a scan are told.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ScanPush {
    /// Items of the level.
    pub item_count: u32,
}

/// What the passes of a radix sort are told.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RadixPush {
    /// Keys that there is room for.
    pub capacity: u32,
    /// Blocks of `RADIX_BLOCK` keys in the capacity, at least one.
    pub block_count: u32,
    /// Lowest bit of the digit.
    pub shift: u32,
    /// Bits of the digit that matter.
    pub mask: u32,
}
