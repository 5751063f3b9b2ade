#version 460
#extension GL_GOOGLE_include_directive : require
// The lights of its tile on every pixel of the G-buffer: a thread a pixel, or a thread for four of a column, which lie in one tile and
// share what is read of each light.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade_list.glsl"
#include "tile_listed.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 20) const uint TILE = 16u;
layout(constant_id = 33) const uint PIXELS_A_THREAD = 4u;

layout(set = 0, binding = 30, rgba32f) uniform writeonly image2D radiance;

#include "shade_samples.glsl"

// First and last of a pixel's list, one past it.
uvec2 list_of(uvec2 at) {
    uvec2 tile = at / TILE;
    uint first = (tile.y * grid.data.columns + tile.x) * grid.data.list_chunks;
    return uvec2(list_offset(first), list_offset(first + grid.data.list_chunks));
}

vec3 light_surface(uvec2 at, Surface s, float depth) {
    if (!is_listed(at / TILE, -s.position.z)) {
        return shade_all_lights(s);
    }
    uvec2 list = list_of(at);
    return shade_listed_lights(s, list.x, list.y);
}

void store(uvec2 at, vec3 light, bool seen) {
    if (at.y < grid.data.height) {
        imageStore(radiance, ivec2(at), seen ? vec4(min(light, MAX_RADIANCE), 1.0) : vec4(0.0));
    }
}

// Past the last row stands its copy.
bool read_row(uvec2 at, out Surface s) {
    return read_gbuffer(ivec2(at.x, min(at.y, grid.data.height - 1u)), s);
}

void shade_column(uvec2 at) {
    Surface first, second, third, fourth;
    bool seen_first = read_row(at, first);
    bool seen_second = read_row(at + uvec2(0u, 1u), second);
    bool seen_third = read_row(at + uvec2(0u, 2u), third);
    bool seen_fourth = read_row(at + uvec2(0u, 3u), fourth);
    if (!(seen_first || seen_second || seen_third || seen_fourth)) {
        for (uint row = 0u; row < 4u; ++row) {
            store(at + uvec2(0u, row), vec3(0.0), false);
        }
        return;
    }
    Lit a = begin_lit(first);
    Lit b = begin_lit(second);
    Lit c = begin_lit(third);
    Lit d = begin_lit(fourth);
    uvec2 list = list_of(at);
    shade_four(a, b, c, d, list.x, list.y);
    store(at, a.sum, seen_first);
    store(at + uvec2(0u, 1u), b.sum, seen_second);
    store(at + uvec2(0u, 2u), c.sum, seen_third);
    store(at + uvec2(0u, 3u), d.sum, seen_fourth);
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy * uvec2(1u, PIXELS_A_THREAD);
    if (at.x >= grid.data.width || at.y >= grid.data.height) {
        return;
    }
    if (SAMPLES > 1u) {
        shade_samples(at);
        return;
    }
    if (PIXELS_A_THREAD == 4u) {
        shade_column(at);
        return;
    }
    Surface s;
    if (!read_gbuffer(ivec2(at), s)) {
        imageStore(radiance, ivec2(at), vec4(0.0));
        return;
    }
    uvec2 list = list_of(at);
    imageStore(radiance, ivec2(at), vec4(shade_listed_lights(s, list.x, list.y), 1.0));
}
