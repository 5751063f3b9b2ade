// From interpolants and material to what the lights see. CPU twin: reference/surface.rs.
#include "texture_level.glsl"
#include "surface_data.glsl"
#include "sample_offset.glsl"

layout(set = 0, binding = 2, scalar) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 1, binding = 0) uniform sampler2D base_color_map;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 2) uniform sampler2D normal_map;
layout(set = 1, binding = 3) uniform sampler2D occlusion_map;
layout(set = 1, binding = 4) uniform sampler2D emissive_map;
layout(set = 1, binding = 5) uniform sampler2D height_map;

// Of several samples a place within the triangle: attributes are never extrapolated.
layout(location = 0) centroid in vec3 in_position_vs;
layout(location = 1) centroid in vec3 in_normal_vs;
layout(location = 2) centroid in vec4 in_tangent_vs;
layout(location = 3) centroid in vec4 in_uv;
layout(location = 4) centroid in vec4 in_color;
layout(location = 5) flat in uint in_material;
layout(location = 6) flat in vec4 in_base_color;
layout(location = 7) flat in vec4 in_emissive_metallic;
layout(location = 8) flat in vec4 in_roughness_scales;
layout(location = 9) flat in vec4 in_model;

// Bits TEXTURE_*: the maps that the material of this pipeline has; the others are neither sampled nor branched over.
layout(constant_id = 10) const uint TEXTURES = 0u;
layout(constant_id = 11) const bool ALPHA_MASK = false;
// Bit t set: texture t reads UV set 1.
layout(constant_id = 12) const uint UV_SETS = 0u;
// Some map has a transform of its own (KHR_texture_transform).
layout(constant_id = 13) const bool UV_TRANSFORMS = false;
layout(constant_id = 14) const bool VERTEX_COLORS = false;
layout(constant_id = 15) const bool UNLIT = false;
// The lens turns the picture round, and with it the order of rows and columns.
layout(constant_id = 16) const bool MIRRORED_LENS = false;
layout(constant_id = 9) const bool PERSPECTIVE = true;

// What parallax mapping adds to the coordinates of the height map's set.
vec2 parallax_shift = vec2(0.0);

// The coordinates of map `index` before its transform; asked for where every lane of the quad still runs.
UvFootprint interpolated_uv(uint index) {
    vec4 dx = dFdxFine(in_uv);
    vec4 dy = dFdyFine(in_uv);
    const bool second = (UV_SETS & (1u << index)) != 0u;
    return second ? UvFootprint(in_uv.zw, dx.zw, dy.zw) : UvFootprint(in_uv.xy, dx.xy, dy.xy);
}

UvFootprint transformed_uv(UvFootprint f, vec3 row_u, vec3 row_v) {
    if (UV_TRANSFORMS) {
        precise vec2 at = vec2(dot(row_u, vec3(f.uv, 1.0)), dot(row_v, vec3(f.uv, 1.0)));
        f.uv = at;
        f.dx = vec2(dot(row_u.xy, f.dx), dot(row_v.xy, f.dx));
        f.dy = vec2(dot(row_u.xy, f.dy), dot(row_v.xy, f.dy));
    }
    return f;
}

// The coordinates of map `index`, and its transform's rows where it has one.
UvFootprint uv_of(uint index, vec3 row_u, vec3 row_v) {
    UvFootprint f = interpolated_uv(index);
    const bool second = (UV_SETS & (1u << index)) != 0u;
    if ((TEXTURES & TEXTURE_HEIGHT) != 0u && second == ((UV_SETS & TEXTURE_HEIGHT) != 0u)) {
        f.uv += parallax_shift;
    }
    return transformed_uv(f, row_u, row_v);
}

