#version 460
#extension GL_GOOGLE_include_directive : require
// The mean of a pixel's samples, added up in their order.
#include "base.glsl"

layout(constant_id = 25) const uint SAMPLES = 4u;

layout(set = 0, binding = 0) uniform sampler2DMS radiance_samples;

layout(location = 0) out vec4 out_radiance;

void main() {
    precise vec4 sum = vec4(0.0);
    for (uint index = 0u; index < SAMPLES; ++index) {
        sum += texelFetch(radiance_samples, ivec2(gl_FragCoord.xy), int(index)) * (1.0 / float(SAMPLES));
    }
    out_radiance = sum;
}
