#version 460
#extension GL_GOOGLE_include_directive : require
// The lights of its cluster on every visible fragment.
#include "base.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "shade_list.glsl"
#include "list_parts.glsl"
#include "cluster_sample.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    Surface s = read_surface();
    uvec2 list = cluster_list(uvec2(gl_FragCoord.xy), gl_FragCoord.z);
    out_radiance = shade_list_part(s, list.x, list.y);
}