#define SAMPLE_MAP(name, index) \
    sample_level(name##_map, uv_of(index, materials.data[in_material].uv_##name##_u, materials.data[in_material].uv_##name##_v))

// The geometric normal stands in where vertex normals cancel; it faces the side that is seen as front.
vec3 interpolated_normal() {
    vec3 dx = dFdxFine(in_position_vs);
    vec3 dy = dFdyFine(in_position_vs);
    precise float length2 = dot(in_normal_vs, in_normal_vs);
    if (length2 >= MIN_NORMAL2) {
        precise vec3 n = in_normal_vs / sqrt(length2);
        return n;
    }
    // Rows run downwards, so dy x dx points to the viewer; a back face's front lies on the other side.
    vec3 geometric = MIRRORED_LENS ? cross(dx, dy) : cross(dy, dx);
    float size = length(geometric);
    geometric = size > 0.0 ? geometric / size : vec3(0.0, 0.0, 1.0);
    return gl_FrontFacing ? geometric : -geometric;
}

// Tangent and bitangent; false where nothing of the tangent is left beside the normal.
bool tangent_frame(vec3 n, out vec3 tangent, out vec3 bitangent) {
    precise vec3 t = in_tangent_vs.xyz - n * dot(n, in_tangent_vs.xyz);
    precise float length2 = dot(t, t);
    if (!(length2 > MIN_NORMAL2 * dot(in_tangent_vs.xyz, in_tangent_vs.xyz))) {
        return false;
    }
    t /= sqrt(length2);
    precise vec3 b = cross(n, t) * in_tangent_vs.w;
    tangent = t;
    bitangent = b;
    return true;
}

// Parallax mapping: the coordinates at which the ray from the eye meets the height map below the surface (T. Welsh, "Parallax Mapping with
// Offset Limiting", 2004: the way across is not divided by the way down), in steps towards the depth under the last ones.
void shift_by_height(vec3 n) {
    UvFootprint unshifted = interpolated_uv(5u);
    vec3 t;
    vec3 b;
    if (!tangent_frame(n, t, b)) {
        return;
    }
    precise vec3 v = PERSPECTIVE ? -in_position_vs / sqrt(dot(in_position_vs, in_position_vs)) : vec3(0.0, 0.0, 1.0);
    if (!(dot(v, gl_FrontFacing ? n : -n) > 0.0)) {
        return;
    }
    // v points down the picture, the bitangent up.
    precise vec2 across = vec2(-dot(v, t), dot(v, b));
    float scale = materials.data[in_material].height_scale;
    uint channel = materials.data[in_material].height_channel;
    vec3 row_u = materials.data[in_material].uv_height_u;
    vec3 row_v = materials.data[in_material].uv_height_v;
    precise float depth = 0.0;
    for (uint i = 0u; i < PARALLAX_STEPS; ++i) {
        precise vec2 shift = across * depth;
        UvFootprint f = unshifted;
        f.uv += shift;
        vec4 texel = sample_level(height_map, transformed_uv(f, row_u, row_v));
        precise float target = (1.0 - texel[channel]) * scale;
        depth += (target - depth) * PARALLAX_STEP;
    }
    precise vec2 found = across * depth;
    parallax_shift = found;
}

vec3 mapped_normal(vec3 n, vec3 texel, float scale) {
    vec3 t;
    vec3 b;
    // A scale of 0 bends nothing, to the bit.
    if (scale == 0.0 || !tangent_frame(n, t, b)) {
        return n;
    }
    precise vec3 m = (texel * 2.0 - 1.0) * vec3(scale, scale, 1.0);
    precise vec3 mapped = t * m.x + b * m.y + n * m.z;
    precise float mapped2 = dot(mapped, mapped);
    return mapped2 > MIN_NORMAL2 ? mapped / sqrt(mapped2) : n;
}

// Samples in which alpha reaches the cut-off: alpha becomes coverage, read once a sample.
uint alpha_coverage(float factor) {
    uint covered = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) {
        float alpha = factor;
        if ((TEXTURES & TEXTURE_BASE_COLOR) != 0u) {
            vec2 offset = sample_offset(i);
            UvFootprint f = uv_of(0u, materials.data[in_material].uv_base_color_u, materials.data[in_material].uv_base_color_v);
            f.uv += f.dx * offset.x + f.dy * offset.y;
            alpha *= sample_level(base_color_map, f).a;
        }
        covered |= alpha < in_roughness_scales.w ? 0u : 1u << i;
    }
    return covered;
}

Surface read_surface() {
    vec3 n = interpolated_normal();
    if ((TEXTURES & TEXTURE_HEIGHT) != 0u) {
        shift_by_height(n);
    }
    vec4 base = in_base_color;
    if (VERTEX_COLORS) {
        base *= in_color;
    }
    if ((TEXTURES & TEXTURE_BASE_COLOR) != 0u) {
        base *= SAMPLE_MAP(base_color, 0u);
    }
    Surface s;
    s.position = in_position_vs;
    s.base_color = base.rgb;
    s.alpha = base.a;
    s.metallic = in_emissive_metallic.w;
    s.roughness = in_roughness_scales.x;
    if ((TEXTURES & TEXTURE_METALLIC_ROUGHNESS) != 0u) {
        vec4 mr = SAMPLE_MAP(metallic_roughness, 1u);
        s.roughness *= mr.g;
        s.metallic *= mr.b;
    }
    s.roughness = clamp(s.roughness, MIN_ROUGHNESS, 1.0);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    if ((TEXTURES & TEXTURE_NORMAL) != 0u) {
        n = mapped_normal(n, SAMPLE_MAP(normal, 2u).xyz, in_roughness_scales.y);
    }
    // glTF 2.0, section 3.9.6 (double sided): a back face reverses its normal before lighting.
    s.normal = gl_FrontFacing ? n : -n;
    s.occlusion = 1.0;
    if ((TEXTURES & TEXTURE_OCCLUSION) != 0u) {
        s.occlusion = 1.0 + in_roughness_scales.z * (SAMPLE_MAP(occlusion, 3u).r - 1.0);
    }
    s.emissive = in_emissive_metallic.xyz;
    if ((TEXTURES & TEXTURE_EMISSIVE) != 0u) {
        s.emissive *= SAMPLE_MAP(emissive, 4u).rgb;
    }
    s.unlit = UNLIT;
    s.model = SHADING_GLTF;
    s.model_color = in_model.rgb;
    s.model_exponent = in_model.w;
    if (ALPHA_MASK) {
        if (SAMPLES > 1u) {
            uint covered = alpha_coverage(in_base_color.a * (VERTEX_COLORS ? in_color.a : 1.0));
            gl_SampleMask[0] = int(covered);
            if (covered == 0u) {
                discard;
            }
        } else if (base.a < in_roughness_scales.w) {
            discard;
        }
    }
    return s;
}
