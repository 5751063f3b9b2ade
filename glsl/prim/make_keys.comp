#version 460
#extension GL_GOOGLE_include_directive : require
// Keys of a kind, each with its index as value: input for checks of sort and scan. CPU twin: `key` of reference/radix_sort.rs.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint KIND = KEYS_HASHED;
layout(constant_id = 1) const uint MASK = 0xffffffffu;

layout(set = 0, binding = 0, scalar) writeonly buffer Keys { uint data[]; } keys;
layout(set = 0, binding = 1, scalar) writeonly buffer Values { uint data[]; } values;

// Finalizer of MurmurHash3 (A. Appleby, public domain): one to one.
uint hash(uint x) {
    x = (x ^ (x >> 16)) * 0x85ebca6bu;
    x = (x ^ (x >> 13)) * 0xc2b2ae35u;
    return x ^ (x >> 16);
}

uint key(uint index) {
    if (KIND == KEYS_EQUAL) {
        return KEYS_ALIKE;
    }
    if (KIND == KEYS_ASCENDING) {
        return index * KEYS_STEP;
    }
    if (KIND == KEYS_DESCENDING) {
        return 0xffffffffu - index * KEYS_STEP;
    }
    if (KIND == KEYS_EXTREME) {
        return (index & 1u) == 0u ? 0xffffffffu : 0u;
    }
    return hash(index);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < keys.data.length()) {
        keys.data[index] = key(index) & MASK;
        values.data[index] = index;
    }
}
