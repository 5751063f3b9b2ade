// The list of a sample's cluster. Comes after shade_list.glsl, whose grid and offsets it reads.
#include "cluster_slice.glsl"
#include "cluster_rank.glsl"

layout(constant_id = 20) const uint TILE = 16u;
// How a sample finds its cluster.
layout(constant_id = 23) const uint CLUSTER_OF = CLUSTER_OF_PIXEL;

layout(set = 0, binding = 11, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 12) uniform usampler2D cluster_index;

uint cluster_of(uvec2 pixel, float depth) {
    if (CLUSTER_OF == CLUSTER_OF_PIXEL) {
        // A quad reaches past a picture of odd size.
        uvec2 last = uvec2(grid.data.width, grid.data.height) - 1u;
        return texelFetch(cluster_index, ivec2(min(pixel, last)), 0).x;
    }
    uvec2 at = pixel / TILE;
    uint tile = at.y * grid.data.columns + at.x;
    uint id = tile * clusters.data.slices + cluster_slice(grid.data, clusters.data, depth);
    return CLUSTER_OF == CLUSTER_OF_RANK ? texelFetch(cluster_index, rank_at(id), 0).x : id;
}

// The stored depth of a distance along the view axis.
float depth_of_distance(float d) {
    if (grid.data.perspective != 0u) {
        precise float depth = grid.data.depth_offset / max(d, 1e-37) - grid.data.depth_scale;
        return depth;
    }
    precise float depth = (grid.data.depth_offset - d) / grid.data.depth_scale;
    return depth;
}

// First entry of the list and the one behind its last; none for the sky.
uvec2 cluster_list(uvec2 pixel, float depth) {
    uint id = cluster_of(pixel, depth);
    if (id == NO_CLUSTER) {
        return uvec2(0u);
    }
    return uvec2(list_offset(id), list_offset(id + 1u));
}
