#version 460
#extension GL_GOOGLE_include_directive : require
// The last of the offsets, which is the total, alone in a buffer.
#include "base.glsl"

layout(local_size_x = 1) in;

layout(constant_id = 0) const uint AT = 0u;
// A buffer says which is the last, AT at most.
layout(constant_id = 1) const bool COUNTED = false;

layout(set = 0, binding = 0, scalar) readonly buffer Offsets { uint data[]; } offsets;
layout(set = 0, binding = 1, scalar) readonly buffer Count { uint data[]; } count;
layout(set = 0, binding = 2, scalar) writeonly buffer Total { uint data[]; } total;

void main() {
    total.data[0] = offsets.data[COUNTED ? min(count.data[0], AT) : AT];
}
