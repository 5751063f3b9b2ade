#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the ids of the lights that cluster_count counted where the scan says, in id order.
#include "base.glsl"
#include "cluster_assign.glsl"
#include "cluster_candidates.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 9, scalar) readonly buffer Offsets { uint data[]; } cluster_offsets;
layout(set = 0, binding = 10, scalar) writeonly buffer Lights { uint data[]; } cluster_lights;

void main() {
    uint id = thread_index();
    if (id >= texelFetch(cluster_total, 0).x) {
        return;
    }
    Cell cell = read_cell(id);
    uint next = cluster_offsets.data[id];
    for (uint i = cell.source.x; i < cell.source.y; ++i) {
        uint light = tile_light(i);
        if (touches(cell, light - grid.data.first_light)) {
            cluster_lights.data[next] = light;
            ++next;
        }
    }
}
