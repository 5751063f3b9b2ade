#version 460
#extension GL_GOOGLE_include_directive : require
// Reads every member of every shared struct where the shader believes it lies and writes it out in order. Over a buffer whose words
// are their own indices the output is 0, 1, 2, ... exactly when scalar layout means the same to the driver as to Rust.
#include "base.glsl"

layout(local_size_x = 1) in;

layout(set = 0, binding = 0, scalar) readonly buffer Structs {
    Frame frame[2];
    InstanceData instances[2];
    MaterialData materials[2];
} structs;
layout(set = 0, binding = 1, scalar) writeonly buffer Members { float data[]; } members;

uint next = 0u;

void put(float x) {
    members.data[next++] = x;
}

// Integers were written as floats; their bits are compared.
void put(uint x) {
    put(uintBitsToFloat(x));
}

void put(vec2 v) {
    put(v.x);
    put(v.y);
}

void put(vec3 v) {
    put(v.x);
    put(v.y);
    put(v.z);
}

void put(vec4 v) {
    put(v.xyz);
    put(v.w);
}

void put(mat4 m) {
    put(m[0]);
    put(m[1]);
    put(m[2]);
    put(m[3]);
}

void main() {
    for (uint i = 0u; i < 2u; ++i) {
        put(structs.frame[i].view_to_clip);
        put(structs.frame[i].ambient);
        put(structs.frame[i].light_count);
        put(structs.frame[i].attenuation);
        put(structs.frame[i].perspective);
        put(structs.frame[i].light_seek_limit);
        put(structs.frame[i].light_remainder_step);
        put(structs.frame[i].image_scale);
        put(structs.frame[i].image_offset);
        put(structs.frame[i].depth_offset);
        put(structs.frame[i].depth_scale);
        put(structs.frame[i].directional_count);
    }
    for (uint i = 0u; i < 2u; ++i) {
        put(structs.instances[i].object_to_view_x);
        put(structs.instances[i].object_to_view_y);
        put(structs.instances[i].object_to_view_z);
        put(structs.instances[i].object_to_view_w);
        put(structs.instances[i].normal_x);
        put(structs.instances[i].normal_y);
        put(structs.instances[i].normal_z);
        put(structs.instances[i].material);
        put(structs.instances[i].handedness);
    }
    for (uint i = 0u; i < 2u; ++i) {
        put(structs.materials[i].base_color);
        put(structs.materials[i].emissive);
        put(structs.materials[i].metallic);
        put(structs.materials[i].roughness);
        put(structs.materials[i].normal_scale);
        put(structs.materials[i].occlusion_strength);
        put(structs.materials[i].alpha_cutoff);
        put(structs.materials[i].uv_base_color_u);
        put(structs.materials[i].uv_base_color_v);
        put(structs.materials[i].uv_metallic_roughness_u);
        put(structs.materials[i].uv_metallic_roughness_v);
        put(structs.materials[i].uv_normal_u);
        put(structs.materials[i].uv_normal_v);
        put(structs.materials[i].uv_occlusion_u);
        put(structs.materials[i].uv_occlusion_v);
        put(structs.materials[i].uv_emissive_u);
        put(structs.materials[i].uv_emissive_v);
        put(structs.materials[i].uv_height_u);
        put(structs.materials[i].uv_height_v);
        put(structs.materials[i].height_scale);
        put(structs.materials[i].height_channel);
        put(structs.materials[i].model);
        put(structs.materials[i].model_color);
        put(structs.materials[i].model_exponent);
    }
}
