#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the ids of the lights that tile_count counted where the scan says, in id order.
#include "base.glsl"
#include "tile_cull.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 8, scalar) readonly buffer Offsets { uint data[]; } tile_offsets;
layout(set = 0, binding = 9, scalar) writeonly buffer Lights { uint data[]; } tile_lights;

void main() {
    uvec2 at;
    uint begin;
    uint end;
    if (!tile_of_thread(at, begin, end)) {
        return;
    }
    Tile tile = read_tile(at);
    uint next = tile_offsets.data[(at.y * grid.data.columns + at.x) * grid.data.list_chunks + gl_WorkGroupID.y];
    for (uint i = begin; i < end; ++i) {
        uint light = bin_light(i);
        if (intersects(tile, light)) {
            tile_lights.data[next] = grid.data.first_light + light;
            ++next;
        }
    }
}
