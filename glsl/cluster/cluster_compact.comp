#version 460
#extension GL_GOOGLE_include_directive : require
// Moves the keys of all blocks side by side, in the order of blocks: a thread a block.
#include "base.glsl"

layout(local_size_x = 64) in;

// Each key is followed by where it stood: for the sort.
layout(constant_id = 20) const bool KEEP_ORIGIN = false;

layout(set = 0, binding = 0, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 1, scalar) readonly buffer BlockKeys { uint data[]; } block_keys;
layout(set = 0, binding = 2, scalar) readonly buffer BlockOffsets { uint data[]; } block_offsets;
layout(set = 0, binding = 3, scalar) writeonly buffer EntryKeys { uint data[]; } entry_keys;
layout(set = 0, binding = 4, scalar) writeonly buffer EntryOrigins { uint data[]; } entry_origins;

#include "cluster_thread.glsl"

void main() {
    uint block = thread_index();
    if (block >= clusters.data.block_count) {
        return;
    }
    uint from = block * clusters.data.block_keys;
    uint end = block_offsets.data[block + 1u];
    for (uint to = block_offsets.data[block]; to < end; ++to) {
        entry_keys.data[to] = block_keys.data[from];
        if (KEEP_ORIGIN) {
            entry_origins.data[to] = to;
        }
        ++from;
    }
}
