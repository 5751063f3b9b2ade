#version 460
#extension GL_GOOGLE_include_directive : require
// Lights that touch a cluster: a thread a cluster.
#include "base.glsl"
#include "cluster_assign.glsl"
#include "cluster_candidates.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 9, scalar) writeonly buffer Counts { uint data[]; } cluster_counts;

void main() {
    uint id = thread_index();
    if (id >= texelFetch(cluster_total, 0).x) {
        return;
    }
    Cell cell = read_cell(id);
    uint count = 0u;
    for (uint i = cell.source.x; i < cell.source.y; ++i) {
        count += touches(cell, tile_light(i) - grid.data.first_light) ? 1u : 0u;
    }
    cluster_counts.data[id] = count;
}
