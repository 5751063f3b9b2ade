#version 460
#extension GL_GOOGLE_include_directive : require
// Keys that bring lights near each other together: the Morton code of the centre's cell (G. Morton, "A Computer Oriented Geodetic Data
// Base", IBM, 1966). A thread a light.
#include "base.glsl"
#include "cull_lights.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform Push { TreeShape data; } push;
layout(set = 0, binding = 3, scalar) writeonly buffer Keys { uint data[]; } keys;
layout(set = 0, binding = 4, scalar) writeonly buffer Lights { uint data[]; } lights;

// The cell that holds a coordinate; it never descends as the coordinate grows.
uint cell(float x, float low) {
    precise float at = (x - low) * push.data.scale;
    return uint(clamp(at, 0.0, float(TREE_CELLS - 1u)));
}

// Bit i goes to bit 3 i, ten bits.
uint spread(uint x) {
    x = (x | (x << 16)) & 0x030000ffu;
    x = (x | (x << 8)) & 0x0300f00fu;
    x = (x | (x << 4)) & 0x030c30c3u;
    return (x | (x << 2)) & 0x09249249u;
}

uint light_key(uint light) {
    vec4 sphere = cull_texel(light * CULL_TEXELS);
    float radius = cull_texel(light * CULL_TEXELS + 1u).z;
    vec4 tiles = cull_texel(light * CULL_TEXELS + 2u);
    if (tiles.x > tiles.y || tiles.z > tiles.w) {
        return TREE_KEY_EMPTY;
    }
    if (radius > push.data.radius_limit) {
        return TREE_KEY_EVERYWHERE;
    }
    uint x = spread(cell(sphere.x, push.data.low.x));
    uint y = spread(cell(sphere.y, push.data.low.y));
    uint z = spread(cell(sphere.z, push.data.low.z));
    return TREE_KEY_CENTER | x | (y << 1) | (z << 2);
}

void main() {
    uint light = gl_GlobalInvocationID.x;
    if (light < push.data.light_count) {
        keys.data[light] = light_key(light);
        lights.data[light] = light;
    }
}
