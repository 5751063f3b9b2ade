#version 460
#extension GL_GOOGLE_include_directive : require
// Nearest and farthest distance of each tile's samples, opaque ones or stretches from blended to opaque ones, and the mask of slots between
// them that hold samples: a thread a tile, or a group a tile, whose threads each walk through every eighth row and column. Either way the
// same words: minimum, maximum and bitwise or do not depend on order.
#include "base.glsl"
#include "cull.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 20) const uint TILE = 16u;
layout(constant_id = 21) const uint DEPTH_BOUNDS = BOUNDS_MASK;
layout(constant_id = 22) const uint DEPTH_SLOTS = 32u;
layout(constant_id = 23) const bool GROUP_A_TILE = false;
layout(constant_id = 24) const uint HELD = HELD_OPAQUE;
layout(constant_id = 25) const uint SAMPLES = 1u;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1) uniform sampler2D depth;
layout(set = 0, binding = 2, rgba32ui) uniform writeonly uimage2D tile_bounds;
// Nearest blended fragment of each pixel.
layout(set = 0, binding = 3) uniform sampler2D transparent_depth;
// The same of several samples a pixel.
layout(set = 0, binding = 4) uniform sampler2DMS depth_samples;
layout(set = 0, binding = 5) uniform sampler2DMS transparent_samples;

shared uint group_nearest;
shared uint group_farthest;
shared uint group_mask[2];

// Depth is reversed and never negative where something is: 0 is the sky. As integers its bits keep their order.
uint solid_bits(float depth) {
    uint bits = floatBitsToUint(depth);
    return bits - 1u < 0x7f800000u ? bits : 0u;
}

float opaque_depth(ivec2 at, uint index) {
    if (SAMPLES == 1u) {
        return texelFetch(depth, at, 0).x;
    }
    return texelFetch(depth_samples, at, int(index)).x;
}

float blended_depth(ivec2 at, uint index) {
    if (SAMPLES == 1u) {
        return texelFetch(transparent_depth, at, 0).x;
    }
    return texelFetch(transparent_samples, at, int(index)).x;
}

// Bits of the nearest and the farthest depth of a sample. The first is 0 where nothing counts, the second where the sky is behind.
uvec2 sample_bits(ivec2 at, uint index) {
    uint opaque = solid_bits(opaque_depth(at, index));
    if (HELD == HELD_OPAQUE) {
        return uvec2(opaque);
    }
    uint blended = solid_bits(blended_depth(at, index));
    return uvec2(HELD == HELD_BOTH ? max(blended, opaque) : blended, opaque);
}

float farthest_distance(uint bits) {
    return HELD != HELD_OPAQUE && bits == 0u ? grid.data.farthest : distance_range(grid.data, uintBitsToFloat(bits)).y;
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    uvec2 first_pixel = uvec2(0u);
    uint pixel_step = 1u;
    if (GROUP_A_TILE) {
        at = gl_WorkGroupID.xy;
        first_pixel = gl_LocalInvocationID.xy;
        pixel_step = 8u;
    }
    if (at.x >= grid.data.columns || at.y >= grid.data.rows) {
        return;
    }
    uvec2 begin = at * TILE;
    uvec2 end = min(begin + TILE, uvec2(grid.data.width, grid.data.height));
    uint nearest = 0u;
    uint farthest = 0xffffffffu;
    for (uint y = begin.y + first_pixel.y; y < end.y; y += pixel_step) {
        for (uint x = begin.x + first_pixel.x; x < end.x; x += pixel_step) {
            for (uint index = 0u; index < SAMPLES; ++index) {
                uvec2 bits = sample_bits(ivec2(x, y), index);
                nearest = max(nearest, bits.x);
                farthest = min(farthest, bits.x != 0u ? bits.y : 0xffffffffu);
            }
        }
    }
    // What a thread does for its tile; of a group one does it.
    bool stores = !GROUP_A_TILE || gl_LocalInvocationIndex == 0u;
    if (GROUP_A_TILE) {
        if (stores) {
            group_nearest = 0u;
            group_farthest = 0xffffffffu;
            group_mask = uint[2](0u, 0u);
        }
        barrier();
        atomicMax(group_nearest, nearest);
        atomicMin(group_farthest, farthest);
        barrier();
        nearest = group_nearest;
        farthest = group_farthest;
    }
    if (nearest == 0u) {
        if (stores) {
            imageStore(tile_bounds, ivec2(at), uvec4(floatBitsToUint(FAR_LIMIT), 0u, 0u, 0u));
        }
        return;
    }
    float near = distance_range(grid.data, uintBitsToFloat(nearest)).x;
    float far = farthest_distance(farthest);
    uvec2 mask = uvec2(0xffffffffu);
    if (DEPTH_BOUNDS == BOUNDS_MASK) {
        float scale = slots_a_metre(near, far, DEPTH_SLOTS);
        mask = uvec2(0u);
        for (uint y = begin.y + first_pixel.y; y < end.y; y += pixel_step) {
            for (uint x = begin.x + first_pixel.x; x < end.x; x += pixel_step) {
                for (uint index = 0u; index < SAMPLES; ++index) {
                    uvec2 bits = sample_bits(ivec2(x, y), index);
                    bits = bits.x != 0u ? bits : uvec2(nearest);
                    float begin = distance_range(grid.data, uintBitsToFloat(bits.x)).x;
                    uint first = depth_slot(near, scale, begin, DEPTH_SLOTS);
                    uint last = depth_slot(near, scale, farthest_distance(bits.y), DEPTH_SLOTS);
                    mask |= slot_mask(first, last);
                }
            }
        }
        if (GROUP_A_TILE) {
            atomicOr(group_mask[0], mask.x);
            atomicOr(group_mask[1], mask.y);
            barrier();
            mask = uvec2(group_mask[0], group_mask[1]);
        }
    }
    if (stores) {
        imageStore(tile_bounds, ivec2(at), uvec4(floatBitsToUint(near), floatBitsToUint(far), mask));
    }
}
