#version 460
#extension GL_GOOGLE_include_directive : require
// The lights of its tile on every pixel of the G-buffer: a thread a pixel.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade_list.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 20) const uint TILE = 16u;

layout(set = 0, binding = 30, rgba32f) uniform writeonly image2D radiance;

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= grid.data.width || at.y >= grid.data.height) {
        return;
    }
    Surface s;
    if (!read_gbuffer(ivec2(at), s)) {
        imageStore(radiance, ivec2(at), vec4(0.0));
        return;
    }
    uvec2 tile = at / TILE;
    uint first = (tile.y * grid.data.columns + tile.x) * grid.data.list_chunks;
    uint begin = list_offset(first);
    uint end = list_offset(first + grid.data.list_chunks);
    imageStore(radiance, ivec2(at), vec4(shade_listed_lights(s, begin, end), 1.0));
}
