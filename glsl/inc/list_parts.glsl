// This pass's share of the sum over a list of lights. Comes after shade_list.glsl.
#include "light_parts.glsl"

// Lights begin to end of the list; the first pass adds those that every sample adds, too.
vec4 shade_list_part(Surface s, uint begin, uint end) {
    if (s.unlit) {
        return unlit_part(s);
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    vec4 before = sum_before(s);
    precise vec3 sum = before.rgb;
    if (FIRST_PART) {
        sum = add_unlisted_lights(sum, lobes, s, v);
    }
    uint from = begin + min(uint(before.a), end - begin);
    uint until = from + min(PART_LIGHTS, end - from);
    sum = add_listed_lights(sum, lobes, s, v, from, until);
    return sum_after(s, sum, until - begin);
}

// Every light on a surface that no list knows: between the samples of a pixel, a position may lie where no sample does.
vec4 shade_unlisted(Surface s) {
    if (s.unlit) {
        return unlit_part(s);
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    precise vec3 sum = base_radiance(s);
    sum = add_lights(sum, lobes, s, v, 0u, frame.data.light_count);
    return sum_after(s, sum, frame.data.light_count);
}
