#version 460
#extension GL_GOOGLE_include_directive : require
// One gather of the light of all patches by four of them, and a step of Chebyshev's iteration with it (G. Golub, R. Varga, "Chebyshev semi-iterative
// methods", 1961): a group for four rows, its threads take blocks, or columns, in turn and add up their sums halves onto halves.
// CPU twins: radiosity/codec/, radiosity/solve.rs.
#include "base.glsl"

layout(constant_id = 0) const uint CODEC = CODEC_ZERO_BLOCK;
// Threads of a group: as many as the device runs in step (GROUP_SIZE).
layout(local_size_x_id = 3) in;
const uint LANES = gl_WorkGroupSize.x;

// A thread adds a row by itself instead of a group four of them, all of it from storage buffers, as in the thesis; 32 bits an element alone.
layout(constant_id = 2) const bool THREAD_ROWS = false;

// All light and all surfaces are grey: one channel is gathered, and stands for three.
layout(constant_id = 4) const bool GREY = false;

layout(set = 0, binding = 1, scalar) readonly buffer PatchBlock { PatchData data[]; } patches;
layout(set = 0, binding = 2, scalar) readonly buffer BeforeBlock { PatchLight data[]; } before;
layout(set = 0, binding = 3, scalar) writeonly buffer AfterBlock { PatchLight data[]; } after;

#include "matrix.glsl"

// What `before` holds, four numbers at a time: drivers on the CPU fetch these at once.
layout(set = 0, binding = 6) uniform samplerBuffer bounced_sent;

layout(push_constant, scalar) uniform Push { GatherPush data; } push;

#include "sums.glsl"

vec3 sent_by(uint column) {
    return texelFetch(bounced_sent, int(column * BOUNCED_LIGHT_TEXELS + 2u)).rgb;
}

// Adds light of one column to a sum.
void add(inout vec3 sum, float share, vec3 sent) {
    if (GREY) {
        precise float product = share * sent.x;
        precise float added = sum.x + product;
        sum.x = added;
        return;
    }
    precise vec3 product = share * sent;
    precise vec3 added = sum + product;
    sum = added;
}

// Value of a level of a block, from its least value and the powers of its step.
float level_value(uint level, float end, float step, float twice, float four) {
    uint steps = level - 1u;
    precise float value = end * ((steps & 1u) != 0u ? step : 1.0);
    value *= (steps & 2u) != 0u ? twice : 1.0;
    value *= (steps & 4u) != 0u ? four : 1.0;
    return level == 0u ? 0.0 : value;
}

// Adds a row of a block: `levels` has 3 bits for each of four columns; `ends` are the least value and the step to the powers 1, 2 and 4.
void add_levels(inout vec3 sum, uint levels, vec4 ends, Light light) {
    add(sum, level_value(levels & 7u, ends.x, ends.y, ends.z, ends.w), light.first);
    add(sum, level_value(levels >> 3u & 7u, ends.x, ends.y, ends.z, ends.w), light.second);
    add(sum, level_value(levels >> 6u & 7u, ends.x, ends.y, ends.z, ends.w), light.third);
    add(sum, level_value(levels >> 9u & 7u, ends.x, ends.y, ends.z, ends.w), light.fourth);
}

// Adds what a row has beside its blocks.
void add_residuals(inout vec3 sum, uint row, uint lane) {
    if (row >= push.data.count) {
        return;
    }
    uint stop = word(push.data.residual_offsets_at + row + 1u);
    for (uint at = word(push.data.residual_offsets_at + row) + lane; at < stop; at += LANES) {
        uint entry = word(push.data.residuals_at + at);
        precise float share = unpackHalf2x16(entry).y * push.data.residual_scale;
        add(sum, share, sent_by(entry & 0xffffu));
    }
}

