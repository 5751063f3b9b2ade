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

#include "sums.glsl"

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

Light light_of(uint column) {
    return Light(sent(4u * column), sent(4u * column + 1u), sent(4u * column + 2u), sent(4u * column + 3u));
}

// Colours of a block, by their index.
struct Palette {
    vec3 first;
    vec3 second;
    vec3 third;
    vec3 fourth;
};

vec3 bc1_value(uint index, Palette palette) {
    vec3 low = (index & 1u) != 0u ? palette.second : palette.first;
    vec3 high = (index & 1u) != 0u ? palette.fourth : palette.third;
    return (index & 2u) != 0u ? high : low;
}

void add_bc1_row(inout vec3 sum, uint indices, Palette palette, Light light) {
    add(sum, bc1_value(indices, palette), light.first);
    add(sum, bc1_value(indices >> 2u, palette), light.second);
    add(sum, bc1_value(indices >> 4u, palette), light.third);
    add(sum, bc1_value(indices >> 6u, palette), light.fourth);
}

// A block of BC1 (Khronos Data Format Specification 1.3, section 18.1), decoded in integers.
void add_bc1(uvec2 block, uint column, inout Sums sums) {
    uint first = block.x & 0xffffu;
    uint second = block.x >> 16u;
    uvec3 from = end_codes(first);
    uvec3 to = end_codes(second);
    // Four colours, or three and black.
    bool four = first > second;
    vec3 third = table_value(four ? (2u * from + to + 1u) / 3u : (from + to + 1u) / 2u);
    vec3 fourth = table_value(four ? (2u * to + from + 1u) / 3u : uvec3(0u));
    Palette palette = Palette(table_value(from), table_value(to), third, fourth);
    Light light = light_of(column);
    add_bc1_row(sums.first, block.y, palette, light);
    add_bc1_row(sums.second, block.y >> 8u, palette, light);
    add_bc1_row(sums.third, block.y >> 16u, palette, light);
    add_bc1_row(sums.fourth, block.y >> 24u, palette, light);
}

// Code k steps on from the first end of a block of BC4 to the second, of seven or of five (section 19.1).
uint bc4_code(uvec2 ends, uint k) {
    uint seven = ((7u - k) * ends.x + k * ends.y + 3u) / 7u;
    uint five = ((5u - k) * ends.x + k * ends.y + 2u) / 5u;
    return ends.x > ends.y ? seven : five;
}

vec3 ratios(uint chroma) {
    float red = word_float(push.data.tables_at + 256u + (chroma & 255u));
    float blue = word_float(push.data.tables_at + 512u + (chroma >> 8u));
    precise float rest = 3.0 - red;
    precise float green = rest - blue;
    return vec3(red, max(green, 0.0), blue);
}

// Of eight levels that of an index of 3 bits, as a colour.
vec3 bc4_value(uint index, vec4 low, vec4 high, vec3 ratio) {
    bool odd = (index & 1u) != 0u;
    float first = odd ? low.y : low.x;
    float second = odd ? low.w : low.z;
    float third = odd ? high.y : high.x;
    float fourth = odd ? high.w : high.z;
    bool upper = (index & 2u) != 0u;
    float before = upper ? second : first;
    float behind = upper ? fourth : third;
    float level = (index & 4u) != 0u ? behind : before;
    precise vec3 element = level * ratio;
    return element;
}

void add_bc4_row(inout vec3 sum, uint indices, vec4 low, vec4 high, vec3 ratio, Light light) {
    add(sum, bc4_value(indices, low, high, ratio), light.first);
    add(sum, bc4_value(indices >> 3u, low, high, ratio), light.second);
    add(sum, bc4_value(indices >> 6u, low, high, ratio), light.third);
    add(sum, bc4_value(indices >> 9u, low, high, ratio), light.fourth);
}

float level_value(uint code) {
    return word_float(push.data.tables_at + code);
}

void add_bc4(uvec2 block, uint chroma, uint column, inout Sums sums) {
    uvec2 ends = uvec2(block.x, block.x >> 8u) & 255u;
    // Of six levels the last two are the ends of the scale.
    uvec2 last = ends.x > ends.y ? uvec2(bc4_code(ends, 5u), bc4_code(ends, 6u)) : uvec2(0u, 255u);
    vec4 low = vec4(level_value(ends.x), level_value(ends.y), level_value(bc4_code(ends, 1u)), level_value(bc4_code(ends, 2u)));
    vec4 high = vec4(level_value(bc4_code(ends, 3u)), level_value(bc4_code(ends, 4u)), level_value(last.x), level_value(last.y));
    vec3 ratio = ratios(chroma);
    Light light = light_of(column);
    // Rows of indices: 12 bits each.
    add_bc4_row(sums.first, block.x >> 16u, low, high, ratio, light);
    add_bc4_row(sums.second, block.x >> 28u | block.y << 4u, low, high, ratio, light);
    add_bc4_row(sums.third, block.y >> 8u, low, high, ratio, light);
    add_bc4_row(sums.fourth, block.y >> 20u, low, high, ratio, light);
}

// What the image holds of an element: codes as a sampler interpolates them, to the nearest.
vec3 sampled_value(uint row, uint column, vec3 ratio) {
    ivec2 texel = min(ivec2(column, row), ivec2(push.data.count) - 1);
    uvec3 codes = uvec3(texelFetch(bounced_matrix_image, texel, 0).rgb * 255.0 + 0.5);
    if (CODEC == CODEC_BC4_CHROMA) {
        precise vec3 element = word_float(push.data.tables_at + codes.r) * ratio;
        return element;
    }
    return table_value(codes);
}

