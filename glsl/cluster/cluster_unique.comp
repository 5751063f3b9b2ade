#version 460
#extension GL_GOOGLE_include_directive : require
// The key of each cluster, and where its entries begin among the sorted ones: a thread an entry.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer entry_total;
layout(set = 0, binding = 1, scalar) readonly buffer HeadOffsets { uint data[]; } head_offsets;
layout(set = 0, binding = 2, scalar) readonly buffer SortedKeys { uint data[]; } sorted_keys;
layout(set = 0, binding = 3, scalar) writeonly buffer ClusterKeys { uint data[]; } cluster_keys;
layout(set = 0, binding = 4, scalar) writeonly buffer ClusterFirst { uint data[]; } cluster_first;

#include "cluster_thread.glsl"

void main() {
    uint i = thread_index();
    uint total = texelFetch(entry_total, 0).x;
    if (i >= total) {
        return;
    }
    uint before = head_offsets.data[i];
    uint until = head_offsets.data[i + 1u];
    if (before != until) {
        cluster_keys.data[before] = sorted_keys.data[i];
        cluster_first.data[before] = i;
    }
    if (i + 1u == total) {
        cluster_first.data[until] = total;
    }
}
