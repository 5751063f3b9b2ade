#version 460
#extension GL_GOOGLE_include_directive : require
// All lights on every pixel of a G-buffer of several samples: a thread a pixel.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 30, rgba32f) uniform writeonly image2D radiance;

#include "shade_samples.glsl"

vec3 light_surface(uvec2 at, Surface s, float depth) {
    return shade_all_lights(s);
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    uvec2 size = uvec2(textureSize(sample_edges, 0));
    if (at.x < size.x && at.y < size.y) {
        shade_samples(at);
    }
}
