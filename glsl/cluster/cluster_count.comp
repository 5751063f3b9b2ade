#version 460
#extension GL_GOOGLE_include_directive : require
// Lights that touch a cluster: a thread a cluster.
#include "base.glsl"

layout(local_size_x = 64) in;

#include "cluster_assign.glsl"

layout(set = 0, binding = 9, scalar) writeonly buffer Counts { uint data[]; } cluster_counts;

void main() {
    uint id = thread_index();
    if (id >= clusters.data.capacity) {
        return;
    }
    uint count = 0u;
    if (id < texelFetch(cluster_total, 0).x) {
        Cell cell = read_cell(id);
        for (uint i = cell.begin; i < cell.end; ++i) {
            count += touches(cell, tile_light(i) - grid.data.first_light) ? 1u : 0u;
        }
    }
    cluster_counts.data[id] = count;
}