void add_blocks(uint group, uint lane, inout Sums sums) {
    uint end = word(push.data.offsets_at + group + 1u);
    uint last = push.data.count - 1u;
    for (uint at = word(push.data.offsets_at + group) + lane; at < end; at += LANES) {
        uint low = word(push.data.blocks_at + 2u * at);
        uint high = word(push.data.blocks_at + 2u * at + 1u);
        uint pair = word(push.data.columns_at + at / 2u);
        uint column = 4u * ((at & 1u) == 0u ? pair & 0xffffu : pair >> 16u);
        float least = word_float(push.data.tables_at + (low & 255u));
        float step = word_float(push.data.tables_at + 256u + (low >> 8u & 255u));
        precise float twice = step * step;
        precise float four = twice * twice;
        vec4 ends = vec4(least, step, twice, four);
        // Beyond the last column all levels are 0.
        Light light = Light(
            sent_by(column), sent_by(min(column + 1u, last)), sent_by(min(column + 2u, last)), sent_by(min(column + 3u, last))
        );
        // Elements 0 to 4 lie in the lower half, 5 across both, the others in the upper one.
        add_levels(sums.first, low >> 16u, ends, light);
        add_levels(sums.second, low >> 28u | high << 4u, ends, light);
        add_levels(sums.third, high >> 8u, ends, light);
        add_levels(sums.fourth, high >> 20u, ends, light);
    }
    add_residuals(sums.first, 4u * group, lane);
    add_residuals(sums.second, 4u * group + 1u, lane);
    add_residuals(sums.third, 4u * group + 2u, lane);
    add_residuals(sums.fourth, 4u * group + 3u, lane);
}

float element(uint row, uint column) {
    if (MATRIX_PATH == PATH_SAMPLED) {
        return texelFetch(bounced_matrix_image, ivec2(column, row), 0).x;
    }
    return word_float(row * push.data.count + column);
}

void add_dense(uint group, uint lane, inout Sums sums) {
    uint last = push.data.count - 1u;
    for (uint column = lane; column < push.data.count; column += LANES) {
        vec3 sent = sent_by(column);
        add(sums.first, element(4u * group, column), sent);
        add(sums.second, element(min(4u * group + 1u, last), column), sent);
        add(sums.third, element(min(4u * group + 2u, last), column), sent);
        add(sums.fourth, element(min(4u * group + 3u, last), column), sent);
    }
}

// A step of the iteration for a patch, from what it gathers.
void finish(uint patch_id, vec3 sum) {
    vec3 gathered = GREY ? sum.xxx : sum;
    PatchLight old = before.data[patch_id];
    PatchData of = patches.data[patch_id];
    precise vec3 correction = push.data.step * (gathered - old.irradiance.rgb);
    precise vec3 change = (old.irradiance.rgb - old.previous.rgb) + correction;
    precise vec3 irradiance = push.data.weight * change + old.previous.rgb;
    precise vec3 exitance = old.first.rgb + of.reflectance * irradiance;
    precise vec3 sent = exitance * of.area;
    after.data[patch_id] = PatchLight(vec4(irradiance, 0.0), old.irradiance, vec4(sent, 0.0), old.first);
}

void main() {
    uint group = gl_WorkGroupID.y * MOST_GROUPS + gl_WorkGroupID.x;
    uint lane = gl_LocalInvocationID.x;
    if (THREAD_ROWS) {
        uint row = group * LANES + lane;
        precise vec3 sum = vec3(0.0);
        for (uint column = 0u; row < push.data.count && column < push.data.count; ++column) {
            add(sum, element(row, column), before.data[column].sent.rgb);
        }
        if (row < push.data.count) {
            finish(row, sum);
        }
        return;
    }
    Sums sums = Sums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    if (4u * group < push.data.count) {
        if (CODEC == CODEC_DENSE) {
            add_dense(group, lane, sums);
        } else {
            add_blocks(group, lane, sums);
        }
    }
    vec3 sum = over_threads(sums, lane);
    if (lane < 4u && 4u * group + lane < push.data.count) {
        finish(4u * group + lane, sum);
    }
}
