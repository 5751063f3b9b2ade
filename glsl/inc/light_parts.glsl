// A sum over more lights than a driver's loops go round: passes continue it, each reading what the one before it left (plan/light_parts.rs). Until
// the last one alpha counts the lights that are in the sum, exactly: there are fewer than 2^24. A picture drawn in one pass and one drawn in
// several add the same numbers in the same order, and both clamp once.
//
// Surfaces that are mixed with what lies behind them are drawn in one pass, with their alpha.
layout(constant_id = 7) const bool BLENDED = false;
// They are mixed in 16-bit floats.
layout(constant_id = 8) const bool HALF_LAYER = false;
layout(constant_id = 17) const bool FIRST_PART = true;
layout(constant_id = 18) const bool LAST_PART = true;
layout(constant_id = 19) const uint PART_LIGHTS = 0xffffffffu;

layout(set = 0, binding = 13) uniform sampler2D radiance_before;

// The sum that a pass begins with, and how many lights are in it.
vec4 sum_before(Surface s) {
    if (FIRST_PART) {
        return vec4(base_radiance(s), 0.0);
    }
    // A quad reaches past a picture of odd size.
    ivec2 last = textureSize(radiance_before, 0) - 1;
    return texelFetch(radiance_before, min(ivec2(gl_FragCoord.xy), last), 0);
}

float most_radiance() {
    if (HALF_LAYER) {
        return MAX_HALF;
    }
    return MAX_RADIANCE;
}

// Share of the picture that a surface takes.
float coverage(Surface s) {
    return BLENDED ? clamp(s.alpha, 0.0, 1.0) : 1.0;
}

// What a pass leaves.
vec4 sum_after(Surface s, vec3 sum, uint count) {
    return LAST_PART ? vec4(min(sum, most_radiance()), coverage(s)) : vec4(sum, float(count));
}

// A surface that no light changes is the same in every pass.
vec4 unlit_part(Surface s) {
    return vec4(min(s.base_color, most_radiance()), coverage(s));
}
