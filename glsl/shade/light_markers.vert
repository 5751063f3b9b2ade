#version 460
#extension GL_GOOGLE_include_directive : require
// A small sphere where a light stands.
#include "base.glsl"

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;
layout(set = 0, binding = 1, scalar) readonly buffer MarkerBlock { LightMarker data[]; } light_markers;
layout(set = 0, binding = 2, scalar) uniform CornerBlock { vec4 data[ICOSPHERE_CORNERS]; } corners;

layout(location = 0) flat out vec3 out_color;

void main() {
    LightMarker marker = light_markers.data[gl_InstanceIndex];
    out_color = marker.color;
    vec3 position = marker.center + corners.data[gl_VertexIndex].xyz * marker.radius;
    gl_Position = frame.data.view_to_clip * vec4(position, 1.0);
}
