#version 460
#extension GL_GOOGLE_include_directive : require
// All lights on every pixel of the G-buffer.
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
    out_radiance = vec4(shade_all_lights(s), 1.0);
}
