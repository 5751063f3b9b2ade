#version 460
#extension GL_GOOGLE_include_directive : require
// One level of the light hierarchy from the one below it: a thread a node. Nodes without children fill the level up, empty.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform Push { TreeLevel data; } push;
layout(set = 0, binding = 0, scalar) buffer LightTree { vec4 texels[]; } light_tree;

void main() {
    uint node = gl_GlobalInvocationID.x;
    if (node >= push.data.count) {
        return;
    }
    vec3 low = vec3(TREE_EMPTY);
    vec3 high = vec3(-TREE_EMPTY);
    // Whole numbers below 2^24: exact in any order.
    float lights = 0.0;
    uint end = min((node + 1u) * TREE_WIDTH, push.data.child_count);
    for (uint child = node * TREE_WIDTH; child < end; ++child) {
        uint at = TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * (push.data.child_first + child);
        vec4 child_high = light_tree.texels[at + 1u];
        low = min(low, light_tree.texels[at].xyz);
        high = max(high, child_high.xyz);
        lights += child_high.w;
    }
    uint at = TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * (push.data.first + node);
    light_tree.texels[at] = vec4(low, 0.0);
    light_tree.texels[at + 1u] = vec4(high, lights);
}
