#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the ids of the lights that cluster_walk_count counted where the scan says, in the order in which walks meet them.
#include "base.glsl"
#include "cluster_walk.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 9, scalar) readonly buffer Offsets { uint data[]; } walk_offsets;
layout(set = 0, binding = 10, scalar) writeonly buffer Lights { uint data[]; } cluster_lights;

void main() {
    uint id = thread_index();
    if (id >= texelFetch(cluster_total, 0).x) {
        return;
    }
    Cell cell = read_cell(id);
    TileEdges edges = read_edges(cell.source);
    vec3 low;
    vec3 high;
    walk_box(cell, low, high);
    uint root = gl_WorkGroupID.z;
    uint next = walk_offsets.data[id * gl_NumWorkGroups.z + root];
    uint light;
    TreeWalk walk = tree_begin(root, root + 1u);
    while (tree_step(walk, low, high, light)) {
        if (light != TREE_NO_LIGHT && takes(cell, edges, light)) {
            cluster_lights.data[next] = grid.data.first_light + light;
            ++next;
        }
    }
}
