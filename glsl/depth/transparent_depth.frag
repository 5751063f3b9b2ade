#version 460
#extension GL_GOOGLE_include_directive : require
// Keeps what an opaque surface does not hide: of the rest the depth test finds the nearest.
#include "base.glsl"

layout(set = 0, binding = 2) uniform sampler2D opaque_depth;

void main() {
    float opaque = texelFetch(opaque_depth, ivec2(gl_FragCoord.xy), 0).x;
    // What the test of the shading pass may see otherwise stays.
    if (gl_FragCoord.z + DEPTH_SLACK < opaque) {
        discard;
    }
}
