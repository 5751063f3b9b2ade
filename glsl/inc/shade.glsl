// One light on one surface, and the sum over all of them in light-id order (f32, stored once). CPU twin: reference/shade.rs.
#include "lights.glsl"
#include "brdf.glsl"
#include "shadow.glsl"
#include "bounced.glsl"

// What rounding to f32 took from the light's position.
vec3 light_remainder(uint packed_bits) {
    const uint mask = (1u << REMAINDER_BITS) - 1u;
    uvec3 steps = uvec3(packed_bits, packed_bits >> REMAINDER_BITS, packed_bits >> (2u * REMAINDER_BITS)) & mask;
    return (vec3(steps) - float(REMAINDER_BIAS)) * frame.data.light_remainder_step;
}

uint light_kind(uint packed_bits) {
    const bool one_kind = LIGHT_KINDS == KIND_POINT || LIGHT_KINDS == KIND_SPOT || LIGHT_KINDS == KIND_DIRECTIONAL;
    return one_kind ? LIGHT_KINDS : packed_bits >> (3u * REMAINDER_BITS);
}

// Squared distance over squared range from the rounded position alone; the plan's limit is wide enough that a light is stepped
// over only where its window is exactly 0.
bool light_out_of_range(vec4 place, vec3 position) {
    vec3 l = place.xyz - position;
    return dot(l, l) * place.w > frame.data.light_seek_limit;
}

// What one light is, apart from what it lights: several samples may share one reading.
struct LoadedLight {
    vec4 place;
    vec3 intensity;
    vec3 remainder;
    uint kind;
    uint first_texel;
};

LoadedLight load_light(uint index) {
    uint first = index * LIGHT_TEXELS;
    vec4 power = light_texel(first + 1u);
    uint packed_bits = uint(power.w);
    return LoadedLight(light_texel(first), power.rgb, light_remainder(packed_bits), light_kind(packed_bits), first);
}

vec3 shade_loaded_light(LoadedLight light, Lobes lobes, Surface s, vec3 v) {
    precise vec3 l = light.place.xyz;
    precise float strength = 1.0;
    precise float nl;
    if (light.kind == KIND_DIRECTIONAL) {
        nl = dot(s.normal, l);
    } else {
        l = (light.place.xyz - s.position) + light.remainder;
        precise float d2 = max(dot(l, l), MIN_DISTANCE2);
        precise float inverse_d = 1.0 / sqrt(d2);
        nl = dot(s.normal, l) * inverse_d;
        l *= inverse_d;
        strength = light_window(d2 * light.place.w) * light_falloff(d2, inverse_d);
        if (light.kind == KIND_SPOT) {
            strength *= light_cone(l, light.first_texel);
        }
    }
    // The intensity comes last: before it nothing can pass f32, so no infinity meets a 0.
    precise vec3 added = reflect_light(lobes, s, v, l, max(nl, 0.0)) * (strength * max(nl, 0.0)) * light.intensity;
    return strength > 0.0 && nl > 0.0 ? added : vec3(0.0);
}

// The same of a light that has a shadow.
vec3 shade_shadowed_light(LoadedLight light, Lobes lobes, Surface s, vec3 v) {
    precise vec3 added = shade_loaded_light(light, lobes, s, v);
    if (added != vec3(0.0)) {
        added *= shadow_visibility(light.first_texel / LIGHT_TEXELS, light.kind, s);
    }
    return added;
}

vec3 shade_light(uint index, Lobes lobes, Surface s, vec3 v) {
    return shade_loaded_light(load_light(index), lobes, s, v);
}

// Of any light, with a shadow or without.
vec3 shade_any_light(uint index, Lobes lobes, Surface s, vec3 v) {
    if (SHADOW_KINDS == 0u) {
        return shade_light(index, lobes, s, v);
    }
    return shade_shadowed_light(load_light(index), lobes, s, v);
}

vec3 view_direction(Surface s) {
    precise vec3 v = frame.data.perspective > 0.0 ? -s.position / sqrt(dot(s.position, s.position)) : vec3(0.0, 0.0, 1.0);
    return v;
}

// NAME: lights first to end on top of what is added up already, in id order, each by SHADE; with SEEK those out of range are stepped over.
// Seek, then shade. Some drivers run both sides of every branch, but all of them leave a loop: 32 lights are tested by their range alone, and only
// those that reach this fragment enter the second loop, still in id order.
#define ADD_RUN(NAME, SHADE, SEEK) \
vec3 NAME(vec3 before, Lobes lobes, Surface s, vec3 v, uint first, uint end) { \
    precise vec3 sum = before; \
    if (!(SEEK)) { \
        for (uint i = first; i < end; ++i) { \
            sum += SHADE(load_light(i), lobes, s, v); \
        } \
        return sum; \
    } \
    for (uint base = first; base < end; base += 32u) { \
        uint reaching = 0u; \
        uint count = min(end - base, 32u); \
        for (uint i = 0u; i < count; ++i) { \
            bool outside = light_out_of_range(light_texel((base + i) * LIGHT_TEXELS), s.position); \
            reaching |= outside ? 0u : 1u << i; \
        } \
        while (reaching != 0u) { \
            uint i = base + uint(findLSB(reaching)); \
            reaching &= reaching - 1u; \
            sum += SHADE(load_light(i), lobes, s, v); \
        } \
    } \
    return sum; \
}

ADD_RUN(add_plain_run, shade_loaded_light, LIGHT_SEEK)
ADD_RUN(add_shadowed_run, shade_shadowed_light, LIGHT_SEEK)
ADD_RUN(add_plain_each, shade_loaded_light, false)
ADD_RUN(add_shadowed_each, shade_shadowed_light, false)

// Directional lights first to end. Those that have shadows come first: the others do not pay for what drivers run of a branch not taken.
vec3 add_directional_lights(vec3 before, Lobes lobes, Surface s, vec3 v, uint first, uint end) {
    if ((LIGHT_KINDS & KIND_DIRECTIONAL) == 0u) {
        return before;
    }
    if ((SHADOW_KINDS & KIND_DIRECTIONAL) == 0u) {
        return add_plain_each(before, lobes, s, v, first, end);
    }
    uint shadowed = shadow_runs().x;
    precise vec3 sum = add_shadowed_each(before, lobes, s, v, first, min(end, shadowed));
    sum = add_plain_each(sum, lobes, s, v, max(first, shadowed), end);
    return sum;
}

// Lights first to end on top of what is added up already, in id order.
vec3 add_lights(vec3 before, Lobes lobes, Surface s, vec3 v, uint first, uint end) {
    precise vec3 sum = before;
    if (LIGHT_KINDS == 0u) {
        return sum;
    }
    if (SHADOW_KINDS == 0u) {
        return add_plain_run(sum, lobes, s, v, first, end);
    }
    uvec3 runs = shadow_runs();
    sum = add_directional_lights(sum, lobes, s, v, first, min(end, runs.y));
    if (SHADOW_KINDS != KIND_DIRECTIONAL) {
        sum = add_shadowed_run(sum, lobes, s, v, max(first, runs.y), min(end, runs.z));
    }
    return add_plain_run(sum, lobes, s, v, max(first, runs.z), end);
}

vec3 shade_all_lights(Surface s) {
    if (s.unlit) {
        return min(s.base_color, MAX_RADIANCE);
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    precise vec3 sum = base_radiance(s);
    sum = add_lights(sum, lobes, s, v, 0u, frame.data.light_count);
    return min(sum, MAX_RADIANCE);
}
