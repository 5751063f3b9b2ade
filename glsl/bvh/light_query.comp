#version 460
#extension GL_GOOGLE_include_directive : require
// Asks the light hierarchy for the lights of many boxes: how many it gives, the sums of their numbers and squares, and the nodes that it
// took. A thread a box and root. Only checks run it; CPU twin: `query` of reference/light_tree.rs.
#include "base.glsl"
#include "light_tree.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform Push { TreeQuery data; } push;
layout(set = 0, binding = 0, scalar) writeonly buffer Found { uvec4 data[]; } found;

void main() {
    uint query = gl_GlobalInvocationID.x;
    uint root = gl_WorkGroupID.y;
    if (query >= push.data.query_count) {
        return;
    }
    // Odd factors: all places come, in an order without a pattern that matters here.
    uvec3 place = (query * uvec3(397u, 631u, 883u)) % TREE_CELLS;
    uint size = query % TREE_QUERY_SIZES;
    float side = size == 0u ? 0.0 : push.data.step * float(1u << (size - 1u));
    precise vec3 offset = push.data.step * vec3(place);
    precise vec3 low = push.data.low + offset;
    precise vec3 high = low + side;
    uvec4 result = uvec4(0u);
    TreeWalk walk = tree_begin(root, root + 1u);
    uint light;
    while (tree_step(walk, low, high, light)) {
        uint number = light + 1u;
        bool met = light != TREE_NO_LIGHT;
        result += uvec4(met ? 1u : 0u, met ? number : 0u, met ? number * number : 0u, 1u);
    }
    found.data[query * gl_NumWorkGroups.y + root] = result;
}
