#version 460
#extension GL_GOOGLE_include_directive : require
// The cluster of each entry, where it stood before the sort: a thread an entry.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer entry_total;
layout(set = 0, binding = 1, scalar) readonly buffer HeadOffsets { uint data[]; } head_offsets;
layout(set = 0, binding = 2, scalar) readonly buffer SortedOrigins { uint data[]; } sorted_origins;
layout(set = 0, binding = 3, scalar) writeonly buffer EntryClusters { uint data[]; } entry_clusters;

#include "cluster_thread.glsl"

void main() {
    uint i = thread_index();
    if (i < texelFetch(entry_total, 0).x) {
        entry_clusters.data[sorted_origins.data[i]] = head_offsets.data[i + 1u] - 1u;
    }
}
