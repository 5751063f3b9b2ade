#version 460
#extension GL_GOOGLE_include_directive : require
// One level of a scan downwards: a thread walks through one run of items and writes what precedes each. The last run
// writes the total too.
#include "base.glsl"

layout(local_size_x = 32) in;

#include "scan.glsl"

// False at the top, where one run holds everything.
layout(constant_id = 0) const bool HAS_PARENTS = true;

layout(set = 0, binding = 0, scalar) readonly buffer Items { uint data[]; } items;
layout(set = 0, binding = 1, scalar) readonly buffer Parents { uint data[]; } parent_offsets;
layout(set = 0, binding = 2, scalar) writeonly buffer Offsets { uint data[]; } offsets;

void main() {
    uint run = gl_GlobalInvocationID.x;
    uint first = run * SCAN_RUN;
    uint count = count_items();
    // The first run writes the total even of no items.
    if (run > 0u && first >= count) {
        return;
    }
    uint end = first + min(SCAN_RUN, count - first);
    uint sum = 0u;
    if (HAS_PARENTS) {
        sum = parent_offsets.data[run];
    }
    for (uint i = first; i < end; ++i) {
        offsets.data[i] = sum;
        sum += items.data[i];
    }
    if (end == count) {
        offsets.data[end] = sum;
    }
}
