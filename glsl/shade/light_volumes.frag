#version 460
#extension GL_GOOGLE_include_directive : require
// One light on what the G-buffer holds; the blending adds.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade.glsl"

layout(location = 0) flat in uint in_light;
layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(0.0);
    Surface s;
    if (!read_gbuffer(ivec2(gl_FragCoord.xy), s)) {
        return;
    }
    if (light_out_of_range(light_texel(in_light * LIGHT_TEXELS), s.position)) {
        return;
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    out_radiance = vec4(shade_any_light(in_light, lobes, s, v), 0.0);
}
