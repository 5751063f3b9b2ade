#version 460
#extension GL_GOOGLE_include_directive : require
// A light's volume, or the rectangle that stands in for it; src/plan/light_volumes.rs says which, and why either is enough.
#include "base.glsl"

layout(constant_id = 40) const bool RECTANGLE = false;

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;
layout(set = 0, binding = 1, scalar) readonly buffer VolumeBlock { LightVolume data[]; } light_volumes;
layout(set = 0, binding = 2, scalar) uniform CornerBlock { vec4 data[ICOSPHERE_CORNERS]; } corners;

layout(location = 0) flat out uint out_light;

// Two triangles: corners 0, 1, 2 and 1, 2, 3 of the rectangle.
vec4 rectangle_corner(vec4 rectangle) {
    uint corner = gl_VertexIndex < 3 ? uint(gl_VertexIndex) : uint(gl_VertexIndex) - 2u;
    float x = (corner & 1u) != 0u ? rectangle.z : rectangle.x;
    float y = (corner & 2u) != 0u ? rectangle.w : rectangle.y;
    return vec4(x, y, 0.5, 1.0);
}

void main() {
    LightVolume volume = light_volumes.data[gl_InstanceIndex];
    out_light = volume.light;
    if (RECTANGLE) {
        gl_Position = rectangle_corner(volume.place);
        return;
    }
    vec3 position = volume.place.xyz + corners.data[gl_VertexIndex].xyz * volume.place.w;
    vec4 p = frame.data.view_to_clip * vec4(position, 1.0);
    // Away from the eye, by more than depths can be off.
    p.z -= (frame.data.perspective > 0.0 ? VOLUME_DEPTH_SLACK : VOLUME_LINEAR_SLACK) * p.w;
    gl_Position = p;
}
