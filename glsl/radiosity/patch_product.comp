#version 460
#extension GL_GOOGLE_include_directive : require
// Bounced light of all patches in one product with bounces that were summed beforehand: a group for four rows, its threads take blocks of four columns
// in turn, then elements that are kept apart, and add up their sums halves onto halves. CPU twin: radiosity/codec/coded.rs; what words of blocks mean,
// radiosity/codec/block.rs.
#include "base.glsl"

layout(constant_id = 0) const uint CODEC = CODEC_BC1;
// Threads of a group: as many as the device runs in step (GROUP_SIZE).
layout(local_size_x_id = 3) in;
const uint LANES = gl_WorkGroupSize.x;

// Only what changed is sent, and added to what is known: columns that send nothing are passed over.
layout(constant_id = 5) const bool COLUMNS = false;

layout(set = 0, binding = 2, scalar) readonly buffer BeforeBlock { PatchLight data[]; } before;
layout(set = 0, binding = 3, scalar) writeonly buffer AfterBlock { PatchLight data[]; } after;

#include "matrix.glsl"

layout(set = 0, binding = 6) uniform samplerBuffer bounced_sent;

layout(push_constant, scalar) uniform Push { ProductPush data; } push;

shared vec3 sums[4][LANES];

// Exitance that the column at a position sends at first, or by how much that changed.
vec3 sent(uint position) {
    return position < push.data.count ? texelFetch(bounced_sent, int(word(push.data.columns_at + position) * BOUNCED_LIGHT_TEXELS + (COLUMNS ? 2u : 3u))).rgb : vec3(0.0);
}

vec3 table_value(uvec3 codes) {
    uint at = push.data.tables_at;
    return vec3(word_float(at + codes.r), word_float(at + 256u + codes.g), word_float(at + 512u + codes.b));
}

// 8-bit codes of an end of 5:6:5 bits.
uvec3 end_codes(uint bits) {
    uvec3 end = uvec3(bits >> 11u & 31u, bits >> 5u & 63u, bits & 31u);
    return uvec3(end.r << 3u | end.r >> 2u, end.g << 2u | end.g >> 4u, end.b << 3u | end.b >> 2u);
}

void add(inout vec3 sum, vec3 element, vec3 light) {
    precise vec3 product = element * light;
    precise vec3 added = sum + product;
    sum = added;
}

// A block of BC1 (Khronos Data Format Specification 1.3, section 18.1), decoded in integers.
void add_bc1(uvec2 block, uint column, inout vec3 gathered[4]) {
    uint first = block.x & 0xffffu;
    uint second = block.x >> 16u;
    uvec3 a = end_codes(first);
    uvec3 b = end_codes(second);
    vec3 palette[4];
    palette[0] = table_value(a);
    palette[1] = table_value(b);
    if (first > second) {
        palette[2] = table_value((2u * a + b + 1u) / 3u);
        palette[3] = table_value((2u * b + a + 1u) / 3u);
    } else {
        palette[2] = table_value((a + b + 1u) / 2u);
        palette[3] = table_value(uvec3(0u));
    }
    for (uint across = 0u; across < 4u; ++across) {
        vec3 light = sent(4u * column + across);
        for (uint down = 0u; down < 4u; ++down) {
            add(gathered[down], palette[block.y >> (2u * (4u * down + across)) & 3u], light);
        }
    }
}

// Code of a level between the ends of a block of BC4 (section 19.1).
uint bc4_level(uint a, uint b, uint index) {
    if (index < 2u) {
        return index == 0u ? a : b;
    }
    uint k = index - 1u;
    if (a > b) {
        return ((7u - k) * a + k * b + 3u) / 7u;
    }
    if (index > 5u) {
        return index == 6u ? 0u : 255u;
    }
    return ((5u - k) * a + k * b + 2u) / 5u;
}

vec3 ratios(uint chroma) {
    float red = word_float(push.data.tables_at + 256u + (chroma & 255u));
    float blue = word_float(push.data.tables_at + 512u + (chroma >> 8u));
    precise float rest = 3.0 - red;
    precise float green = rest - blue;
    return vec3(red, max(green, 0.0), blue);
}

