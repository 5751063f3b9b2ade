#version 460
#extension GL_GOOGLE_include_directive : require
// Keeps what an opaque surface does not hide: of the rest the depth test finds the nearest.
#include "base.glsl"

layout(constant_id = 25) const uint SAMPLES = 1u;

layout(set = 0, binding = 2) uniform sampler2D opaque_depth;
layout(set = 0, binding = 3) uniform sampler2DMS opaque_samples;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float opaque;
    float reach = DEPTH_SLACK;
    if (SAMPLES == 1u) {
        opaque = texelFetch(opaque_depth, at, 0).x;
    } else {
        opaque = 1.0;
        for (uint index = 0u; index < SAMPLES; ++index) {
            opaque = min(opaque, texelFetch(opaque_samples, at, int(index)).x);
        }
        // From the middle of the pixel to its corners.
        reach += abs(dFdxFine(gl_FragCoord.z)) + abs(dFdyFine(gl_FragCoord.z));
    }
    // What the test of the shading pass may see otherwise stays.
    if (gl_FragCoord.z + reach < opaque) {
        discard;
    }
}
