// A sum over more lights than a driver's loops go round: passes continue it, each reading what the one before it left (plan/light_parts.rs). Until
// the last one alpha counts the lights that are in the sum, exactly: there are fewer than 2^24. A picture drawn in one pass and one drawn in
// several add the same numbers in the same order, and both clamp once.
layout(constant_id = 17) const bool FIRST_PART = true;
layout(constant_id = 18) const bool LAST_PART = true;
layout(constant_id = 19) const uint PART_LIGHTS = 0xffffffffu;

layout(set = 0, binding = 13) uniform sampler2D radiance_before;

// The sum that a pass begins with, and how many lights are in it.
vec4 sum_before(Surface s) {
    if (FIRST_PART) {
        return vec4(unlit_radiance(s), 0.0);
    }
    // A quad reaches past a picture of odd size.
    ivec2 last = textureSize(radiance_before, 0) - 1;
    return texelFetch(radiance_before, min(ivec2(gl_FragCoord.xy), last), 0);
}

// What a pass leaves.
vec4 sum_after(vec3 sum, uint count) {
    return LAST_PART ? vec4(min(sum, MAX_RADIANCE), 1.0) : vec4(sum, float(count));
}

// A surface that no light changes is the same in every pass.
vec4 unlit_part(Surface s) {
    return vec4(min(s.base_color, MAX_RADIANCE), 1.0);
}
