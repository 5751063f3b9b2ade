// The explicit texture-level rule: half the logarithm of the larger squared footprint, from differences within a 2x2 quad that
// the CPU twin (reference/texture.rs) can repeat.
vec4 sample_level(sampler2D image, vec3 row_u, vec3 row_v, vec2 uv) {
    precise vec2 at = vec2(dot(row_u, vec3(uv, 1.0)), dot(row_v, vec3(uv, 1.0)));
    vec2 size = vec2(textureSize(image, 0));
    vec2 dx = dFdxFine(at) * size;
    vec2 dy = dFdyFine(at) * size;
    float footprint = max(dot(dx, dx), dot(dy, dy));
    // log2(0) is avoided: a constant coordinate reads level 0 with the magnification filter.
    float level = footprint > 0.0 ? 0.5 * log2(footprint) : -1.0;
    return textureLod(image, at, level);
}
