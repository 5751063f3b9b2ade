#version 460
#extension GL_GOOGLE_include_directive : require
// The lights of its cluster on every pixel of the G-buffer: a thread a pixel.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade_list.glsl"
#include "cluster_sample.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 30, rgba32f) uniform writeonly image2D radiance;

#include "shade_samples.glsl"

vec3 light_surface(uvec2 at, Surface s, float depth) {
    if (cluster_of(at, depth) == NO_CLUSTER) {
        return shade_all_lights(s);
    }
    uvec2 list = cluster_list(at, depth);
    return shade_listed_lights(s, list.x, list.y);
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= grid.data.width || at.y >= grid.data.height) {
        return;
    }
    if (SAMPLES > 1u) {
        shade_samples(at);
        return;
    }
    Surface s;
    if (!read_gbuffer(ivec2(at), s)) {
        imageStore(radiance, ivec2(at), vec4(0.0));
        return;
    }
    uvec2 list = cluster_list(at, texelFetch(gbuffer_depth, ivec2(at), 0).x);
    imageStore(radiance, ivec2(at), vec4(shade_listed_lights(s, list.x, list.y), 1.0));
}
