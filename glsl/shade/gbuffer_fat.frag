#version 460
#extension GL_GOOGLE_include_directive : require
// The G-buffer in 32-bit floats: position, normal, albedo, specular and ambient.
#include "base.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "brdf.glsl"

layout(location = 0) out vec4 out_position_roughness;
layout(location = 1) out vec4 out_normal_occlusion;
layout(location = 2) out vec4 out_base_metallic;
layout(location = 3) out vec4 out_specular_flag;
layout(location = 4) out vec4 out_ambient_emission;

void main() {
    Surface s = read_surface();
    out_position_roughness = vec4(s.position, s.roughness);
    out_normal_occlusion = vec4(s.normal, s.occlusion);
    out_base_metallic = vec4(s.base_color, s.metallic);
    out_specular_flag = vec4(specular_color(s), 1.0 + float(in_material));
    out_ambient_emission = vec4(unlit_radiance(s), 0.0);
}
