#version 460
#extension GL_GOOGLE_include_directive : require
// All lights on every visible fragment: the definition of the picture.
#include "base.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "shade.glsl"
#include "light_parts.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    Surface s = read_surface();
    if (s.unlit) {
        out_radiance = unlit_part(s);
        return;
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    vec4 before = sum_before(s);
    uint first = min(uint(before.a), frame.data.light_count);
    uint end = first + min(PART_LIGHTS, frame.data.light_count - first);
    out_radiance = sum_after(s, add_lights(before.rgb, lobes, s, v, first, end), end);
}
