#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of blended surfaces.
#include "base.glsl"
#include "vertex.glsl"

void main() {
    gl_Position = vertex_position_cs(vertex_position_vs(instances.data[gl_InstanceIndex], in_position));
}
