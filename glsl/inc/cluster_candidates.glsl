// Candidates from the list of a cluster's tile.
layout(constant_id = 21) const uint LIST_FETCH = WORDS_TEXEL;

layout(set = 0, binding = 3, scalar) readonly buffer TileLights { uint data[]; } tile_lights_storage;
layout(set = 0, binding = 4) uniform usamplerBuffer tile_lights_texel;

// Id of a light in the list of a tile.
uint tile_light(uint at) {
    if (LIST_FETCH == WORDS_STORAGE) {
        return tile_lights_storage.data[at];
    }
    return texelFetch(tile_lights_texel, int(at)).x;
}
