#version 460
#extension GL_GOOGLE_include_directive : require
// The place of each flagged cluster among the flagged ones, and its key: a thread a slice of a tile.
#include "base.glsl"
#include "cluster_rank.glsl"
#include "cluster_thread.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2, scalar) readonly buffer Offsets { uint data[]; } flag_offsets;
layout(set = 0, binding = 3, scalar) writeonly buffer Keys { uint data[]; } cluster_keys;
layout(set = 0, binding = 4, r32ui) uniform writeonly uimage2D cluster_ranks;

void main() {
    uint id = thread_index();
    uint slices = clusters.data.slices;
    if (id >= grid.data.columns * grid.data.rows * slices) {
        return;
    }
    uint rank = flag_offsets.data[id];
    bool flagged = flag_offsets.data[id + 1u] != rank;
    imageStore(cluster_ranks, rank_at(id), uvec4(flagged ? rank : NO_CLUSTER));
    if (flagged) {
        uint tile = id / slices;
        uint slice = id - tile * slices;
        cluster_keys.data[rank] = tile << clusters.data.slice_bits | slice << clusters.data.direction_bits;
    }
}
