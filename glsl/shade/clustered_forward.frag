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
    float depth = gl_FragCoord.z;
    if (SAMPLES > 1u) {
        // Of the position that is shaded, which need not be the middle of the pixel.
        depth = depth_of_distance(-s.position.z);
        if (!gl_HelperInvocation && cluster_of(uvec2(gl_FragCoord.xy), depth) == NO_CLUSTER) {
            out_radiance = shade_unlisted(s);
            return;
        }
    }
    uvec2 list = cluster_list(uvec2(gl_FragCoord.xy), depth);
    out_radiance = shade_list_part(s, list.x, list.y);
}
