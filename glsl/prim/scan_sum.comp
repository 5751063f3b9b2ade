#version 460
#extension GL_GOOGLE_include_directive : require
// One level of a scan upwards: a thread adds up one run of items.
#include "base.glsl"

layout(local_size_x = 32) in;

#include "scan.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Items { uint data[]; } items;
layout(set = 0, binding = 1, scalar) writeonly buffer Sums { uint data[]; } sums;

void main() {
    uint run = gl_GlobalInvocationID.x;
    uint first = run * SCAN_RUN;
    uint count = count_items();
    if (first >= count) {
        return;
    }
    uint end = first + min(SCAN_RUN, count - first);
    uint sum = 0u;
    for (uint i = first; i < end; ++i) {
        sum += items.data[i];
    }
    sums.data[run] = sum;
}
