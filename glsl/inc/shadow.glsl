// How much of a light reaches a surface, from maps of depth as the light sees it (L. Williams, "Casting Curved Shadows on Curved Surfaces",
// 1978; W. Reeves, D. Salesin, R. Cook, "Rendering Antialiased Shadows with Depth Maps", 1987). Its oracle are rays: reference/render.rs.

// Bits KIND_* of the lights that have shadows.
layout(constant_id = 36) const uint SHADOW_KINDS = 0u;
// Texels that the edge of a shadow is spread over; 0: it follows the map's texels.
layout(constant_id = 37) const uint SHADOW_FILTER = 2u;

layout(set = 0, binding = 40) uniform sampler2D shadow_atlas;
layout(set = 0, binding = 41) uniform samplerBuffer shadow_maps;

const uint NO_SHADOW = 0xffffffffu;

// Texels from a position to the middle of the farthest texel that it is compared with, along a row.
float shadow_reach() {
    return 0.5 * (float(SHADOW_FILTER) + 1.0);
}

// Ends of runs of the light table: directional lights that have shadows, all directional ones, and behind them others that have shadows.
uvec3 shadow_runs() {
    vec4 head = texelFetch(shadow_maps, 0);
    return uvec3(head.x, head.y, head.y + head.z);
}

// Texels of a light's shadow; in each of both runs of the light table lights with shadows come first.
uint shadow_of(uint light, uint kind) {
    vec4 head = texelFetch(shadow_maps, 0);
    if (kind == KIND_DIRECTIONAL) {
        return light < uint(head.x) ? SHADOW_HEAD_TEXELS + light * SHADOW_LIGHT_TEXELS : NO_SHADOW;
    }
    uint local = light - uint(head.y);
    return local < uint(head.z) ? SHADOW_HEAD_TEXELS + (local + uint(head.x)) * SHADOW_LIGHT_TEXELS : NO_SHADOW;
}

float shadow_row(uint at, vec3 position) {
    vec4 row = texelFetch(shadow_maps, int(at));
    precise float product = dot(row.xyz, position) + row.w;
    return product;
}

// Axis that a vector is nearest to: +x, -x, +y, -y, +z, -z.
uint axis_side(vec3 p) {
    vec3 size = abs(p);
    if (size.x >= size.y && size.x >= size.z) {
        return p.x < 0.0 ? 1u : 0u;
    }
    if (size.y >= size.z) {
        return p.y < 0.0 ? 3u : 2u;
    }
    return p.z < 0.0 ? 5u : 4u;
}

// Side of the cube that a position lies behind.
uint cube_side(uint shadow, vec3 position) {
    return axis_side(vec3(shadow_row(shadow + 1u, position), shadow_row(shadow + 2u, position), shadow_row(shadow + 3u, position)));
}

// The first map, which is the finest, that holds the position and all texels that it is compared with.
uint cascade(uint first, uint count, vec3 position) {
    for (uint i = 0u; i + 1u < count; ++i) {
        uint at = first + i * SHADOW_MAP_TEXELS;
        vec4 area = texelFetch(shadow_maps, int(at + 4u));
        vec2 place = vec2(shadow_row(at, position), shadow_row(at + 1u, position)) - area.xy;
        // As much again for what the position is moved by.
        vec2 inset = vec2(2.0 * shadow_reach() + 1.0);
        if (all(greaterThan(place, inset)) && all(lessThan(place, vec2(area.z) - inset))) {
            return at;
        }
    }
    return first + (count - 1u) * SHADOW_MAP_TEXELS;
}

float shadow_tap(ivec2 texel, float depth) {
    return texelFetch(shadow_atlas, texel, 0).x <= depth ? 1.0 : 0.0;
}

// Share of the texels about a place in the map whose depth lies behind, in a square of SHADOW_FILTER texels.
float shadow_share(vec2 place, ivec2 first, ivec2 last, float depth) {
    if (SHADOW_FILTER == 0u) {
        return shadow_tap(clamp(ivec2(floor(place)), first, last), depth);
    }
    precise vec2 corner = place - 0.5 * float(SHADOW_FILTER);
    vec2 begin = floor(corner);
    vec2 part = corner - begin;
    precise float sum = 0.0;
    for (uint y = 0u; y <= SHADOW_FILTER; ++y) {
        float high = y == 0u ? 1.0 - part.y : (y == SHADOW_FILTER ? part.y : 1.0);
        precise float row = 0.0;
        for (uint x = 0u; x <= SHADOW_FILTER; ++x) {
            float wide = x == 0u ? 1.0 - part.x : (x == SHADOW_FILTER ? part.x : 1.0);
            row += wide * shadow_tap(clamp(ivec2(begin) + ivec2(x, y), first, last), depth);
        }
        sum += high * row;
    }
    return sum * (1.0 / float(SHADOW_FILTER * SHADOW_FILTER));
}

// Share of a light that reaches a surface.
float shadow_visibility(uint light, uint kind, Surface s) {
    if ((SHADOW_KINDS & kind) == 0u) {
        return 1.0;
    }
    uint shadow = shadow_of(light, kind);
    if (shadow == NO_SHADOW) {
        return 1.0;
    }
    vec4 maps = texelFetch(shadow_maps, int(shadow));
    uint at = uint(maps.x);
    if (kind == KIND_DIRECTIONAL) {
        at = cascade(at, uint(maps.y), s.position);
    } else if (maps.y > 1.0) {
        at += cube_side(shadow, s.position) * SHADOW_MAP_TEXELS;
    }
    vec4 area = texelFetch(shadow_maps, int(at + 4u));
    float w = shadow_row(at + 3u, s.position);
    if (area.z == 0.0 || !(w > 0.0)) {
        return 1.0;
    }
    // Half of what a surface's own plane comes nearer to the light within the texels that are compared is taken here, off the surface; its slope
    // has pushed the map's depth by the other half and more (src/passes/shadow_map.rs), for what meets the surface at an angle. A column's and a
    // row's axes are what the map's rows hold besides the way ahead.
    vec3 ahead = texelFetch(shadow_maps, int(at + 3u)).xyz;
    vec3 right = texelFetch(shadow_maps, int(at)).xyz - (area.x + 0.5 * area.z) * ahead;
    vec3 down = texelFetch(shadow_maps, int(at + 1u)).xyz - (area.y + 0.5 * area.z) * ahead;
    float slope = (abs(dot(s.normal, right)) + abs(dot(s.normal, down))) * area.w;
    precise vec3 position = s.position + s.normal * (0.5 * shadow_reach() * area.w * w * slope + maps.z + maps.w * abs(s.position.z));
    w = shadow_row(at + 3u, position);
    if (!(w > 0.0)) {
        return 1.0;
    }
    precise float inverse = 1.0 / w;
    precise vec2 place = vec2(shadow_row(at, position), shadow_row(at + 1u, position)) * inverse;
    precise float depth = shadow_row(at + 2u, position) * inverse;
    ivec2 first = ivec2(area.xy);
    return shadow_share(place, first, first + ivec2(area.z) - 1, depth);
}
