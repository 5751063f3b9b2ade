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
