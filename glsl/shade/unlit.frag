#version 460
#extension GL_GOOGLE_include_directive : require
// Surfaces whose base colour is the picture.
#include "base.glsl"
#include "surface.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    Surface s = read_surface();
    out_radiance = vec4(min(s.base_color, MAX_RADIANCE), 1.0);
}
