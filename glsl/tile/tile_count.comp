#version 460
#extension GL_GOOGLE_include_directive : require
// Lights of a run of its bin's list that touch a tile: a thread a tile and run.
#include "base.glsl"
#include "tile_cull.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 8, scalar) writeonly buffer Counts { uint data[]; } tile_counts;

void main() {
    uvec2 at;
    uint begin;
    uint end;
    if (!tile_of_thread(at, begin, end)) {
        return;
    }
    Tile tile = read_tile(at);
    uint count = 0u;
    for (uint i = begin; i < end; ++i) {
        count += intersects(tile, bin_light(i)) ? 1u : 0u;
    }
    tile_counts.data[(at.y * grid.data.columns + at.x) * grid.data.list_chunks + gl_WorkGroupID.y] = count;
}
