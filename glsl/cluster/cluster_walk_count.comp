#version 460
#extension GL_GOOGLE_include_directive : require
// Lights below a root of the hierarchy that a cluster takes: a thread a cluster and root.
#include "base.glsl"
#include "cluster_walk.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 9, scalar) writeonly buffer Counts { uint data[]; } walk_counts;

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
    uint count = 0u;
    uint light;
    TreeWalk walk = tree_begin(root, root + 1u);
    while (tree_step(walk, low, high, light)) {
        if (light != TREE_NO_LIGHT && takes(cell, edges, light)) {
            ++count;
        }
    }
    walk_counts.data[id * gl_NumWorkGroups.z + root] = count;
}
