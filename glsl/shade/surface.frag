#version 460
#extension GL_GOOGLE_include_directive : require
// What the lights see, stored in f32: for debug views and for the oracle that is fed the device's own surfaces.
#include "base.glsl"
#include "surface.glsl"

layout(location = 0) out vec4 out_position_roughness;
layout(location = 1) out vec4 out_normal_occlusion;
layout(location = 2) out vec4 out_base_metallic;
layout(location = 3) out vec4 out_emissive_flags;

void main() {
    Surface s = read_surface();
    out_position_roughness = vec4(s.position, s.roughness);
    out_normal_occlusion = vec4(s.normal, s.occlusion);
    out_base_metallic = vec4(s.base_color, s.metallic);
    out_emissive_flags = vec4(s.emissive, (s.unlit ? 2.0 : 1.0) + 4.0 * float(in_material));
}
