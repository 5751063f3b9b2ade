// The explicit texture-level rule: half the logarithm of the larger squared footprint, from differences within a 2x2 quad that
// the CPU twin (reference/texture.rs) can repeat.
// Derivatives are those of the interpolant itself, carried through the linear map: helper invocations may read 0 from a buffer
// (lavapipe does), so nothing that was loaded may stand under a derivative.
struct UvFootprint {
    vec2 uv;
    vec2 dx;
    vec2 dy;
};

vec4 sample_level(sampler2D image, UvFootprint f) {
    vec2 size = vec2(textureSize(image, 0));
    vec2 dx = f.dx * size;
    vec2 dy = f.dy * size;
    float footprint = max(dot(dx, dx), dot(dy, dy));
    // log2(0) is avoided: a constant coordinate reads level 0 with the magnification filter.
    float level = footprint > 0.0 ? 0.5 * log2(footprint) : -1.0;
    return textureLod(image, f.uv, level);
}
