// Words of a matrix, by the planned path.
layout(constant_id = 1) const uint MATRIX_PATH = PATH_BUFFER;

layout(set = 0, binding = 0, scalar) readonly buffer OperatorBlock { uint data[]; } words;
layout(set = 0, binding = 4) uniform usamplerBuffer bounced_matrix_texels;
layout(set = 0, binding = 5) uniform sampler2D bounced_matrix_image;

uint word(uint at) {
    if (MATRIX_PATH == PATH_TEXEL) {
        return texelFetch(bounced_matrix_texels, int(at)).x;
    }
    return words.data[at];
}

float word_float(uint at) {
    return uintBitsToFloat(word(at));
}
