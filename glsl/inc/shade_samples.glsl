// Several samples a pixel over a G-buffer: one by one where they differ, else once in the middle of the pixel. Comes after read_gbuffer.glsl; the
// shader says how a surface of a pixel is lit.
vec3 light_surface(uvec2 at, Surface s, float depth);

// Something is drawn over the picture: samples stand side by side for it. Else their mean is stored.
layout(constant_id = 35) const bool SPREAD = false;

// Pixels whose samples differ.
layout(set = 0, binding = 16) uniform usampler2D sample_edges;

vec4 light_texel_of(uvec2 at, Surface s, float depth, bool seen) {
    return seen ? vec4(min(light_surface(at, s, depth), MAX_RADIANCE), 1.0) : vec4(0.0);
}

void shade_samples(uvec2 at) {
    Surface s;
    float depth;
    if (texelFetch(sample_edges, ivec2(at), 0).x == 0u) {
        bool seen = read_gbuffer_pixel(ivec2(at), s, depth);
        vec4 texel = light_texel_of(at, s, depth, seen);
        if (!SPREAD) {
            imageStore(radiance, ivec2(at), texel);
            return;
        }
        for (uint index = 0u; index < SAMPLES; ++index) {
            imageStore(radiance, ivec2(at.x * SAMPLES + index, at.y), texel);
        }
        return;
    }
    precise vec4 sum = vec4(0.0);
    for (uint index = 0u; index < SAMPLES; ++index) {
        bool seen = read_gbuffer_sample(ivec2(at), index, s, depth);
        vec4 texel = light_texel_of(at, s, depth, seen);
        if (SPREAD) {
            imageStore(radiance, ivec2(at.x * SAMPLES + index, at.y), texel);
        }
        sum += texel * (1.0 / float(SAMPLES));
    }
    if (!SPREAD) {
        imageStore(radiance, ivec2(at), sum);
    }
}
