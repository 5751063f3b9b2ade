#version 460
#extension GL_GOOGLE_include_directive : require
// The box of each cluster whose entries come from several blocks: a thread a cluster.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer cluster_total;
layout(set = 0, binding = 1, scalar) readonly buffer ClusterFirst { uint data[]; } cluster_first;
layout(set = 0, binding = 2, scalar) readonly buffer SortedOrigins { uint data[]; } sorted_origins;
layout(set = 0, binding = 3, scalar) readonly buffer EntryBounds { float data[]; } entry_bounds;
layout(set = 0, binding = 4, scalar) writeonly buffer ClusterBounds { float data[]; } cluster_bounds;

#include "cluster_thread.glsl"

void main() {
    uint id = thread_index();
    if (id >= texelFetch(cluster_total, 0).x) {
        return;
    }
    uint begin = cluster_first.data[id];
    uint end = cluster_first.data[id + 1u];
    uint from = sorted_origins.data[begin] * BOX_WORDS;
    vec3 low = vec3(entry_bounds.data[from], entry_bounds.data[from + 2u], entry_bounds.data[from + 4u]);
    vec3 high = vec3(entry_bounds.data[from + 1u], entry_bounds.data[from + 3u], entry_bounds.data[from + 5u]);
    for (uint i = begin + 1u; i < end; ++i) {
        from = sorted_origins.data[i] * BOX_WORDS;
        low = min(low, vec3(entry_bounds.data[from], entry_bounds.data[from + 2u], entry_bounds.data[from + 4u]));
        high = max(high, vec3(entry_bounds.data[from + 1u], entry_bounds.data[from + 3u], entry_bounds.data[from + 5u]));
    }
    uint to = id * BOX_WORDS;
    for (uint axis = 0u; axis < 3u; ++axis) {
        cluster_bounds.data[to + 2u * axis] = low[axis];
        cluster_bounds.data[to + 2u * axis + 1u] = high[axis];
    }
}
