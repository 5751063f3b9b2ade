#version 460
#extension GL_GOOGLE_include_directive : require
// The cluster of each sample, and the view-space box of the samples of each key of a block: a thread a block, four keys a walk.
#include "base.glsl"
#include "cull.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 20) const bool EXPLICIT = true;
// Keys of several blocks were merged.
layout(constant_id = 21) const bool MERGED = false;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2) uniform sampler2D depth;
layout(set = 0, binding = 3, scalar) readonly buffer BlockKeys { uint data[]; } block_keys;
layout(set = 0, binding = 4, scalar) readonly buffer BlockOffsets { uint data[]; } block_offsets;
layout(set = 0, binding = 5, scalar) readonly buffer EntryClusters { uint data[]; } entry_clusters;
layout(set = 0, binding = 6, scalar) writeonly buffer EntryBounds { uint data[]; } entry_bounds;
layout(set = 0, binding = 7, r32ui) uniform writeonly uimage2D cluster_index;
layout(set = 0, binding = 8) uniform usampler2D cluster_normals;

#include "cluster_block.glsl"

// Keys of a walk. Their boxes stay in registers: drivers that run lanes in step pay for each lane's key otherwise.
const uint BATCH = 4u;
// Beyond every coordinate.
const float BEYOND = 3.0e38;

// A component a key of the walk.
struct Boxes {
    vec4 near;
    vec4 far;
    vec4 left;
    vec4 right;
    vec4 low;
    vec4 high;
};

// Both edges of a pixel on the image plane, widened by what rounding may have taken from them.
vec2 pixel_edges(vec3 axis, uint pixel) {
    precise float a = float(pixel) * axis.y;
    precise float b = float(pixel + 1u) * axis.y;
    precise float first = a + axis.x;
    precise float last = b + axis.x;
    precise float low = min(first, last) - axis.z;
    precise float high = max(first, last) + axis.z;
    return vec2(low, high);
}

void grow(inout Boxes boxes, bvec4 mine, vec2 at, vec2 x, vec2 y) {
    boxes.near = mix(boxes.near, min(boxes.near, vec4(at.x)), mine);
    boxes.far = mix(boxes.far, max(boxes.far, vec4(at.y)), mine);
    boxes.left = mix(boxes.left, min(boxes.left, vec4(x.x)), mine);
    boxes.right = mix(boxes.right, max(boxes.right, vec4(x.y)), mine);
    boxes.low = mix(boxes.low, min(boxes.low, vec4(y.x)), mine);
    boxes.high = mix(boxes.high, max(boxes.high, vec4(y.y)), mine);
}

// Drivers differ in the sign of a 0 that min and max give.
void put(uint at, float x) {
    uint bits = floatBitsToUint(x);
    entry_bounds.data[at] = bits == 0x80000000u ? 0u : bits;
}

void put_box(uint entry, Boxes boxes, uint key) {
    uint at = entry * BOX_WORDS;
    put(at, boxes.near[key]);
    put(at + 1u, boxes.far[key]);
    put(at + 2u, boxes.left[key]);
    put(at + 3u, boxes.right[key]);
    put(at + 4u, boxes.low[key]);
    put(at + 5u, boxes.high[key]);
}

// One walk: samples with any of four keys. The first walk also tells the sky.
void walk(Block block, uvec4 keys, uvec4 ids, bool first, inout Boxes boxes) {
    for (uint y = block.begin.y; y < block.end.y; ++y) {
        vec2 row = pixel_edges(clusters.data.pixel_y, y);
        for (uint x = block.begin.x; x < block.end.x; ++x) {
            float stored = texelFetch(depth, ivec2(x, y), 0).x;
            bool solid = shows_surface(stored);
            uint key = cluster_key(block.tile, stored, uvec2(x, y));
            bvec4 mine = solid ? equal(keys, uvec4(key)) : bvec4(false);
            if (EXPLICIT) {
                // Nothing is drawn nearer than the view begins; from there on every product is finite.
                vec2 at = distance_range(grid.data, stored);
                at.x = max(at.x, grid.data.near);
                vec2 column = pixel_edges(clusters.data.pixel_x, x);
                vec2 across = edge_interval(grid.data, column.x, column.y, at.x, at.y);
                vec2 up = edge_interval(grid.data, row.x, row.y, at.x, at.y);
                grow(boxes, mine, at, across, up);
            }
            uint id = mine.x ? ids.x : mine.y ? ids.y : mine.z ? ids.z : ids.w;
            if (any(mine) || (first && !solid)) {
                imageStore(cluster_index, ivec2(x, y), uvec4(solid ? id : NO_CLUSTER));
            }
        }
    }
}

void main() {
    uint index = thread_index();
    if (index >= clusters.data.block_count) {
        return;
    }
    Block block = read_block(index);
    uint base = index * clusters.data.block_keys;
    uint offset = block_offsets.data[index];
    uint count = block_offsets.data[index + 1u] - offset;
    // 64 walks of 256 samples at most: 17,600 iterations.
    for (uint first = 0u; first == 0u || first < count; first += BATCH) {
        uvec4 keys = uvec4(0u);
        uvec4 ids = uvec4(NO_CLUSTER);
        for (uint i = 0u; i < BATCH && count > 0u; ++i) {
            // What a walk has no key for stands for its last key once more.
            uint place = min(first + i, count - 1u);
            keys[i] = block_keys.data[base + place];
            ids[i] = MERGED ? entry_clusters.data[offset + place] : offset + place;
        }
        vec4 most = vec4(BEYOND);
        Boxes boxes = Boxes(most, -most, most, -most, most, -most);
        walk(block, keys, ids, first == 0u, boxes);
        for (uint i = 0u; EXPLICIT && i < BATCH && first + i < count; ++i) {
            put_box(offset + first + i, boxes, i);
        }
    }
}
