#version 460
#extension GL_GOOGLE_include_directive : require
// The keys of a block's samples, ascending and each once: a thread a block.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2) uniform sampler2D depth;
layout(set = 0, binding = 3, scalar) buffer BlockKeys { uint data[]; } block_keys;
layout(set = 0, binding = 4, scalar) writeonly buffer BlockCounts { uint data[]; } block_counts;
layout(set = 0, binding = 5) uniform usampler2D cluster_normals;

#include "cluster_block.glsl"

// Keys below `key` among the `count` that begin at `base`.
uint key_place(uint base, uint count, uint key) {
    uint low = 0u;
    uint high = count;
    while (low < high) {
        uint middle = (low + high) >> 1;
        bool below = block_keys.data[base + middle] < key;
        low = below ? middle + 1u : low;
        high = below ? high : middle;
    }
    return low;
}

void main() {
    uint index = thread_index();
    if (index >= clusters.data.block_count) {
        return;
    }
    Block block = read_block(index);
    uint base = index * clusters.data.block_keys;
    uint count = 0u;
    uint previous = 0u;
    // 256 samples move fewer than 256 * 255 / 2 keys and look each key up in at most 9 steps: 35,216 iterations, where some drivers
    // leave a shader's loops after 65,535.
    for (uint y = block.begin.y; y < block.end.y; ++y) {
        for (uint x = block.begin.x; x < block.end.x; ++x) {
            float stored = texelFetch(depth, ivec2(x, y), 0).x;
            uint key = cluster_key(block.tile, stored, uvec2(x, y));
            if (!shows_surface(stored) || (count > 0u && key == previous)) {
                continue;
            }
            previous = key;
            uint place = key_place(base, count, key);
            if (place < count && block_keys.data[base + place] == key) {
                continue;
            }
            for (uint i = base + count; i > base + place; --i) {
                block_keys.data[i] = block_keys.data[i - 1u];
            }
            block_keys.data[base + place] = key;
            ++count;
        }
    }
    block_counts.data[index] = count;
}
