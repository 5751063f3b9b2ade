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
/// See `SHADING_LAMBERT`; only of materials.
pub const SHADING_CAR_PAINT: u32 = 3;
/// See `SHADING_CAR_PAINT`.
pub const SHADING_RIM: u32 = 4;
/// Each material has its own: one of those above, in `MaterialData`.
pub const SHADING_MIXED: u32 = 5;

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
/// See `TEXTURE_BASE_COLOR`.
pub const TEXTURE_HEIGHT: u32 = 32;

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
    /// Point of the image plane under the centre of the pixel in column x and row y: `image_scale * (x, y) + image_offset`.
    pub image_scale: Vec2,
    /// See `image_scale`.
    pub image_offset: Vec2,
    /// From stored depth to distance, as in `TileGrid`.
    pub depth_offset: f32,
    /// See `depth_offset`.
    pub depth_scale: f32,
    /// Directional lights; they come first in the table.
    pub directional_count: u32,
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
    /// First row.
    pub uv_height_u: Vec3,
    /// Second row.
    pub uv_height_v: Vec3,
    /// Depth of a height of 0, in widths of the texture.
    pub height_scale: f32,
    /// 0 to 3.
    pub height_channel: u32,
    /// `SHADING_*`.
    pub model: u32,
    /// Second colour of the model.
    pub model_color: Vec3,
    /// Its exponent.
    pub model_exponent: f32,
}

/// Steps in which parallax mapping finds the depth that is seen.
pub const PARALLAX_STEPS: u32 = 8;
/// Share of the way to the depth under a step's coordinates that the step takes.
pub const PARALLAX_STEP: f32 = 0.5;

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

/// Value of HELD: bounds hold opaque samples.
pub const HELD_OPAQUE: u32 = 0;
/// They hold blended fragments, from the nearest one of a pixel to the opaque sample behind it.
pub const HELD_BLENDED: u32 = 1;
/// They hold both.
pub const HELD_BOTH: u32 = 2;

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
/// RGBA32F texels a culled light: centre and squared radius; distance range, radius, and by how much the product of a normal and
/// the way to it may be off (metres); tile rectangle (first and last column, first
/// and last row; empty where first passes last).
pub const CULL_TEXELS: u32 = 3;
/// Texels a light of the cones behind them: axis and metres that the box grows by; cosine (-1: no cone) and sine of the half angle.
pub const CONE_TEXELS: u32 = 2;
/// Farthest distance that bounds can say, metres: products with it stay finite.
pub const FAR_LIMIT: f32 = 1e18;
/// Relative widening of the distances between which a tile's samples lie: 2^-20.
pub const DISTANCE_SLACK: f32 = 9.536743e-7;

/// Relative widening of where slots begin and end between these, more than what finding a slot may round: 2^-18.
pub const SLOT_SLACK: f32 = 3.8146973e-6;

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
    /// No surface is farther, metres; stands for the sky behind blended surfaces.
    pub farthest: f32,
}

/// What stored depth and the depth of the shaded position may differ by. Rasterisers interpolate depth, 1/w and position by three
/// products each, of numbers up to that of the nearest vertex (at most 1 in reversed depth): each sum is off by less than 8 * 2^-24 of it.
/// `check` measures the difference on each driver.
pub const DEPTH_SLACK: f32 = 9.536_743e-7;

/// Value of GBUFFER: few bytes, the position comes from depth.
pub const GBUFFER_COMPACT: u32 = 0;
/// 32-bit floats throughout.
pub const GBUFFER_FAT: u32 = 1;
/// Largest number that a 16-bit float holds.
pub const MAX_HALF: f32 = 65504.0;

/// Corners of the triangles of math/icosphere.rs.
pub const ICOSPHERE_CORNERS: u32 = 240;
/// What light volumes lose of a perspective depth (plan/light_volumes.rs): 2^-19.
pub const VOLUME_DEPTH_SLACK: f32 = 1.907_348_6e-6;
/// What they lose of an orthographic depth: 2^-16.
pub const VOLUME_LINEAR_SLACK: f32 = 1.525_878_9e-5;

/// Where one light is added to the picture.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct LightVolume {
    /// A volume: centre in view space and radius of its inscribed sphere. A rectangle: left, top, right, bottom in clip space.
    pub place: Vec4,
    /// Index into the light table.
    pub light: u32,
}

/// A sphere that shows where a light is.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct LightMarker {
    /// View space.
    pub center: Vec3,
    /// Metres.
    pub radius: f32,
    /// Radiance.
    pub color: Vec3,
}

