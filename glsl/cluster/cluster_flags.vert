#version 460
#extension GL_GOOGLE_include_directive : require
// Blended surfaces, to find their clusters.
#include "base.glsl"
#include "vertex.glsl"

void main() {
    gl_Position = vertex_position_cs(vertex_position_vs(instances.data[gl_InstanceIndex], in_position));
}