void add_bc4(uvec2 block, uint chroma, uint column, inout vec3 gathered[4]) {
    uint a = block.x & 255u;
    uint b = block.x >> 8u & 255u;
    float levels[8];
    for (uint index = 0u; index < 8u; ++index) {
        levels[index] = word_float(push.data.tables_at + bc4_level(a, b, index));
    }
    vec3 ratio = ratios(chroma);
    // Rows of indices: 12 bits each.
    uint rows[4];
    rows[0] = block.x >> 16u;
    rows[1] = block.x >> 28u | block.y << 4u;
    rows[2] = block.y >> 8u;
    rows[3] = block.y >> 20u;
    for (uint across = 0u; across < 4u; ++across) {
        vec3 light = sent(4u * column + across);
        for (uint down = 0u; down < 4u; ++down) {
            precise vec3 element = levels[rows[down] >> (3u * across) & 7u] * ratio;
            add(gathered[down], element, light);
        }
    }
}

// What the image holds of a block: codes as a sampler interpolates them, to the nearest.
void add_sampled(uint row, uint column, uint chroma, inout vec3 gathered[4]) {
    vec3 ratio = CODEC == CODEC_BC4_CHROMA ? ratios(chroma) : vec3(1.0);
    int last = int(push.data.count) - 1;
    for (uint across = 0u; across < 4u; ++across) {
        vec3 light = sent(4u * column + across);
        for (uint down = 0u; down < 4u; ++down) {
            ivec2 texel = min(ivec2(4u * column + across, 4u * row + down), ivec2(last));
            uvec3 codes = uvec3(texelFetch(bounced_matrix_image, texel, 0).rgb * 255.0 + 0.5);
            if (CODEC == CODEC_BC4_CHROMA) {
                precise vec3 element = word_float(push.data.tables_at + codes.r) * ratio;
                add(gathered[down], element, light);
            } else {
                add(gathered[down], table_value(codes), light);
            }
        }
    }
}

// Columns from this position on send nothing, so many of them.
bool are_dark(uint position, uint count) {
    for (uint k = 0u; k < count; ++k) {
        if (any(notEqual(sent(position + k), vec3(0.0)))) {
            return false;
        }
    }
    return true;
}

void add_blocks(uint row, uint lane, inout vec3 gathered[4]) {
    uint side = (push.data.count + 3u) / 4u;
    for (uint column = lane; column < side; column += LANES) {
        if (COLUMNS && are_dark(4u * column, 4u)) {
            continue;
        }
        uint number = row * side + column;
        if (CODEC != CODEC_THESIS) {
            // Blocks of nothing but zeros are not stored: a bit each, and counts before each word of bits.
            uint mask = word(push.data.mask_at + number / 32u);
            uint bit = 1u << (number % 32u);
            if ((mask & bit) == 0u) {
                continue;
            }
            number = word(push.data.counts_at + number / 32u) + uint(bitCount(mask & (bit - 1u)));
        }
        uint chroma = 0u;
        if (CODEC == CODEC_BC4_CHROMA) {
            chroma = word(push.data.chroma_at + number / 2u) >> (16u * (number & 1u)) & 0xffffu;
        }
        if (MATRIX_PATH == PATH_SAMPLED) {
            add_sampled(row, column, chroma, gathered);
            continue;
        }
        uvec2 block = uvec2(word(push.data.blocks_at + 2u * number), word(push.data.blocks_at + 2u * number + 1u));
        if (CODEC == CODEC_BC4_CHROMA) {
            add_bc4(block, chroma, column, gathered);
        } else {
            add_bc1(block, column, gathered);
        }
    }
}

