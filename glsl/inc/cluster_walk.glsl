// Candidates from the light hierarchy, which a cluster walks through with its own box: a thread a cluster and root, whose walk stays below
// the iterations that every driver carries out. What they meet in the order of keys is sorted afterwards.
#include "cluster_assign.glsl"
#include "light_tree.glsl"

layout(constant_id = 23) const uint CULL = CULL_PLANES_BOX;

#include "tile_test.glsl"

// The box that a walk asks for: all that the cluster may hold, in view space.
void walk_box(Cell cell, out vec3 low, out vec3 high) {
    vec2 x = cell.across;
    vec2 y = cell.up;
    if (!EXPLICIT) {
        x = edge_interval(grid.data, x.x, x.y, cell.near, cell.far);
        y = edge_interval(grid.data, y.x, y.y, cell.near, cell.far);
    }
    low = vec3(x.x, y.x, -cell.far);
    high = vec3(x.y, y.y, -cell.near);
}

// What the list of the tile takes where nothing is known of its depths, and then the cluster: lists are the same whichever way their
// candidates come, and stay within the plan's bound.
bool takes(Cell cell, TileEdges edges, uint light) {
    vec4 sphere = cull_texel(light * CULL_TEXELS);
    vec4 extent = cull_texel(light * CULL_TEXELS + 1u);
    vec2 distances = vec2(max(grid.data.near, extent.x), min(grid.data.far, extent.y));
    return distances.x <= distances.y && in_bin(cell.source / BIN_TILES, light)
        && reaches_tile(edges, cell.source, light, sphere, extent.z, distances) && touches(cell, light);
}
