// Reading a light and its irradiance at a surface. CPU twin: reference/shade.rs.
layout(constant_id = 0) const uint LIGHT_FETCH = 0u;
layout(constant_id = 1) const uint LIGHT_KINDS = 7u;
layout(constant_id = 2) const uint LIGHT_TEXELS = 4u;
layout(constant_id = 3) const uint LIGHT_UNIFORM_TEXELS = 1u;
// Lights out of range are stepped over by their range test alone; they would have added exactly 0.
layout(constant_id = 4) const bool LIGHT_SEEK = true;
layout(constant_id = 5) const bool INVERSE_SQUARE = true;

layout(set = 0, binding = 3, scalar) readonly buffer LightStorage { vec4 texels[]; } lights_storage;
layout(set = 0, binding = 4, scalar) uniform LightUniform { vec4 texels[LIGHT_UNIFORM_TEXELS]; } lights_uniform;
layout(set = 0, binding = 5) uniform samplerBuffer lights_texel;

vec4 light_texel(uint index) {
    if (LIGHT_FETCH == FETCH_STORAGE) {
        return lights_storage.texels[index];
    } else if (LIGHT_FETCH == FETCH_UNIFORM) {
        return lights_uniform.texels[index];
    }
    return texelFetch(lights_texel, int(index));
}

// Squared and doubled: KHR_lights_punctual's window 1 - (d / range)^4 from d^2 / range^2.
float light_window(float q) {
    precise float w = max(1.0 - q * q, 0.0);
    return w;
}

float light_falloff(float d2, float inverse_d) {
    if (INVERSE_SQUARE) {
        precise float square = inverse_d * inverse_d;
        return min(square, 1.0 / MIN_FALLOFF);
    }
    precise float d = d2 * inverse_d;
    precise float denominator = frame.data.attenuation.x + d * (frame.data.attenuation.y + d * frame.data.attenuation.z);
    return 1.0 / max(denominator, MIN_FALLOFF);
}

// cos(angle) - cos(outer) as a difference of two small numbers, so that narrow cones keep their digits.
float light_cone(vec3 to_light, uint first) {
    vec4 axis = light_texel(first + 2u);
    float scale = light_texel(first + 3u).x;
    precise float cd = -dot(to_light, axis.xyz);
    precise vec3 across = cross(to_light, axis.xyz);
    precise float one_minus = cd > 0.0 ? dot(across, across) / (1.0 + cd) : 1.0 - cd;
    precise float t = clamp((axis.w - one_minus) * scale, 0.0, 1.0);
    return t * t;
}
