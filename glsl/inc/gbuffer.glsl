// How the compact G-buffer stores a surface, each step beside its inverse.
#include "octahedral.glsl"

layout(constant_id = 31) const uint NORMAL_BITS = 16u;

// 10 bits a channel hold the square root: steps grow with the colour, as those of sRGB do, and are a quarter of sRGB's in 8 bits.
// Alpha says that a surface is there.
vec4 store_base_color(vec3 color) {
    return vec4(sqrt(clamp(color, 0.0, 1.0)), 1.0);
}

vec3 load_base_color(vec4 texel) {
    precise vec3 color = texel.rgb * texel.rgb;
    return color;
}

// Two channels hold 16 bits of roughness: the height of a smooth surface's lobe goes with its fourth power.
vec4 store_material(float roughness, float metallic, float occlusion) {
    uint code = uint(roughness * 65535.0 + 0.5);
    return vec4(vec2(code >> 8u, code & 255u) / 255.0, metallic, occlusion);
}

// Roughness, metalness, occlusion.
vec3 load_material(vec4 texel) {
    uvec2 bytes = uvec2(texel.xy * 255.0 + 0.5);
    precise float roughness = float(bytes.x * 256u + bytes.y) * (1.0 / 65535.0);
    return vec3(max(roughness, MIN_ROUGHNESS), texel.zw);
}

// 16-bit floats end here; clamped once.
vec4 store_emission(vec3 emissive) {
    return vec4(min(emissive, MAX_HALF), 0.0);
}