/// RGBA32F texels at the head of what shading is told of shadows: directional lights that have one, first light that is not directional, other
/// lights that have one. In each of both runs of the light table those with shadows come first.
pub const SHADOW_HEAD_TEXELS: u32 = 1;
/// Texels a light with a shadow, behind the head: first texel of its maps, their number, metres that a position may be off its surface
/// everywhere and at a distance of 1 m; then, of six maps that face the sides of a cube, rows from view space to the cube's own axes.
pub const SHADOW_LIGHT_TEXELS: u32 = 4;
/// Texels a map, behind all lights: rows from view space to column, row and depth in the image of all maps, times w, and to w; first column and
/// row of the map, its columns, metres that a texel spans where w is 1. Without columns nothing stands in the way of the light.
pub const SHADOW_MAP_TEXELS: u32 = 5;

/// RGBA32F texels at the head of what shading is told of bounced light: rows from view space to cells of the grid; cells along each axis and the reach
/// of patches in cells; metres of a cell.
pub const BOUNCED_HEAD_TEXELS: u32 = 5;
/// Texels a patch behind it: centre in cells and area; normal along the axes of the grid.
pub const BOUNCED_PATCH_TEXELS: u32 = 2;
/// Texels of a `PatchLight`.
pub const BOUNCED_LIGHT_TEXELS: u32 = 4;
/// First word of a list of patches that a plane parts (radiosity/transfer.rs).
pub const BOUNCED_PARTED: u32 = 0x8000_0000;
/// Planes that a place may be compared with.
pub const BOUNCED_PLANES: u32 = 4;
/// Least weight of a patch that is listed.
pub const BOUNCED_LEAST: f32 = 1e-6;
/// Points of a patch at which direct light is looked at, at most.
pub const PATCH_POINTS: u32 = 16;
/// Threads of a group that gathers four rows, at most: those that run in step, where these are fewer.
pub const GATHER_LANES: u32 = 32;
/// Value of MATRIX_PATH: words of a storage buffer.
pub const PATH_BUFFER: u32 = 0;
/// Value of MATRIX_PATH: words of a texel buffer.
pub const PATH_TEXEL: u32 = 1;
/// Value of MATRIX_PATH: texels of an image.
pub const PATH_SAMPLED: u32 = 2;
/// Value of CODEC: 16 bits an element and channel (radiosity/codec/half.rs).
pub const CODEC_HALF: u32 = 2;
/// Value of CODEC: BC1 blocks, elements apart by channel (radiosity/codec/thesis.rs).
pub const CODEC_THESIS: u32 = 3;
/// Value of CODEC: BC1 blocks that are not 0, residuals (radiosity/codec/bc1.rs).
pub const CODEC_BC1: u32 = 4;
/// Value of CODEC: BC4 blocks and chroma (radiosity/codec/bc4_chroma.rs).
pub const CODEC_BC4_CHROMA: u32 = 5;
/// Value of CODEC: 32 bits an element.
pub const CODEC_DENSE: u32 = 0;
/// Blocks with an exact zero, and residuals (radiosity/codec/zero_block.rs).
pub const CODEC_ZERO_BLOCK: u32 = 1;

/// What of a patch light does not change.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PatchData {
    /// View space, unit length.
    pub normal: Vec3,
    /// Square metres.
    pub area: f32,
    /// Linear RGB.
    pub reflectance: Vec3,
    /// Linear RGB radiance.
    pub emission: Vec3,
}

/// Light of a patch while it is gathered.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PatchLight {
    /// Irradiance from all other patches, lux.
    pub irradiance: Vec4,
    /// The same one step before.
    pub previous: Vec4,
    /// What leaves the patch: exitance times area, lumen.
    pub sent: Vec4,
    /// Exitance by emission and direct light alone, lux.
    pub first: Vec4,
}

/// What `patch_light` is told.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PatchPush {
    /// Patches.
    pub count: u32,
    /// 1: nothing is taken from the frame before.
    pub afresh: u32,
}

/// What `patch_product` is told: where parts of an operator of summed bounces begin among its words, and what 16-bit floats are multiplied by.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ProductPush {
    /// Patches.
    pub count: u32,
    /// Unit of 16-bit floats.
    pub scale: f32,
    /// Row of each position.
    pub rows_at: u32,
    /// Column of each position.
    pub columns_at: u32,
    /// Three floats a row.
    pub scales_at: u32,
    /// Three tables of 256 floats.
    pub tables_at: u32,
    /// Bits of blocks that are stored.
    pub mask_at: u32,
    /// Stored blocks before each word of bits.
    pub counts_at: u32,
    /// Blocks, two words each; or pairs of 16-bit floats.
    pub blocks_at: u32,
    /// Two bytes a block.
    pub chroma_at: u32,
    /// Where elements apart begin, by row; by channel and row in the thesis' form.
    pub offsets_at: u32,
    /// Elements apart, two words each; in the thesis' form columns, two a word.
    pub apart_at: u32,
    /// Floats of those.
    pub values_at: u32,
}

