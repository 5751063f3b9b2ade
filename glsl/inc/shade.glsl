// One light on one surface, and the sum over all of them in light-id order (f32, stored once). CPU twin: reference/shade.rs.
#include "lights.glsl"
#include "brdf.glsl"

// What rounding to f32 took from the light's position.
vec3 light_remainder(uint packed_bits) {
    const uint mask = (1u << REMAINDER_BITS) - 1u;
    uvec3 steps = uvec3(packed_bits, packed_bits >> REMAINDER_BITS, packed_bits >> (2u * REMAINDER_BITS)) & mask;
    return (vec3(steps) - float(REMAINDER_BIAS)) * frame.data.light_remainder_step;
}

vec3 shade_light(uint index, Lobes lobes, Surface s, vec3 v) {
    uint first = index * LIGHT_TEXELS;
    vec4 place = light_texel(first);
    vec4 power = light_texel(first + 1u);
    uint packed_bits = uint(power.w);
    uint kind = LIGHT_KINDS;
    if (LIGHT_KINDS != KIND_POINT && LIGHT_KINDS != KIND_SPOT && LIGHT_KINDS != KIND_DIRECTIONAL) {
        kind = packed_bits >> (3u * REMAINDER_BITS);
    }
    precise vec3 l = place.xyz;
    precise float strength = 1.0;
    precise float nl;
    if (kind == KIND_DIRECTIONAL) {
        nl = dot(s.normal, l);
    } else {
        l = (place.xyz - s.position) + light_remainder(packed_bits);
        precise float d2 = max(dot(l, l), MIN_DISTANCE2);
        precise float q = d2 * place.w;
        if (LIGHT_SKIP && q >= 1.0) {
            return vec3(0.0);
        }
        precise float d = sqrt(d2);
        nl = dot(s.normal, l) / d;
        l /= d;
        strength = light_window(q) * light_falloff(d2);
        if (kind == KIND_SPOT) {
            strength *= light_cone(l, first);
        }
    }
    if (!(nl > 0.0)) {
        return vec3(0.0);
    }
    precise vec3 added = power.rgb * (strength * nl) * reflect_light(lobes, s, v, l, nl);
    return added;
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
    if (LIGHT_KINDS != 0u) {
        for (uint i = 0u; i < frame.data.light_count; ++i) {
            sum += shade_light(i, lobes, s, v);
        }
    }
    return sum;
}
