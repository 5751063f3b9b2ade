#version 460
#extension GL_GOOGLE_include_directive : require
// What each patch sends at first: emission, and the direct light at its points past the shadow maps. A thread a point.
// CPU twin: radiosity/solve.rs.
#include "base.glsl"
#include "surface_data.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;
layout(set = 0, binding = 1, scalar) readonly buffer PatchBlock { PatchData data[]; } patches;
layout(set = 0, binding = 2, scalar) readonly buffer PointBlock { vec3 data[]; } patch_points;
// Points of a patch; a divisor of 64.
layout(constant_id = 42) const uint POINTS = PATCH_POINTS;
// What is made of the light of the frame before (CARRIED_*).
layout(constant_id = 41) const uint CARRIED = CARRIED_NOTHING;
layout(set = 0, binding = 46, scalar) readonly buffer KeptBlock { PatchLight data[]; } bounced_kept;
layout(set = 0, binding = 6, scalar) writeonly buffer LightBlock { PatchLight data[]; } light;

#include "shade.glsl"

layout(push_constant, scalar) uniform Push { PatchPush data; } push;

shared vec3 sums[64];

// What passed the numbers once must not stay for ever.
vec3 finite(vec3 light) {
    return vec3(abs(light.x) <= 3e38 ? light.x : 0.0, abs(light.y) <= 3e38 ? light.y : 0.0, abs(light.z) <= 3e38 ? light.z : 0.0);
}

void main() {
    uint at = gl_LocalInvocationID.x;
    uint patch_id = ((gl_WorkGroupID.y * MOST_GROUPS + gl_WorkGroupID.x) * 64u + at) / POINTS;
    vec3 irradiance = vec3(0.0);
    if (patch_id < push.data.count) {
        Surface s;
        uint point = 2u * (patch_id * POINTS + at % POINTS);
        s.position = patch_points.data[point];
        s.normal = patch_points.data[point + 1u];
        s.base_color = vec3(1.0);
        s.alpha = 1.0;
        s.metallic = 0.0;
        s.roughness = 1.0;
        s.occlusion = 1.0;
        s.emissive = vec3(0.0);
        s.unlit = false;
        s.model = SHADING_LAMBERT;
        s.model_color = vec3(0.0);
        s.model_exponent = 0.0;
        vec3 v = view_direction(s);
        irradiance = add_lights(vec3(0.0), make_lobes(s, v), s, v, 0u, frame.data.light_count) * PI;
    }
    sums[at] = irradiance;
    barrier();
    if (at % POINTS != 0u || patch_id >= push.data.count) {
        return;
    }
    precise vec3 sum = vec3(0.0);
    for (uint k = 0u; k < POINTS; ++k) {
        sum += sums[at + k];
    }
    PatchData of = patches.data[patch_id];
    precise vec3 first = of.emission * PI + of.reflectance * (sum * (1.0 / float(POINTS)));
    vec3 known = vec3(0.0);
    vec3 first_known = vec3(0.0);
    if (CARRIED != CARRIED_NOTHING && push.data.afresh == 0u) {
        known = finite(bounced_kept.data[patch_id].irradiance.rgb);
        first_known = bounced_kept.data[patch_id].first.rgb;
    }
    precise vec3 sent = (first + of.reflectance * known) * of.area;
    if (CARRIED == CARRIED_CHANGES) {
        sent = first - first_known;
    }
    light.data[patch_id] = PatchLight(vec4(known, 0.0), vec4(known, 0.0), vec4(sent, 0.0), vec4(first, 0.0));
}
