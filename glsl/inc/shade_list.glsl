// The sum over a list of lights in id order, after those that every sample adds: what shade_all_lights adds, without the zeros.
#include "shade.glsl"

layout(constant_id = 21) const uint LIST_FETCH = WORDS_TEXEL;
// As LIGHT_SEEK, for lists: pays where many listed lights do not reach the sample.
layout(constant_id = 22) const bool LIST_SEEK = true;

layout(set = 0, binding = 6, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 7, scalar) readonly buffer ListOffsets { uint data[]; } list_offsets_storage;
layout(set = 0, binding = 8, scalar) readonly buffer ListLights { uint data[]; } list_lights_storage;
layout(set = 0, binding = 9) uniform usamplerBuffer list_lights_texel;
layout(set = 0, binding = 10) uniform usamplerBuffer list_offsets_texel;

uint list_light(uint at) {
    if (LIST_FETCH == WORDS_STORAGE) {
        return list_lights_storage.data[at];
    }
    return texelFetch(list_lights_texel, int(at)).x;
}

uint list_offset(uint at) {
    if (LIST_FETCH == WORDS_STORAGE) {
        return list_offsets_storage.data[at];
    }
    return texelFetch(list_offsets_texel, int(at)).x;
}

// Lights that no list holds, because every sample adds them, on top of what is added up already.
vec3 add_unlisted_lights(vec3 before, Lobes lobes, Surface s, vec3 v) {
    return add_directional_lights(before, lobes, s, v, 0u, grid.data.first_light);
}

// Place behind the last light of a list that has a shadow: in the order of ids these come first.
uint add_shadowed_lights(inout vec3 sum, Lobes lobes, Surface s, vec3 v, uint begin, uint end) {
    if ((SHADOW_KINDS & ~KIND_DIRECTIONAL) == 0u) {
        return begin;
    }
    uint shadowed = shadow_runs().z;
    uint at = begin;
    while (at < end && list_light(at) < shadowed) {
        precise vec3 added = sum + shade_shadowed_light(load_light(list_light(at)), lobes, s, v);
        sum = added;
        ++at;
    }
    return at;
}

// Lights begin to end of the list, likewise.
vec3 add_listed_lights(vec3 before, Lobes lobes, Surface s, vec3 v, uint begin, uint end) {
    precise vec3 sum = before;
    if (LIGHT_KINDS == 0u) {
        return sum;
    }
    begin = add_shadowed_lights(sum, lobes, s, v, begin, end);
    if (!LIST_SEEK) {
        for (uint at = begin; at < end; ++at) {
            sum += shade_light(list_light(at), lobes, s, v);
        }
        return sum;
    }
    for (uint base = begin; base < end; base += 32u) {
        uint reaching = 0u;
        uint count = min(end - base, 32u);
        for (uint i = 0u; i < count; ++i) {
            bool outside = light_out_of_range(light_texel(list_light(base + i) * LIGHT_TEXELS), s.position);
            reaching |= outside ? 0u : 1u << i;
        }
        while (reaching != 0u) {
            uint i = base + uint(findLSB(reaching));
            reaching &= reaching - 1u;
            sum += shade_light(list_light(i), lobes, s, v);
        }
    }
    return sum;
}

// Lights begin to end of the list, and those that every sample adds.
vec3 shade_listed_lights(Surface s, uint begin, uint end) {
    if (s.unlit) {
        return min(s.base_color, MAX_RADIANCE);
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    precise vec3 sum = base_radiance(s);
    sum = add_unlisted_lights(sum, lobes, s, v);
    sum = add_listed_lights(sum, lobes, s, v, begin, end);
    return min(sum, MAX_RADIANCE);
}

// A sample and its sum.
struct Lit {
    Surface s;
    vec3 v;
    Lobes lobes;
    vec3 sum;
};

// Without a light.
Lit begin_lit(Surface s) {
    vec3 v = view_direction(s);
    return Lit(s, v, make_lobes(s, v), base_radiance(s));
}

#define ADD_TO_FOUR(NAME, SHADE) \
void NAME(LoadedLight light, inout Lit a, inout Lit b, inout Lit c, inout Lit d) { \
    precise vec3 sum_a = a.sum + SHADE(light, a.lobes, a.s, a.v); \
    precise vec3 sum_b = b.sum + SHADE(light, b.lobes, b.s, b.v); \
    precise vec3 sum_c = c.sum + SHADE(light, c.lobes, c.s, c.v); \
    precise vec3 sum_d = d.sum + SHADE(light, d.lobes, d.s, d.v); \
    a.sum = sum_a; \
    b.sum = sum_b; \
    c.sum = sum_c; \
    d.sum = sum_d; \
}

ADD_TO_FOUR(add_light_to_four, shade_loaded_light)
ADD_TO_FOUR(add_shadowed_light_to_four, shade_shadowed_light)

// The lights that every sample adds, and begin to end of a list that four samples share: place and intensity of each light are read once
// for all of them, and each sum is the one that shade_listed_lights makes. As many iterations as that takes, not four times as many.
void shade_four(inout Lit a, inout Lit b, inout Lit c, inout Lit d, uint begin, uint end) {
    if (LIGHT_KINDS == 0u) {
        return;
    }
    uvec3 runs = uvec3(0u);
    if (SHADOW_KINDS != 0u) {
        runs = shadow_runs();
    }
    if ((LIGHT_KINDS & KIND_DIRECTIONAL) != 0u) {
        if ((SHADOW_KINDS & KIND_DIRECTIONAL) != 0u) {
            for (uint i = 0u; i < runs.x; ++i) {
                add_shadowed_light_to_four(load_light(i), a, b, c, d);
            }
        }
        for (uint i = runs.x; i < grid.data.first_light; ++i) {
            add_light_to_four(load_light(i), a, b, c, d);
        }
    }
    uint at = begin;
    if ((SHADOW_KINDS & ~KIND_DIRECTIONAL) != 0u) {
        while (at < end && list_light(at) < runs.z) {
            add_shadowed_light_to_four(load_light(list_light(at)), a, b, c, d);
            ++at;
        }
    }
    for (; at < end; ++at) {
        add_light_to_four(load_light(list_light(at)), a, b, c, d);
    }
}
