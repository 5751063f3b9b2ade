#version 460
#extension GL_GOOGLE_include_directive : require
// How many keys of a block have each digit: a thread a block.
#include "base.glsl"
#include "radix.glsl"

layout(local_size_x = 32) in;

layout(constant_id = 1) const bool COUNT_IN_BUFFER = false;

layout(set = 0, binding = 0, scalar) readonly buffer Keys { uint data[]; } keys;
layout(set = 0, binding = 1, scalar) readonly buffer KeyCount { uint data[]; } key_count;
layout(set = 0, binding = 2, scalar) writeonly buffer DigitCounts { uint data[]; } digit_counts;

void main() {
    uint block = gl_GlobalInvocationID.x;
    if (block >= push.data.block_count) {
        return;
    }
    uint count = push.data.capacity;
    if (COUNT_IN_BUFFER) {
        count = min(count, key_count.data[0]);
    }
    uint counts[RADIX_DIGITS];
    for (uint digit = 0u; digit < RADIX_DIGITS; ++digit) {
        counts[digit] = 0u;
    }
    uvec2 range = radix_block(block, count);
    for (uint i = range.x; i < range.y; ++i) {
        ++counts[radix_digit(keys.data[SOURCE_PAIRS ? 2u * i : i])];
    }
    for (uint digit = 0u; digit < RADIX_DIGITS; ++digit) {
        digit_counts.data[radix_place(digit, block)] = counts[digit];
    }
}
