// One light on one surface, and the sum over all of them in light-id order (f32, stored once). CPU twin: reference/shade.rs.
#include "lights.glsl"
#include "brdf.glsl"

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

// Squared distance over squared range, without the remainder: off by an ulp or two, so a light is stepped over only from a
// little beyond its range on, where its window is exactly 0.
bool light_out_of_range(vec4 place, vec3 position) {
    vec3 l = place.xyz - position;
    return dot(l, l) * place.w > 1.00001;
}

vec3 shade_light(uint index, Lobes lobes, Surface s, vec3 v) {
    uint first = index * LIGHT_TEXELS;
    vec4 place = light_texel(first);
    vec4 power = light_texel(first + 1u);
    uint packed_bits = uint(power.w);
    uint kind = light_kind(packed_bits);
    precise vec3 l = place.xyz;
    precise float strength = 1.0;
    precise float nl;
    if (kind == KIND_DIRECTIONAL) {
        nl = dot(s.normal, l);
    } else {
        l = (place.xyz - s.position) + light_remainder(packed_bits);
        precise float d2 = max(dot(l, l), MIN_DISTANCE2);
        precise float inverse_d = 1.0 / sqrt(d2);
        nl = dot(s.normal, l) * inverse_d;
        l *= inverse_d;
        strength = light_window(d2 * place.w) * light_falloff(d2, inverse_d);
        if (kind == KIND_SPOT) {
            strength *= light_cone(l, first);
        }
    }
    precise vec3 added = power.rgb * (strength * max(nl, 0.0)) * reflect_light(lobes, s, v, l, max(nl, 0.0));
    // Written so that what adds nothing adds exactly 0, and never NaN where the lobe overflows.
    return strength > 0.0 && nl > 0.0 ? added : vec3(0.0);
}

vec3 view_direction(Surface s) {
    precise vec3 v = frame.data.perspective > 0.0 ? -s.position / sqrt(dot(s.position, s.position)) : vec3(0.0, 0.0, 1.0);
    return v;
}

vec3 shade_all_lights(Surface s) {
    if (s.unlit) {
        return s.base_color;
    }
    vec3 v = view_direction(s);
    Lobes lobes = make_lobes(s, v);
    precise vec3 sum = frame.data.ambient * s.occlusion * s.base_color + s.emissive;
    if (LIGHT_KINDS == 0u) {
        return sum;
    }
    uint count = frame.data.light_count;
    if (!LIGHT_SEEK) {
        for (uint i = 0u; i < count; ++i) {
            sum += shade_light(i, lobes, s, v);
        }
        return sum;
    }
    // Seek, then shade (Aila and Laine, "Understanding the Efficiency of Ray Traversal on GPUs", 2009, section 4: while-while):
    // drivers that run both sides of every branch still leave a loop, so lights out of range cost their test alone.
    uint i = 0u;
    while (true) {
        while (i < count && light_out_of_range(light_texel(i * LIGHT_TEXELS), s.position)) {
            ++i;
        }
        if (i >= count) {
            break;
        }
        sum += shade_light(i, lobes, s, v);
        ++i;
    }
    return sum;
}
