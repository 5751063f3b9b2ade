#version 460
#extension GL_GOOGLE_include_directive : require
// One gather of the light of all patches by four of them, and a step of Chebyshev's iteration with it (G. Golub, R. Varga, "Chebyshev semi-iterative
// methods", 1961): a group for four rows, its threads take blocks, or columns, in turn and add up their sums halves onto halves.
// CPU twins: radiosity/codec/, radiosity/solve.rs.
#include "base.glsl"

layout(constant_id = 0) const uint CODEC = CODEC_ZERO_BLOCK;
const uint LANES = GATHER_LANES;
layout(local_size_x = 32) in;

layout(set = 0, binding = 0, scalar) readonly buffer OperatorBlock { uint data[]; } words;
layout(set = 0, binding = 1, scalar) readonly buffer PatchBlock { PatchData data[]; } patches;
layout(set = 0, binding = 2, scalar) readonly buffer BeforeBlock { PatchLight data[]; } before;
layout(set = 0, binding = 3, scalar) writeonly buffer AfterBlock { PatchLight data[]; } after;

layout(push_constant, scalar) uniform Push { GatherPush data; } push;

shared vec3 sums[4][32];

float word_float(uint at) {
    return uintBitsToFloat(words.data[at]);
}

// Value of a level of a block, from its least value and the powers of its step.
float level_value(uint level, float end, float step, float twice, float four) {
    uint steps = level - 1u;
    precise float value = end * ((steps & 1u) != 0u ? step : 1.0);
    value *= (steps & 2u) != 0u ? twice : 1.0;
    value *= (steps & 4u) != 0u ? four : 1.0;
    return level == 0u ? 0.0 : value;
}

void add_blocks(uint row, uint lane, inout vec3 gathered[4]) {
    uint first = words.data[push.data.offsets_at + row];
    uint end = words.data[push.data.offsets_at + row + 1u];
    for (uint at = first + lane; at < end; at += LANES) {
        uint low = words.data[push.data.blocks_at + 2u * at];
        uint high = words.data[push.data.blocks_at + 2u * at + 1u];
        uint pair = words.data[push.data.columns_at + at / 2u];
        uint column = 4u * ((at & 1u) == 0u ? pair & 0xffffu : pair >> 16u);
        float least = word_float(push.data.tables_at + (low & 255u));
        float step = word_float(push.data.tables_at + 256u + (low >> 8u & 255u));
        precise float twice = step * step;
        precise float four = twice * twice;
        // Elements 0 to 4 lie in the lower half, 5 across both, the others in the upper one.
        uint levels[4];
        levels[0] = low >> 16u;
        levels[1] = (low >> 28u) | (high << 4u);
        levels[2] = high >> 8u;
        levels[3] = high >> 20u;
        for (uint across = 0u; across < 4u; ++across) {
            vec3 sent = column + across < push.data.count ? before.data[column + across].sent.rgb : vec3(0.0);
            for (uint down = 0u; down < 4u; ++down) {
                float share = level_value(levels[down] >> (3u * across) & 7u, least, step, twice, four);
                precise vec3 product = share * sent;
                precise vec3 sum = gathered[down] + product;
                gathered[down] = sum;
            }
        }
    }
    for (uint down = 0u; down < 4u; ++down) {
        if (4u * row + down >= push.data.count) {
            break;
        }
        uint begin = words.data[push.data.residual_offsets_at + 4u * row + down];
        uint stop = words.data[push.data.residual_offsets_at + 4u * row + down + 1u];
        for (uint at = begin + lane; at < stop; at += LANES) {
            uint entry = words.data[push.data.residuals_at + at];
            precise float share = unpackHalf2x16(entry).y * push.data.residual_scale;
            precise vec3 product = share * before.data[entry & 0xffffu].sent.rgb;
            precise vec3 sum = gathered[down] + product;
            gathered[down] = sum;
        }
    }
}

void add_dense(uint row, uint lane, inout vec3 gathered[4]) {
    for (uint column = lane; column < push.data.count; column += LANES) {
        vec3 sent = before.data[column].sent.rgb;
        for (uint down = 0u; down < 4u; ++down) {
            uint at = min(4u * row + down, push.data.count - 1u);
            precise vec3 product = word_float(at * push.data.count + column) * sent;
            precise vec3 sum = gathered[down] + product;
            gathered[down] = sum;
        }
    }
}

void main() {
    uint row = gl_WorkGroupID.y * MOST_GROUPS + gl_WorkGroupID.x;
    uint lane = gl_LocalInvocationID.x;
    vec3 gathered[4] = vec3[4](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    if (4u * row < push.data.count) {
        if (CODEC == CODEC_DENSE) {
            add_dense(row, lane, gathered);
        } else {
            add_blocks(row, lane, gathered);
        }
    }
    for (uint down = 0u; down < 4u; ++down) {
        sums[down][lane] = gathered[down];
    }
    for (uint width = LANES / 2u; width > 0u; width /= 2u) {
        barrier();
        if (lane < width) {
            for (uint down = 0u; down < 4u; ++down) {
                precise vec3 sum = sums[down][lane] + sums[down][lane + width];
                sums[down][lane] = sum;
            }
        }
    }
    barrier();
    uint patch_id = 4u * row + lane;
    if (lane >= 4u || patch_id >= push.data.count) {
        return;
    }
    PatchLight old = before.data[patch_id];
    PatchData of = patches.data[patch_id];
    precise vec3 correction = push.data.step * (sums[lane][0] - old.irradiance.rgb);
    precise vec3 change = (old.irradiance.rgb - old.previous.rgb) + correction;
    precise vec3 irradiance = push.data.weight * change + old.previous.rgb;
    precise vec3 exitance = old.first.rgb + of.reflectance * irradiance;
    precise vec3 sent = exitance * of.area;
    after.data[patch_id] = PatchLight(vec4(irradiance, 0.0), old.irradiance, vec4(sent, 0.0), old.first);
}
