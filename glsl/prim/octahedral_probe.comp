#version 460
#extension GL_GOOGLE_include_directive : require
// Decodes codes of normals that a check asks for: a thread a code. CPU twin: reference/octahedral.rs.
#include "base.glsl"
#include "octahedral.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint BITS = 8u;
// Codes of the second axis are this far apart.
layout(constant_id = 1) const uint ROW_STEP = 1u;
layout(constant_id = 2) const uint FIRST_ROW = 0u;

layout(set = 0, binding = 0, scalar) writeonly buffer Normals { vec3 data[]; } normals;

void main() {
    uint index = gl_WorkGroupID.y * (1u << BITS) + gl_GlobalInvocationID.x;
    uvec2 code = uvec2(gl_GlobalInvocationID.x, FIRST_ROW + gl_WorkGroupID.y * ROW_STEP);
    normals.data[index] = decode_octahedral(code, BITS);
}
