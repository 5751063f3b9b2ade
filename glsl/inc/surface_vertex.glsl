// Vertex shader body of the passes that need the whole surface.
#include "vertex.glsl"

layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;

layout(location = 0) out vec3 out_position_vs;
layout(location = 1) out vec3 out_normal_vs;
layout(location = 2) out vec4 out_tangent_vs;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;
layout(location = 5) flat out uint out_material;
// Material factors do not vary over a triangle: the vertex shader reads them once, fragments need no buffer for them.
layout(location = 6) flat out vec4 out_base_color;
layout(location = 7) flat out vec4 out_emissive_metallic;
layout(location = 8) flat out vec4 out_roughness_scales;
layout(location = 9) flat out vec4 out_model;

layout(set = 0, binding = 2, scalar) readonly buffer MaterialBlock { MaterialData data[]; } materials;

void main() {
    InstanceData instance = instances.data[gl_InstanceIndex];
    vec3 position_vs = vertex_position_vs(instance, in_position);
    gl_Position = vertex_position_cs(position_vs);
    out_position_vs = position_vs;
    out_normal_vs = instance.normal_x * in_normal.x + instance.normal_y * in_normal.y + instance.normal_z * in_normal.z;
    out_tangent_vs = vec4(instance.object_to_view_x * in_tangent.x + instance.object_to_view_y * in_tangent.y
        + instance.object_to_view_z * in_tangent.z, in_tangent.w * instance.handedness);
    out_uv = vec4(in_uv0, in_uv1);
    out_color = in_color;
    out_material = instance.material;
    MaterialData m = materials.data[instance.material];
    out_base_color = m.base_color;
    out_emissive_metallic = vec4(m.emissive, m.metallic);
    out_roughness_scales = vec4(m.roughness, m.normal_scale, m.occlusion_strength, m.alpha_cutoff);
    out_model = vec4(m.model_color, m.model_exponent);
}
