// The surface that the G-buffer holds at a pixel, in either layout. What a layout lacks is bound to something else and not read.
#include "gbuffer.glsl"
#include "cull.glsl"
#include "surface_data.glsl"
#include "sample_offset.glsl"

layout(constant_id = 30) const uint GBUFFER = GBUFFER_COMPACT;
// The compact layout has an image of emission.
layout(constant_id = 32) const bool EMISSION = false;
// It says which material is seen.
layout(constant_id = 34) const bool STORED_MATERIAL = false;

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;
layout(set = 0, binding = 14, scalar) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 0, binding = 20) uniform sampler2D gbuffer_depth;
layout(set = 0, binding = 21) uniform sampler2D gbuffer_base_color;
layout(set = 0, binding = 22) uniform usampler2D gbuffer_normals;
layout(set = 0, binding = 23) uniform sampler2D gbuffer_material;
layout(set = 0, binding = 24) uniform sampler2D gbuffer_emission;
layout(set = 0, binding = 25) uniform sampler2D gbuffer_position_roughness;
layout(set = 0, binding = 26) uniform sampler2D gbuffer_normal_occlusion;
layout(set = 0, binding = 27) uniform sampler2D gbuffer_base_metallic;
layout(set = 0, binding = 28) uniform sampler2D gbuffer_specular_flag;
layout(set = 0, binding = 29) uniform sampler2D gbuffer_ambient_emission;
// The compact layout of several samples a pixel.
layout(set = 0, binding = 35) uniform sampler2DMS depth_samples;
layout(set = 0, binding = 36) uniform sampler2DMS base_color_samples;
layout(set = 0, binding = 37) uniform usampler2DMS normals_samples;
layout(set = 0, binding = 38) uniform sampler2DMS material_samples;
layout(set = 0, binding = 39) uniform sampler2DMS emission_samples;


void read_model(uint material, inout Surface s) {
    s.model = materials.data[material].model;
    s.model_color = materials.data[material].model_color;
    s.model_exponent = materials.data[material].model_exponent;
}

// Distance along the view axis of a stored depth: what distance_range of cull.glsl widens.
float view_distance(float depth) {
    if (frame.data.perspective > 0.0) {
        precise float d = frame.data.depth_offset * reciprocal(max(depth + frame.data.depth_scale, 1e-37));
        return min(d, FAR_LIMIT);
    }
    precise float d = frame.data.depth_offset - depth * frame.data.depth_scale;
    return d;
}

// The point of the picture at the distance of its depth; pixels' centres are whole numbers.
vec3 position_of_depth(vec2 at, float depth) {
    precise vec2 image = at * frame.data.image_scale + frame.data.image_offset;
    float d = view_distance(depth);
    precise vec2 across = image * d;
    return vec3(frame.data.perspective > 0.0 ? across : image, -d);
}

void decode_surface(vec4 base_color, uvec4 codes, vec4 material_texel, vec4 emission, inout Surface s) {
    vec3 material = load_material(material_texel);
    s.normal = decode_octahedral(codes.xy, NORMAL_BITS);
    s.base_color = load_base_color(base_color);
    s.roughness = material.x;
    s.metallic = material.y;
    s.occlusion = material.z;
    s.emissive = emission.rgb;
    if (STORED_MATERIAL) {
        read_model(codes.z, s);
    }
}

// False where no lit surface is seen.
bool read_gbuffer(ivec2 at, out Surface s) {
    s.unlit = false;
    s.alpha = 1.0;
    s.model = SHADING_GLTF;
    s.model_color = vec3(0.0);
    s.model_exponent = 1.0;
    if (GBUFFER == GBUFFER_FAT) {
        vec4 position_roughness = texelFetch(gbuffer_position_roughness, at, 0);
        vec4 base_metallic = texelFetch(gbuffer_base_metallic, at, 0);
        s.position = position_roughness.xyz;
        s.roughness = position_roughness.w;
        s.normal = texelFetch(gbuffer_normal_occlusion, at, 0).xyz;
        s.base_color = base_metallic.rgb;
        s.metallic = base_metallic.w;
        // Ambient light is in what was stored; an occlusion of 0 adds none to it.
        s.occlusion = 0.0;
        s.emissive = texelFetch(gbuffer_ambient_emission, at, 0).rgb;
        float flag = texelFetch(gbuffer_specular_flag, at, 0).w;
        if (STORED_MATERIAL && flag > 0.0) {
            read_model(uint(flag) - 1u, s);
        }
        return flag > 0.0;
    }
    vec4 base_color = texelFetch(gbuffer_base_color, at, 0);
    s.position = position_of_depth(vec2(at), texelFetch(gbuffer_depth, at, 0).x);
    vec4 emission = vec4(0.0);
    if (EMISSION) {
        emission = texelFetch(gbuffer_emission, at, 0);
    }
    decode_surface(base_color, texelFetch(gbuffer_normals, at, 0), texelFetch(gbuffer_material, at, 0), emission, s);
    return base_color.w > 0.0;
}

// All but the position of one sample of a pixel; false where no lit surface is seen.
bool read_sample_texels(ivec2 at, int index, inout Surface s) {
    s.unlit = false;
    s.alpha = 1.0;
    s.model = SHADING_GLTF;
    s.model_color = vec3(0.0);
    s.model_exponent = 1.0;
    vec4 base_color = texelFetch(base_color_samples, at, index);
    vec4 emission = vec4(0.0);
    if (EMISSION) {
        emission = texelFetch(emission_samples, at, index);
    }
    decode_surface(base_color, texelFetch(normals_samples, at, index), texelFetch(material_samples, at, index), emission, s);
    return base_color.w > 0.0;
}

// One sample of a pixel, and its depth as stored.
bool read_gbuffer_sample(ivec2 at, uint index, out Surface s, out float depth) {
    depth = texelFetch(depth_samples, at, int(index)).x;
    s.position = position_of_depth(vec2(at) + sample_offset(index), depth);
    return read_sample_texels(at, int(index), s);
}

// A pixel whose samples show one surface, in its middle: the mean of their depths is the depth there.
bool read_gbuffer_pixel(ivec2 at, out Surface s, out float depth) {
    precise float sum = 0.0;
    for (uint index = 0u; index < SAMPLES; ++index) {
        sum += texelFetch(depth_samples, at, int(index)).x * (1.0 / float(SAMPLES));
    }
    depth = sum;
    s.position = position_of_depth(vec2(at), sum);
    return read_sample_texels(at, 0, s);
}
