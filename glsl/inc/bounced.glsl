// Bounced light at a place of a surface, mixed from the patches about it. CPU twin: radiosity/transfer.rs, which says what the words mean.
layout(constant_id = 38) const bool BOUNCED = false;
// Words are read from a storage buffer: there are more than a texel buffer holds.
layout(constant_id = 39) const bool BOUNCED_STORAGE = false;

layout(set = 0, binding = 42) uniform samplerBuffer bounced_places;
layout(set = 0, binding = 43) uniform usamplerBuffer bounced_words;
layout(set = 0, binding = 45, scalar) readonly buffer BouncedWords { uint data[]; } bounced_words_storage;
layout(set = 0, binding = 44) uniform samplerBuffer bounced_light;

uint bounced_word(uint at) {
    if (BOUNCED_STORAGE) {
        return bounced_words_storage.data[at];
    }
    return texelFetch(bounced_words, int(at)).x;
}

// The list of patches for a place and the side it looks to.
uint bounced_list(uint record, uint side, vec3 place) {
    uint list = bounced_word(record + side);
    for (uint plane = 0u; plane < BOUNCED_PLANES; ++plane) {
        if (bounced_word(list) != BOUNCED_PARTED) {
            break;
        }
        vec3 across = vec3(uintBitsToFloat(bounced_word(list + 1u)), uintBitsToFloat(bounced_word(list + 2u)), uintBitsToFloat(bounced_word(list + 3u)));
        bool before = dot(across, place) + uintBitsToFloat(bounced_word(list + 4u)) >= 0.0;
        list = bounced_word(list + (before ? 6u : 5u));
    }
    return list;
}

// Lux by channel.
vec3 bounced_irradiance(vec3 position, vec3 normal) {
    vec4 x = texelFetch(bounced_places, 0);
    vec4 y = texelFetch(bounced_places, 1);
    vec4 z = texelFetch(bounced_places, 2);
    vec4 grid = texelFetch(bounced_places, 3);
    float cell = texelFetch(bounced_places, 4).x;
    vec3 place = vec3(dot(x.xyz, position) + x.w, dot(y.xyz, position) + y.w, dot(z.xyz, position) + z.w);
    vec3 looks = vec3(dot(x.xyz, normal), dot(y.xyz, normal), dot(z.xyz, normal)) * cell;
    uvec3 at = uvec3(clamp(place, vec3(0.0), grid.xyz - 1.0));
    uint record = bounced_word((at.z * uint(grid.y) + at.y) * uint(grid.x) + at.x);
    if (record == 0u) {
        return vec3(0.0);
    }
    uint list = bounced_list(record, axis_side(looks), place);
    uint count = bounced_word(list);
    precise vec3 sum = vec3(0.0);
    precise float weights = 0.0;
    for (uint i = 1u; i <= count; ++i) {
        uint patch_id = bounced_word(list + i);
        vec4 center = texelFetch(bounced_places, int(BOUNCED_HEAD_TEXELS + BOUNCED_PATCH_TEXELS * patch_id));
        vec4 faces = texelFetch(bounced_places, int(BOUNCED_HEAD_TEXELS + BOUNCED_PATCH_TEXELS * patch_id + 1u));
        vec3 way = (center.xyz - place) / grid.w;
        float near = max(1.0 - dot(way, way), 0.0);
        float alike = max(dot(faces.xyz, looks), 0.0);
        alike *= alike;
        precise float weight = center.w * (near * near + BOUNCED_LEAST) * (alike * alike + BOUNCED_LEAST);
        sum += weight * max(texelFetch(bounced_light, int(patch_id * BOUNCED_LIGHT_TEXELS)).rgb, 0.0);
        weights += weight;
    }
    return weights > 0.0 ? sum / weights : vec3(0.0);
}

// What a surface sends out of it: Lambert's law, whatever the shading model.
vec3 bounced_radiance(Surface s) {
    if (!BOUNCED) {
        return vec3(0.0);
    }
    precise vec3 sent = bounced_irradiance(s.position, s.normal) * s.base_color * ((1.0 - s.metallic) * (1.0 / PI));
    return sent;
}

// What a surface sends out without any light of the table.
vec3 base_radiance(Surface s) {
    precise vec3 sum = unlit_radiance(s) + bounced_radiance(s);
    return sum;
}
