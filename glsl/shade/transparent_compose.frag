#version 460
#extension GL_GOOGLE_include_directive : require
// The layer of blended surfaces over the picture. Its colours are multiplied by their alpha already.
#include "base.glsl"

layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1) uniform sampler2D transparent_layer;

layout(location = 0) out vec4 out_radiance;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 behind = texelFetch(radiance, at, 0);
    vec4 layer = texelFetch(transparent_layer, at, 0);
    precise vec4 mixed = layer + behind * (1.0 - layer.a);
    out_radiance = mixed;
}
