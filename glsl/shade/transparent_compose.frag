#version 460
#extension GL_GOOGLE_include_directive : require
// The layer of blended surfaces over the picture, and the mean of a pixel's samples. Colours of the layer are multiplied by their alpha already.
#include "base.glsl"

layout(constant_id = 25) const uint SAMPLES = 1u;

layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1) uniform sampler2D transparent_layer;
layout(set = 0, binding = 2) uniform sampler2DMS radiance_samples;
layout(set = 0, binding = 3) uniform sampler2DMS layer_samples;

layout(location = 0) out vec4 out_radiance;

vec4 over(vec4 layer, vec4 behind) {
    precise vec4 mixed = layer + behind * (1.0 - layer.a);
    return mixed;
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (SAMPLES == 1u) {
        out_radiance = over(texelFetch(transparent_layer, at, 0), texelFetch(radiance, at, 0));
        return;
    }
    precise vec4 sum = vec4(0.0);
    for (uint index = 0u; index < SAMPLES; ++index) {
        vec4 layer = texelFetch(layer_samples, at, int(index));
        sum += over(layer, texelFetch(radiance_samples, at, int(index))) * (1.0 / float(SAMPLES));
    }
    out_radiance = sum;
}
