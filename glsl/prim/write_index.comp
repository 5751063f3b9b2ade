#version 460
#extension GL_GOOGLE_include_directive : require
// Each word becomes its own index, as a float: input for the layout probe.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) writeonly buffer Words { float data[]; } words;

void main() {
    if (gl_GlobalInvocationID.x < words.data.length()) {
        words.data[gl_GlobalInvocationID.x] = float(gl_GlobalInvocationID.x);
    }
}
