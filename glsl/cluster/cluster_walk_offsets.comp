#version 460
#extension GL_GOOGLE_include_directive : require
// Where the list of each cluster begins, from where the part of each of its walks does: a thread a cluster.
#include "base.glsl"

layout(local_size_x = 64) in;

// Walks a cluster.
layout(constant_id = 20) const uint WALKS = 1u;

layout(set = 0, binding = 0) uniform usamplerBuffer cluster_total;
layout(set = 0, binding = 1, scalar) readonly buffer WalkOffsets { uint data[]; } walk_offsets;
layout(set = 0, binding = 2, scalar) writeonly buffer Offsets { uint data[]; } cluster_offsets;

#include "cluster_thread.glsl"

void main() {
    uint id = thread_index();
    uint total = texelFetch(cluster_total, 0).x;
    if (id < total) {
        cluster_offsets.data[id] = walk_offsets.data[id * WALKS];
    }
    // The last thread writes the total too, even of no cluster.
    if (id + 1u == max(total, 1u)) {
        cluster_offsets.data[total] = walk_offsets.data[total * WALKS];
    }
}