// Elements that are kept apart, 16 bits a channel, in turn.
void add_residuals(uint row, uint lane, inout vec3 sum) {
    uint begin = word(push.data.offsets_at + row);
    uint end = word(push.data.offsets_at + row + 1u);
    for (uint at = begin + lane; at < end; at += LANES) {
        uint low = word(push.data.apart_at + 2u * at);
        uint high = word(push.data.apart_at + 2u * at + 1u);
        precise vec3 element = vec3(unpackHalf2x16(low).y, unpackHalf2x16(high)) * push.data.scale;
        add(sum, element, sent(low & 0xffffu));
    }
}

// The same in the thesis' form: a list a channel, in 32 bits.
void add_apart(uint row, uint lane, inout vec3 sum) {
    for (uint channel = 0u; channel < 3u; ++channel) {
        uint list = push.data.offsets_at + channel * (push.data.count + 1u) + row;
        uint begin = word(list);
        uint end = word(list + 1u);
        for (uint at = begin + lane; at < end; at += LANES) {
            uint column = word(push.data.apart_at + at / 2u) >> (16u * (at & 1u)) & 0xffffu;
            precise float product = word_float(push.data.values_at + at) * sent(column)[channel];
            precise float added = sum[channel] + product;
            sum[channel] = added;
        }
    }
}

// Every element of four rows: threads take pairs of columns in turn.
void add_halves(uint row, uint lane, inout vec3 gathered[4]) {
    uint row_words = (push.data.count + 1u) / 2u;
    for (uint pair = lane; pair < row_words; pair += LANES) {
        if (COLUMNS && are_dark(2u * pair, 2u)) {
            continue;
        }
        vec3 left = sent(2u * pair);
        vec3 right = sent(2u * pair + 1u);
        for (uint down = 0u; down < 4u; ++down) {
            uint at = min(4u * row + down, push.data.count - 1u);
            vec2 of[3];
            for (uint channel = 0u; channel < 3u; ++channel) {
                of[channel] = unpackHalf2x16(word(push.data.blocks_at + (channel * push.data.count + at) * row_words + pair));
            }
            precise vec3 first = vec3(of[0].x, of[1].x, of[2].x) * push.data.scale;
            add(gathered[down], first, left);
            if (2u * pair + 1u < push.data.count) {
                precise vec3 second = vec3(of[0].y, of[1].y, of[2].y) * push.data.scale;
                add(gathered[down], second, right);
            }
        }
    }
}

void main() {
    uint row = gl_WorkGroupID.y * MOST_GROUPS + gl_WorkGroupID.x;
    uint lane = gl_LocalInvocationID.x;
    vec3 gathered[4] = vec3[4](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    if (4u * row < push.data.count) {
        if (CODEC == CODEC_HALF) {
            add_halves(row, lane, gathered);
        } else {
            add_blocks(row, lane, gathered);
            for (uint down = 0u; down < min(4u, push.data.count - 4u * row); ++down) {
                if (CODEC == CODEC_THESIS) {
                    add_apart(4u * row + down, lane, gathered[down]);
                } else {
                    add_residuals(4u * row + down, lane, gathered[down]);
                }
            }
        }
    }
    for (uint down = 0u; down < 4u; ++down) {
        sums[down][lane] = gathered[down];
    }
    for (uint width = LANES >> 1u; width > 0u; width /= 2u) {
        barrier();
        if (lane < width) {
            for (uint down = 0u; down < 4u; ++down) {
                precise vec3 sum = sums[down][lane] + sums[down][lane + width];
                sums[down][lane] = sum;
            }
        }
    }
    barrier();
    if (lane >= 4u || 4u * row + lane >= push.data.count) {
        return;
    }
    uint patch_id = word(push.data.rows_at + 4u * row + lane);
    precise vec3 irradiance = sums[lane][0];
    if (CODEC == CODEC_THESIS) {
        uint at = push.data.scales_at + 3u * patch_id;
        irradiance *= vec3(word_float(at), word_float(at + 1u), word_float(at + 2u));
    }
    if (COLUMNS) {
        irradiance += before.data[patch_id].irradiance.rgb;
    }
    after.data[patch_id] = PatchLight(vec4(irradiance, 0.0), vec4(0.0), vec4(0.0), before.data[patch_id].first);
}