/// What `sight` is told.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SightPush {
    /// Segments.
    pub count: u32,
    /// Nodes of the hierarchy.
    pub nodes: u32,
    /// Metres that a difference of two positions may be off, at most.
    pub off: f32,
    /// Largest coordinate of the world times the square root of 3, metres.
    pub reach: f32,
}

/// What `patch_gather` is told: the step, and where parts of the matrix begin among its words.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct GatherPush {
    /// Patches.
    pub count: u32,
    /// Share of the residual that is taken.
    pub step: f32,
    /// Weight of the change against the step before last.
    pub weight: f32,
    /// A residual's unit.
    pub residual_scale: f32,
    /// Ends of blocks by code, then steps.
    pub tables_at: u32,
    /// Where rows of blocks begin.
    pub offsets_at: u32,
    /// Columns of blocks, two a word.
    pub columns_at: u32,
    /// Blocks, two words each.
    pub blocks_at: u32,
    /// Where residuals of rows begin.
    pub residual_offsets_at: u32,
    /// Residuals.
    pub residuals_at: u32,
}

/// What the vertex stage is told of the map that is drawn.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MapPush {
    /// View to the map's clip space.
    pub view_to_map: Mat4,
}

/// Groups along one dimension of a dispatch that every device takes.
pub const MOST_GROUPS: u32 = 65535;
/// Light is gathered anew in each frame.
pub const CARRIED_NOTHING: u32 = 0;
/// Gathers go on from the light of the frame before.
pub const CARRIED_LIGHT: u32 = 1;
/// What changed is gathered, and added to the light of the frame before.
pub const CARRIED_CHANGES: u32 = 2;
/// Nothing stands between the ends of a segment.
pub const SIGHT_MISSED: u32 = 0;
/// Something does.
pub const SIGHT_MET: u32 = 1;
/// 32 bits cannot tell.
pub const SIGHT_UNSURE: u32 = 2;
/// Nodes that a segment is followed through. Drivers that leave a shader's loops after 65,535 rounds of all of them count for threads that run in step: at
/// each node a round, and those of a leaf's four triangles and of the end of their loop.
pub const SIGHT_STEPS: u32 = 10922;
/// Threads of a group where groups lie in rows: of `MOST_GROUPS` along x, and as many rows along y as it takes.
pub const ROW_THREADS: u32 = 64;

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
    /// Items of the level, or as many as there is room for where a buffer says how many things there are.
    pub item_count: u32,
    /// Items of the first level for each of those things.
    pub each: u32,
    /// Items of the first level that one of this level stands for.
    pub span: u32,
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

/// Children of a node of the light hierarchy.
pub const TREE_WIDTH: u32 = 8;
/// log2 of `TREE_WIDTH`.
pub const TREE_SHIFT: u32 = 3;
/// Most levels below a root. A walk below one root visits at most 37,449 nodes: some drivers leave a shader's loops after 65,535
/// iterations.
pub const TREE_HEIGHT: u32 = 5;
/// Bit 3 j for each depth j below `TREE_HEIGHT`: its low 3 d bits are (8^d - 1) / 7, the nodes of one root above depth d.
pub const TREE_ABOVE: u32 = 0x1249;
/// Texels ahead of a tree's entries: one of `everywhere_count`, lights below roots, `height` and `root_count`.
pub const TREE_HEADER_TEXELS: u32 = 1;
/// RGBA32F texels an entry: low corner of its box and the light's index among those that are culled (0 for a node), high corner and the
/// number of lights in it.
pub const TREE_ENTRY_TEXELS: u32 = 2;
/// Bits of a light's key.
pub const TREE_KEY_BITS: u32 = 31;
/// Cells along each axis of the box of centres; a cell's Morton code has 30 bits.
pub const TREE_CELLS: u32 = 1024;
/// Key of the lights that every walk tests, ahead of all others.
pub const TREE_KEY_EVERYWHERE: u32 = 0;
/// Bit that stands above the Morton code of the other lights.
pub const TREE_KEY_CENTER: u32 = 0x4000_0000;
/// Key of lights that no tile sees, behind all others.
pub const TREE_KEY_EMPTY: u32 = 0x7fff_ffff;
/// Low corner of an empty box; its high corner is the negative.
pub const TREE_EMPTY: f32 = 3.4028234e38;
/// What a step of a walk gives where it has met no light.
pub const TREE_NO_LIGHT: u32 = 0xffff_ffff;

