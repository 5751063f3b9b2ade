#version 460
#extension GL_GOOGLE_include_directive : require
// Depth as a light sees it, opaque surfaces: no fragment stage at all.
#include "base.glsl"
#define MAP_PUSH
#include "vertex.glsl"

void main() {
    gl_Position = vertex_position_cs(vertex_position_vs(instances.data[gl_InstanceIndex], in_position));
}
