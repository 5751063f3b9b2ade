#version 460
#extension GL_GOOGLE_include_directive : require
// 1 for each sorted key that differs from the one before it, 0 for the others.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform usamplerBuffer entry_total;
layout(set = 0, binding = 1, scalar) readonly buffer SortedKeys { uint data[]; } sorted_keys;
layout(set = 0, binding = 2, scalar) writeonly buffer Heads { uint data[]; } heads;

#include "cluster_thread.glsl"

void main() {
    uint i = thread_index();
    if (i >= texelFetch(entry_total, 0).x) {
        return;
    }
    bool head = true;
    if (i > 0u) {
        head = sorted_keys.data[i] != sorted_keys.data[i - 1u];
    }
    heads.data[i] = head ? 1u : 0u;
}
