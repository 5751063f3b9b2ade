#version 460
#extension GL_GOOGLE_include_directive : require
// One sample of every pixel, from where the samples stand side by side.
#include "base.glsl"

layout(constant_id = 25) const uint SAMPLES = 4u;
layout(constant_id = 26) const uint SAMPLE = 0u;

layout(set = 0, binding = 0) uniform sampler2D radiance_texels;

layout(location = 0) out vec4 out_radiance;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    out_radiance = texelFetch(radiance_texels, ivec2(at.x * SAMPLES + SAMPLE, at.y), 0);
}
