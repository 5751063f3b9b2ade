#version 460
#extension GL_GOOGLE_include_directive : require
// What every lit pixel has before the first light of finite reach: ambient light, emission, directional lights.
#include "base.glsl"
#include "read_gbuffer.glsl"
#include "shade.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(0.0);
    Surface s;
    if (!read_gbuffer(ivec2(gl_FragCoord.xy), s)) {
        return;
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    precise vec3 sum = base_radiance(s);
    sum = add_directional_lights(sum, lobes, s, v, 0u, frame.data.directional_count);
    out_radiance = vec4(min(sum, MAX_RADIANCE), 1.0);
}
