#version 460
#extension GL_GOOGLE_include_directive : require
// All lights on every visible fragment: the definition of the picture.
#include "base.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "shade.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    Surface s = read_surface();
    out_radiance = vec4(shade_all_lights(s), 1.0);
}
