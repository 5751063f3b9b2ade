#version 460
#extension GL_GOOGLE_include_directive : require
// The loop over all lights on a made-up surface, and nothing else: the most that shading can reach on a driver.
#include "base.glsl"
#include "surface_data.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;

#include "shade.glsl"

layout(location = 0) out vec4 out_radiance;

void main() {
    // A wall 10 m in front of the camera, 0.01 m a pixel.
    vec3 position = vec3((gl_FragCoord.xy - 500.0) * 0.01, -10.0);
    Surface s = Surface(position, vec3(0.0, 0.0, 1.0), vec3(0.8), 1.0, 0.0, 0.6, 1.0, vec3(0.0), false, SHADING_GLTF,
        vec3(0.0), 1.0);
    out_radiance = vec4(shade_all_lights(s), 1.0);
}
