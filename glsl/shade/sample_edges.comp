#version 460
#extension GL_GOOGLE_include_directive : require
// Pixels whose samples show different surfaces: a thread a pixel.
#include "base.glsl"
#include "read_gbuffer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 17, r32ui) uniform writeonly uimage2D sample_edges;

// Texels of one triangle are equal to the bit: it was shaded once a pixel. Samples of two surfaces that are alike in everything lie in
// one plane, or the pixel is an edge: so far apart along the normal, in pixels, they are not.
const float SAME_PLANE = 0.25;

bool differs(ivec2 at, Surface first, uint index) {
    int i = int(index);
    bool alike = texelFetch(base_color_samples, at, i) == texelFetch(base_color_samples, at, 0)
        && texelFetch(normals_samples, at, i) == texelFetch(normals_samples, at, 0)
        && texelFetch(material_samples, at, i) == texelFetch(material_samples, at, 0);
    if (EMISSION) {
        alike = alike && texelFetch(emission_samples, at, i) == texelFetch(emission_samples, at, 0);
    }
    if (!alike) {
        return true;
    }
    Surface s;
    float depth;
    read_gbuffer_sample(at, index, s, depth);
    float pixel = max(abs(frame.data.image_scale.x), abs(frame.data.image_scale.y));
    pixel *= frame.data.perspective > 0.0 ? -first.position.z : 1.0;
    return !(abs(dot(first.normal, s.position - first.position)) <= SAME_PLANE * pixel);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(sample_edges);
    if (at.x >= size.x || at.y >= size.y) {
        return;
    }
    Surface first;
    float depth;
    bool seen = read_gbuffer_sample(at, 0u, first, depth);
    bool edge = false;
    for (uint index = 1u; index < SAMPLES; ++index) {
        if (seen) {
            edge = edge || differs(at, first, index);
        } else {
            edge = edge || texelFetch(base_color_samples, at, int(index)).w > 0.0;
        }
    }
    imageStore(sample_edges, at, uvec4(edge ? 1u : 0u));
}
