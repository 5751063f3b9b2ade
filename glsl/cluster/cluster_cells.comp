#version 460
#extension GL_GOOGLE_include_directive : require
// What assignment reads of each cluster, in one place: a thread a cluster.
#include "base.glsl"
#include "cluster_cells.glsl"

layout(local_size_x = 64) in;

// Every slice of every tile is a cluster; there are no keys.
layout(constant_id = 20) const bool DENSE = false;
layout(constant_id = 21) const bool EXPLICIT = true;
// Where candidates come from.
layout(constant_id = 22) const uint ASSIGN = ASSIGN_TILE;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2) uniform usamplerBuffer cluster_total;
// Nearest and farthest distance of each slice; then the bounds of the normals of each direction.
layout(set = 0, binding = 3) uniform samplerBuffer cluster_slices;
layout(set = 0, binding = 4, scalar) readonly buffer TileOffsets { uint data[]; } tile_offsets;
layout(set = 0, binding = 5, scalar) readonly buffer ClusterKeys { uint data[]; } cluster_keys;
layout(set = 0, binding = 6, scalar) readonly buffer ClusterBounds { uint data[]; } cluster_bounds;
layout(set = 0, binding = 7, rgba32ui) uniform writeonly uimage2D cluster_cells;

#include "cluster_thread.glsl"

void main() {
    uint id = thread_index();
    if (id >= texelFetch(cluster_total, 0).x) {
        return;
    }
    uint slices = clusters.data.slices;
    uint tile = id / slices;
    uint slice = id - tile * slices;
    uint direction = 0u;
    if (!DENSE) {
        uint key = cluster_keys.data[id];
        tile = key >> clusters.data.slice_bits;
        uint low = key - (tile << clusters.data.slice_bits);
        slice = low >> clusters.data.direction_bits;
        direction = low - (slice << clusters.data.direction_bits);
    }
    uvec2 at = uvec2(tile % grid.data.columns, tile / grid.data.columns);
    uvec2 source = at;
    if (ASSIGN == ASSIGN_TILE) {
        uint first = tile * grid.data.list_chunks;
        source = uvec2(tile_offsets.data[first], tile_offsets.data[first + grid.data.list_chunks]);
    }
    vec2 distances = texelFetch(cluster_slices, int(slice)).xy;
    uvec4 around = uvec4(at, 0u, 0u);
    if (EXPLICIT) {
        uint from = id * BOX_WORDS;
        // Never beyond the slice: the plan counts on it.
        distances.x = max(distances.x, uintBitsToFloat(cluster_bounds.data[from]));
        distances.y = min(distances.y, uintBitsToFloat(cluster_bounds.data[from + 1u]));
        around = uvec4(cluster_bounds.data[from + 2u], cluster_bounds.data[from + 3u], cluster_bounds.data[from + 4u],
            cluster_bounds.data[from + 5u]);
    }
    imageStore(cluster_cells, cell_at(id, 0u), uvec4(source, floatBitsToUint(distances)));
    imageStore(cluster_cells, cell_at(id, 1u), around);
    if (BY_NORMAL) {
        int first = int(slices + 2u * direction);
        imageStore(cluster_cells, cell_at(id, 2u), floatBitsToUint(texelFetch(cluster_slices, first)));
        imageStore(cluster_cells, cell_at(id, 3u), floatBitsToUint(texelFetch(cluster_slices, first + 1)));
    }
}
