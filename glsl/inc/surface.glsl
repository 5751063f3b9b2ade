// From interpolants and material to what the lights see. CPU twin: reference/surface.rs.
#include "texture_level.glsl"

layout(set = 0, binding = 2, scalar) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 1, binding = 0) uniform sampler2D base_color_map;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 2) uniform sampler2D normal_map;
layout(set = 1, binding = 3) uniform sampler2D occlusion_map;
layout(set = 1, binding = 4) uniform sampler2D emissive_map;

layout(location = 0) in vec3 in_position_vs;
layout(location = 1) in vec3 in_normal_vs;
layout(location = 2) in vec4 in_tangent_vs;
layout(location = 3) in vec4 in_uv;
layout(location = 4) in vec4 in_color;
layout(location = 5) flat in uint in_material;

// Bits TEXTURE_*: the maps that the material of this pipeline has; the others are neither sampled nor branched over.
layout(constant_id = 10) const uint TEXTURES = 0u;
layout(constant_id = 11) const bool ALPHA_MASK = false;

struct Surface {
    vec3 position;
    vec3 normal;
    vec3 base_color;
    float metallic;
    float roughness;
    float occlusion;
    vec3 emissive;
    bool unlit;
};

UvFootprint uv_of(MaterialData m, uint index, vec4 dx, vec4 dy) {
    bool second = (m.uv_sets & (1u << index)) != 0u;
    return second ? UvFootprint(in_uv.zw, dx.zw, dy.zw) : UvFootprint(in_uv.xy, dx.xy, dy.xy);
}

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
    vec3 geometric = cross(dy, dx);
    float size = length(geometric);
    geometric = size > 0.0 ? geometric / size : vec3(0.0, 0.0, 1.0);
    return gl_FrontFacing ? geometric : -geometric;
}

vec3 mapped_normal(vec3 n, vec3 texel, float scale) {
    precise vec3 t = in_tangent_vs.xyz - n * dot(n, in_tangent_vs.xyz);
    precise float length2 = dot(t, t);
    if (!(length2 > MIN_NORMAL2 * dot(in_tangent_vs.xyz, in_tangent_vs.xyz))) {
        return n;
    }
    t /= sqrt(length2);
    precise vec3 b = cross(n, t) * in_tangent_vs.w;
    precise vec3 m = (texel * 2.0 - 1.0) * vec3(scale, scale, 1.0);
    precise vec3 mapped = t * m.x + b * m.y + n * m.z;
    precise float mapped2 = dot(mapped, mapped);
    return mapped2 > MIN_NORMAL2 ? mapped / sqrt(mapped2) : n;
}

Surface read_surface() {
    // Where every lane of the quad still runs.
    vec4 uv_dx = dFdxFine(in_uv);
    vec4 uv_dy = dFdyFine(in_uv);
    MaterialData m = materials.data[in_material];
    vec4 base = m.base_color * in_color;
    if ((TEXTURES & TEXTURE_BASE_COLOR) != 0u) {
        base *= sample_level(base_color_map, m.uv_base_color_u, m.uv_base_color_v, uv_of(m, 0u, uv_dx, uv_dy));
    }
    Surface s;
    s.position = in_position_vs;
    s.base_color = base.rgb;
    s.metallic = m.metallic;
    s.roughness = m.roughness;
    if ((TEXTURES & TEXTURE_METALLIC_ROUGHNESS) != 0u) {
        vec4 mr = sample_level(metallic_roughness_map, m.uv_metallic_roughness_u, m.uv_metallic_roughness_v, uv_of(m, 1u, uv_dx, uv_dy));
        s.roughness *= mr.g;
        s.metallic *= mr.b;
    }
    s.roughness = clamp(s.roughness, MIN_ROUGHNESS, 1.0);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    vec3 n = interpolated_normal();
    float side = gl_FrontFacing ? 1.0 : -1.0;
    if ((TEXTURES & TEXTURE_NORMAL) != 0u) {
        vec3 texel = sample_level(normal_map, m.uv_normal_u, m.uv_normal_v, uv_of(m, 2u, uv_dx, uv_dy)).xyz;
        n = mapped_normal(n, texel, m.normal_scale);
    }
    // glTF 2.0, section 3.9.6 (double sided): a back face reverses its normal before lighting.
    s.normal = n * side;
    s.occlusion = 1.0;
    if ((TEXTURES & TEXTURE_OCCLUSION) != 0u) {
        float r = sample_level(occlusion_map, m.uv_occlusion_u, m.uv_occlusion_v, uv_of(m, 3u, uv_dx, uv_dy)).r;
        s.occlusion = 1.0 + m.occlusion_strength * (r - 1.0);
    }
    s.emissive = m.emissive;
    if ((TEXTURES & TEXTURE_EMISSIVE) != 0u) {
        s.emissive *= sample_level(emissive_map, m.uv_emissive_u, m.uv_emissive_v, uv_of(m, 4u, uv_dx, uv_dy)).rgb;
    }
    s.unlit = m.unlit != 0u;
    if (ALPHA_MASK && base.a < m.alpha_cutoff) {
        discard;
    }
    return s;
}
