// Lights to cull (CULL_TEXELS), by texel where they fit and from storage where they do not.
layout(constant_id = 20) const uint CULL_FETCH = WORDS_TEXEL;

layout(set = 0, binding = 1, scalar) readonly buffer CullLightStorage { vec4 texels[]; } cull_lights_storage;
layout(set = 0, binding = 2) uniform samplerBuffer cull_lights_texel;

vec4 cull_texel(uint index) {
    if (CULL_FETCH == WORDS_STORAGE) {
        return cull_lights_storage.texels[index];
    }
    return texelFetch(cull_lights_texel, int(index));
}

// A light touches any tile of the bin: integer rectangles against each other.
bool in_bin(uvec2 bin, uint light) {
    vec4 tiles = cull_texel(light * CULL_TEXELS + 2u);
    vec2 first = vec2(bin * BIN_TILES);
    vec2 last = first + float(BIN_TILES - 1u);
    return tiles.x <= last.x && tiles.y >= first.x && tiles.z <= last.y && tiles.w >= first.y && tiles.x <= tiles.y
        && tiles.z <= tiles.w;
}
