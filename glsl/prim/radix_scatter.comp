#version 460
#extension GL_GOOGLE_include_directive : require
// Moves a block's keys, its values or both to their places among all with the same digit, in order: a thread a block.
#include "base.glsl"
#include "radix.glsl"

layout(local_size_x = 32) in;

layout(constant_id = 1) const uint MOVED = MOVED_PAIRS;

// Keys and values side by side are bound as both.
layout(set = 0, binding = 0, scalar) readonly buffer Keys { uint data[]; } keys;
layout(set = 0, binding = 1, scalar) readonly buffer Values { uint data[]; } values;
layout(set = 0, binding = 2, scalar) readonly buffer Offsets { uint data[]; } digit_offsets;
layout(set = 0, binding = 3, scalar) writeonly buffer Moved { uint data[]; } moved;

void main() {
    uint block = gl_GlobalInvocationID.x;
    if (block >= push.data.block_count) {
        return;
    }
    // Every key was counted once: the scan's total is their number.
    uint count = digit_offsets.data[radix_place(RADIX_DIGITS, 0u)];
    uint next[RADIX_DIGITS];
    for (uint digit = 0u; digit < RADIX_DIGITS; ++digit) {
        next[digit] = digit_offsets.data[radix_place(digit, block)];
    }
    uvec2 range = radix_block(block, count);
    for (uint i = range.x; i < range.y; ++i) {
        uint key = keys.data[SOURCE_PAIRS ? 2u * i : i];
        uint digit = radix_digit(key);
        uint place = next[digit];
        next[digit] = place + 1u;
        if (MOVED == MOVED_KEYS) {
            moved.data[place] = key;
            continue;
        }
        uint value = values.data[SOURCE_PAIRS ? 2u * i + 1u : i];
        if (MOVED == MOVED_VALUES) {
            moved.data[place] = value;
        } else {
            moved.data[2u * place] = key;
            moved.data[2u * place + 1u] = value;
        }
    }
}
