#version 460
#extension GL_GOOGLE_include_directive : require
// The lights of its tile on every visible fragment.
#include "base.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "shade_list.glsl"
#include "list_parts.glsl"
#include "cull.glsl"
#include "tile_listed.glsl"

layout(constant_id = 20) const uint TILE = 16u;

layout(location = 0) out vec4 out_radiance;

void main() {
    Surface s = read_surface();
    uvec2 at = uvec2(gl_FragCoord.xy) / TILE;
    if (!gl_HelperInvocation && !is_listed(at, -s.position.z)) {
        out_radiance = shade_unlisted(s);
        return;
    }
    uint first = (at.y * grid.data.columns + at.x) * grid.data.list_chunks;
    uint begin = list_offset(first);
    uint end = list_offset(first + grid.data.list_chunks);
    out_radiance = shade_list_part(s, begin, end);
}