void add_sampled_row(inout vec3 sum, uint row, uint column, vec3 ratio, Light light) {
    add(sum, sampled_value(row, 4u * column, ratio), light.first);
    add(sum, sampled_value(row, 4u * column + 1u, ratio), light.second);
    add(sum, sampled_value(row, 4u * column + 2u, ratio), light.third);
    add(sum, sampled_value(row, 4u * column + 3u, ratio), light.fourth);
}

void add_sampled(uint group, uint column, uint chroma, inout Sums sums) {
    vec3 ratio = CODEC == CODEC_BC4_CHROMA ? ratios(chroma) : vec3(1.0);
    Light light = light_of(column);
    add_sampled_row(sums.first, 4u * group, column, ratio, light);
    add_sampled_row(sums.second, 4u * group + 1u, column, ratio, light);
    add_sampled_row(sums.third, 4u * group + 2u, column, ratio, light);
    add_sampled_row(sums.fourth, 4u * group + 3u, column, ratio, light);
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

void add_blocks(uint group, uint lane, inout Sums sums) {
    uint side = (push.data.count + 3u) / 4u;
    for (uint column = lane; column < side; column += LANES) {
        if (COLUMNS && are_dark(4u * column, 4u)) {
            continue;
        }
        uint number = group * side + column;
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
            add_sampled(group, column, chroma, sums);
            continue;
        }
        uvec2 block = uvec2(word(push.data.blocks_at + 2u * number), word(push.data.blocks_at + 2u * number + 1u));
        if (CODEC == CODEC_BC4_CHROMA) {
            add_bc4(block, chroma, column, sums);
        } else {
            add_bc1(block, column, sums);
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
void add_apart(uint row, uint lane, uint channel, inout float sum) {
    uint list = push.data.offsets_at + channel * (push.data.count + 1u) + row;
    uint end = word(list + 1u);
    for (uint at = word(list) + lane; at < end; at += LANES) {
        uint column = word(push.data.apart_at + at / 2u) >> (16u * (at & 1u)) & 0xffffu;
        precise float product = word_float(push.data.values_at + at) * sent(column)[channel];
        precise float added = sum + product;
        sum = added;
    }
}

// What a row has beside its blocks.
void add_beside(uint row, uint lane, inout vec3 sum) {
    if (row >= push.data.count) {
        return;
    }
    if (CODEC == CODEC_THESIS) {
        add_apart(row, lane, 0u, sum.r);
        add_apart(row, lane, 1u, sum.g);
        add_apart(row, lane, 2u, sum.b);
    } else {
        add_residuals(row, lane, sum);
    }
}

// Two columns of a row.
void add_pair(inout vec3 sum, uint row, uint pair, vec3 left, vec3 right) {
    uint row_words = (push.data.count + 1u) / 2u;
    uint at = push.data.blocks_at + min(row, push.data.count - 1u) * row_words + pair;
    uint channel_words = push.data.count * row_words;
    vec2 red = unpackHalf2x16(word(at));
    vec2 green = unpackHalf2x16(word(at + channel_words));
    vec2 blue = unpackHalf2x16(word(at + 2u * channel_words));
    precise vec3 first = vec3(red.x, green.x, blue.x) * push.data.scale;
    precise vec3 second = vec3(red.y, green.y, blue.y) * push.data.scale;
    add(sum, first, left);
    // Beyond the last column it is nothing that nothing sends.
    add(sum, second, right);
}

// Every element of four rows: threads take pairs of columns in turn.
void add_halves(uint group, uint lane, inout Sums sums) {
    uint row_words = (push.data.count + 1u) / 2u;
    for (uint pair = lane; pair < row_words; pair += LANES) {
        if (COLUMNS && are_dark(2u * pair, 2u)) {
            continue;
        }
        vec3 left = sent(2u * pair);
        vec3 right = sent(2u * pair + 1u);
        add_pair(sums.first, 4u * group, pair, left, right);
        add_pair(sums.second, 4u * group + 1u, pair, left, right);
        add_pair(sums.third, 4u * group + 2u, pair, left, right);
        add_pair(sums.fourth, 4u * group + 3u, pair, left, right);
    }
}

void main() {
    uint group = gl_WorkGroupID.y * MOST_GROUPS + gl_WorkGroupID.x;
    uint lane = gl_LocalInvocationID.x;
    Sums sums = Sums(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    if (4u * group < push.data.count) {
        if (CODEC == CODEC_HALF) {
            add_halves(group, lane, sums);
        } else {
            add_blocks(group, lane, sums);
            add_beside(4u * group, lane, sums.first);
            add_beside(4u * group + 1u, lane, sums.second);
            add_beside(4u * group + 2u, lane, sums.third);
            add_beside(4u * group + 3u, lane, sums.fourth);
        }
    }
    precise vec3 irradiance = over_threads(sums, lane);
    if (lane >= 4u || 4u * group + lane >= push.data.count) {
        return;
    }
    uint patch_id = word(push.data.rows_at + 4u * group + lane);
    if (CODEC == CODEC_THESIS) {
        uint at = push.data.scales_at + 3u * patch_id;
        irradiance *= vec3(word_float(at), word_float(at + 1u), word_float(at + 2u));
    }
    if (COLUMNS) {
        irradiance += before.data[patch_id].irradiance.rgb;
    }
    after.data[patch_id] = PatchLight(vec4(irradiance, 0.0), vec4(0.0), vec4(0.0), before.data[patch_id].first);
}
