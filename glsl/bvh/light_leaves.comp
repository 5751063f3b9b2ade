#version 460
#extension GL_GOOGLE_include_directive : require
// The boxes of single lights in the order of their keys, and the header: a thread a light.
#include "base.glsl"
#include "cull_lights.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform Push { TreeShape data; } push;
layout(set = 0, binding = 3, scalar) readonly buffer Sorted { uint data[]; } sorted_lights;
layout(set = 0, binding = 4, scalar) writeonly buffer LightTree { vec4 texels[]; } light_tree;

void main() {
    uint place = gl_GlobalInvocationID.x;
    uint everywhere_count = push.data.everywhere_count;
    if (place == 0u) {
        uint below = push.data.light_count - everywhere_count;
        light_tree.texels[0] = vec4(uvec4(everywhere_count, below, push.data.height, push.data.root_count));
    }
    if (place >= push.data.light_count) {
        return;
    }
    uint light = sorted_lights.data[place];
    vec3 center = cull_texel(light * CULL_TEXELS).xyz;
    precise float radius = cull_texel(light * CULL_TEXELS + 1u).z;
    vec4 tiles = cull_texel(light * CULL_TEXELS + 2u);
    // What rounding lets tests of the squared radius reach beyond it: 2^-22.
    radius += radius * DISTANCE_SLACK;
    // The widening afterwards takes back what these lines rounded: 2^-24 of the result.
    precise vec3 low = center - radius;
    precise vec3 high = center + radius;
    low -= abs(low) * DISTANCE_SLACK;
    high += abs(high) * DISTANCE_SLACK;
    if (tiles.x > tiles.y || tiles.z > tiles.w) {
        low = vec3(TREE_EMPTY);
        high = vec3(-TREE_EMPTY);
    }
    uint entry = place < everywhere_count ? place : push.data.leaf_first + place - everywhere_count;
    light_tree.texels[TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * entry] = vec4(low, float(light));
    light_tree.texels[TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * entry + 1u] = vec4(high, 1.0);
}
