#version 460
#extension GL_GOOGLE_include_directive : require
// The compact G-buffer of a scene that emits.
#include "base.glsl"
#include "surface.glsl"
#include "gbuffer.glsl"

layout(location = 0) out vec4 out_base_color;
layout(location = 1) out uvec4 out_normal;
layout(location = 2) out vec4 out_material;
layout(location = 3) out vec4 out_emission;

void main() {
    Surface s = read_surface();
    out_base_color = store_base_color(s.base_color);
    // The number is dropped where the image has two channels.
    out_normal = uvec4(encode_octahedral(s.normal, NORMAL_BITS), in_material, 0u);
    out_material = store_material(s.roughness, s.metallic, s.occlusion);
    out_emission = store_emission(s.emissive);
}