/// A light hierarchy: first the lights that every walk tests, then level by level from the roots down to the lights. All levels but
/// the last are filled up with empty boxes, so that depth d has `root_count` * 8^d entries.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TreeShape {
    /// Low corner of the box of centres, view space, metres.
    pub low: Vec3,
    /// Cells a metre.
    pub scale: f32,
    /// Lights of a larger radius (metres) are tested by every walk.
    pub radius_limit: f32,
    /// Culled lights.
    pub light_count: u32,
    /// Lights that every walk tests.
    pub everywhere_count: u32,
    /// Levels below the roots, at most `TREE_HEIGHT`.
    pub height: u32,
    /// Roots, as many as it takes.
    pub root_count: u32,
    /// Entry of the first light below the roots.
    pub leaf_first: u32,
}

/// One level of a light hierarchy that is made from the one below it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TreeLevel {
    /// Entry of its first node.
    pub first: u32,
    /// Nodes, those that fill it up included.
    pub count: u32,
    /// Entry of the first child.
    pub child_first: u32,
    /// Children of all nodes.
    pub child_count: u32,
}

/// Sizes of the boxes that ask a light hierarchy in a check: a point, then cubes of 1, 2, 4 .. 1,024 steps.
pub const TREE_QUERY_SIZES: u32 = 12;

/// Boxes that ask a light hierarchy in a check: their low corners lie between `low` and `TREE_CELLS` steps beyond.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TreeQuery {
    /// Metres, view space.
    pub low: Vec3,
    /// Metres.
    pub step: f32,
    /// Boxes.
    pub query_count: u32,
}

/// Entries of a list that one thread of `list_sort` sorts.
pub const LIST_SORT_RUN: u32 = 2048;
/// Entries up to which it sorts by insertion.
pub const LIST_INSERTION: u32 = 32;

/// What the passes that sort lists are told.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ListSortPush {
    /// Lists.
    pub list_count: u32,
    /// List l begins at offset `l * stride` and ends where the next one begins.
    pub stride: u32,
    /// Entries of each sorted run that is merged with its neighbour.
    pub width: u32,
    /// Lists up to this length stay where they are.
    pub sorted: u32,
}

/// Value of ASSIGN: a cluster's candidates are the list of its tile.
pub const ASSIGN_TILE: u32 = 0;
/// They come from the light hierarchy.
pub const ASSIGN_TREE: u32 = 1;

/// Value of CLUSTER_OF: every slice of every tile is a cluster.
pub const CLUSTER_OF_SLICE: u32 = 0;
/// Clusters were made of samples; an image holds that of each pixel.
pub const CLUSTER_OF_PIXEL: u32 = 1;
/// Some slices of tiles are clusters; an image holds the place of each among them.
pub const CLUSTER_OF_RANK: u32 = 2;
/// Cluster of a sample that shows the sky.
pub const NO_CLUSTER: u32 = 0xffff_ffff;
/// Words of a cluster's box: low and high distance, low and high across, low and high up, metres.
pub const BOX_WORDS: u32 = 6;
/// Clusters in a row of the image that assignment reads.
pub const CELLS_WIDE: u32 = 2048;
/// Texels of each.
pub const CELL_TEXELS: u32 = 2;
/// The same where clusters tell directions of normals: wider cells, and fewer in a row.
pub const NORMAL_CELLS_WIDE: u32 = 1024;
/// Texels of each of those: the last two are the bounds of its normals.
pub const NORMAL_CELL_TEXELS: u32 = 4;
/// Depths that a check asks for round each boundary of slices.
pub const PROBE_DEPTHS: u32 = 513;

/// How tiles are cut into slices, blocks of samples, and how many clusters there is room for.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ClusterGrid {
    /// Slices, at least one; the last is unbounded.
    pub slices: u32,
    /// Perspective: bits of the largest depth + depth_scale, where the first slice begins.
    pub slice_top: u32,
    /// Perspective: a slice is 2^slice_shift of these bits.
    pub slice_shift: u32,
    /// Orthographic: slices from depth 1 to depth 0; 0 where there is one.
    pub slice_scale: f32,
    /// Bits of a slice in a key, those of a direction included.
    pub slice_bits: u32,
    /// Bits of the direction of a normal in a key, half of them along each axis of the octahedron's square; 0 where clusters tell none.
    pub direction_bits: u32,
    /// By how many bits the code of a normal is finer than its direction.
    pub direction_shift: u32,
    /// Pixels along each side of a block.
    pub block: u32,
    /// Blocks along each side of a tile.
    pub tile_parts: u32,
    /// Blocks of all tiles.
    pub block_count: u32,
    /// Keys that a block has room for.
    pub block_keys: u32,
    /// Keys that all blocks may have together.
    pub entry_capacity: u32,
    /// Clusters that there may be.
    pub capacity: u32,
    /// Left edge of column 0, metres a column, and what rounding may take from an edge; at distance 1 for a perspective lens.
    pub pixel_x: Vec3,
    /// The same from the upper edge of row 0 downwards.
    pub pixel_y: Vec3,
}
