#version 460
#extension GL_GOOGLE_include_directive : require
// Whether anything stands between two points, as far as 32 bits can tell: a thread a segment walks the hierarchy of the scene's triangles in a fixed
// order and says blocked or open only where rounding cannot have decided it. CPU twin: `is_blocked_past` of reference/render/bounced.rs.
#include "base.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) readonly buffer NodeBlock { uvec4 data[]; } nodes;
layout(set = 0, binding = 1, scalar) readonly buffer TriangleBlock { uvec4 data[]; } triangles;
layout(set = 0, binding = 2, scalar) readonly buffer SegmentBlock { uvec4 data[]; } segments;
layout(set = 0, binding = 3, scalar) writeonly buffer SeenBlock { uint data[]; } seen;

layout(push_constant, scalar) uniform Push { SightPush data; } push;

// What one product of three lengths is off by, relative to it: roundings of 2^-24 each, a dozen of them.
const float ROUNDING = 1e-6;

// The line against one triangle. Volumes of the way with each edge tell whether it passes inside, the volume of the corners how far along.
uint meets(vec3 from, vec3 way, float way_length, uint at) {
    vec3 a = uintBitsToFloat(triangles.data[3u * at].xyz) - from;
    vec3 b = uintBitsToFloat(triangles.data[3u * at + 1u].xyz) - from;
    vec3 c = uintBitsToFloat(triangles.data[3u * at + 2u].xyz) - from;
    vec3 ab = cross(a, b);
    vec3 bc = cross(b, c);
    vec3 ca = cross(c, a);
    vec3 volumes = vec3(dot(way, bc), dot(way, ca), dot(way, ab));
    float off = push.data.off;
    vec3 sizes = vec3(length(a), length(b), length(c)) + off;
    vec3 next = sizes.yzx;
    // Of a and b, of b and c, of c and a.
    vec3 products = sizes * next;
    vec3 slack = way_length * (off * (sizes + next) + ROUNDING * products).yzx;
    bool any_above = any(greaterThan(volumes, slack));
    bool any_below = any(lessThan(volumes, -slack));
    if (any_above && any_below) {
        return SIGHT_MISSED;
    }
    float along = dot(a, bc);
    float along_slack = off * (products.x + products.y + products.z) + ROUNDING * products.x * sizes.z;
    float volume = volumes.x + volumes.y + volumes.z;
    float volume_slack = slack.x + slack.y + slack.z;
    float sign_of = volume < 0.0 ? -1.0 : 1.0;
    along *= sign_of;
    volume = abs(volume);
    if (volume > volume_slack && (along < -along_slack || along > volume + along_slack + volume_slack)) {
        return SIGHT_MISSED;
    }
    bool inside = all(greaterThan(volumes * sign_of, slack));
    // As near to an end nothing is in the way.
    float least = 2e-7 * (1.0 + push.data.reach / way_length) * volume;
    bool between = along > least + along_slack && along < volume - least - along_slack - volume_slack;
    return inside && between && volume > volume_slack ? SIGHT_MET : SIGHT_UNSURE;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.data.count) {
        return;
    }
    uvec4 first = segments.data[2u * index];
    uvec4 second = segments.data[2u * index + 1u];
    vec3 from = uintBitsToFloat(first.xyz);
    vec3 way = uintBitsToFloat(second.xyz);
    uvec2 own = uvec2(first.w, second.w);
    float way_length = length(way);
    vec3 inverse = 1.0 / mix(way, vec3(1e-30), lessThan(abs(way), vec3(1e-30)));
    uint found = SIGHT_MISSED;
    uint at = 0u;
    uint steps = 0u;
    while (at < push.data.nodes && found != SIGHT_MET) {
        // Some drivers leave loops after 65,535 rounds of all of them together.
        ++steps;
        if (steps > SIGHT_STEPS) {
            found = SIGHT_UNSURE;
            break;
        }
        uvec4 low = nodes.data[2u * at];
        uvec4 high = nodes.data[2u * at + 1u];
        vec3 one = (uintBitsToFloat(low.xyz) - from) * inverse;
        vec3 other = (uintBitsToFloat(high.xyz) - from) * inverse;
        vec3 enter = min(one, other);
        vec3 leave = max(one, other);
        float near = max(max(enter.x, enter.y), max(enter.z, 0.0));
        float far = min(min(leave.x, leave.y), min(leave.z, 1.0));
        if (near > far * (1.0 + ROUNDING)) {
            at = low.w;
            continue;
        }
        uint leaf = high.w;
        for (uint k = 0u; k < (leaf & 7u); ++k) {
            uint triangle = (leaf >> 3u) + k;
            uint id = triangles.data[3u * triangle].w;
            if (id == own.x || id == own.y) {
                continue;
            }
            uint how = meets(from, way, way_length, triangle);
            // Where a mask decides the CPU looks.
            bool masked = triangles.data[3u * triangle + 1u].w != 0u;
            if (how == SIGHT_MET && !masked) {
                found = SIGHT_MET;
                break;
            }
            found = how == SIGHT_MISSED ? found : SIGHT_UNSURE;
        }
        ++at;
    }
    seen.data[index] = found;
}
