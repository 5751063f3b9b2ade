#ifndef CULL_CONE
#define CULL_CONE
// Whether the cone of a spot light reaches a box: its sphere against the cone (B. Wronski, "Cull that cone!", 2017), squared, so that no root is
// taken. Comes after cull.glsl and cull_lights.glsl, behind whose texels lie CONE_TEXELS of each light where the scene has spots.
layout(constant_id = 29) const bool CULL_CONES = false;

bool cone_reaches(uint light_count, uint light, vec2 x, vec2 y, vec2 distances) {
    uint first = light_count * CULL_TEXELS + light * CONE_TEXELS;
    vec4 axis = cull_texel(first);
    vec4 shape = cull_texel(first + 1u);
    vec3 apex = cull_texel(light * CULL_TEXELS).xyz;
    precise vec3 half_size = vec3(x.y - x.x, y.y - y.x, distances.y - distances.x) * 0.5;
    precise vec3 center = vec3(x.x + x.y, y.x + y.y, -(distances.x + distances.y)) * 0.5;
    precise vec3 v = center - apex;
    // No root is needed for no less than the length of a vector of ordered components.
    float most = max(half_size.x, max(half_size.y, half_size.z));
    float least = min(half_size.x, min(half_size.y, half_size.z));
    precise float middle = (half_size.x + half_size.y + half_size.z) - most - least;
    precise float b = middle * 0.41422;
    precise float c = least * 0.31784;
    precise float radius = most + b + c;
    precise float ax = v.y * axis.z;
    precise float ay = v.z * axis.x;
    precise float az = v.x * axis.y;
    precise float bx = v.z * axis.y;
    precise float by = v.x * axis.z;
    precise float bz = v.y * axis.x;
    precise float cx = ax - bx;
    precise float cy = ay - by;
    precise float cz = az - bz;
    precise float cx2 = cx * cx;
    precise float cy2 = cy * cy;
    precise float cz2 = cz * cz;
    precise float sum = cx2 + cy2;
    precise float across2 = sum + cz2;
    precise float vx = v.x * axis.x;
    precise float vy = v.y * axis.y;
    precise float vz = v.z * axis.z;
    precise float part = vx + vy;
    precise float along = part + vz;
    precise float tilt = along * shape.y;
    precise float slack = radius + axis.w;
    precise float reach = (slack + tilt) * 1.00001;
    precise float cos2 = shape.x * shape.x;
    precise float left = cos2 * across2;
    precise float right = reach * reach;
    // A light that is no spot, or wider than a right angle, has a cosine of -1.
    return !(shape.x > 0.0 && (reach < 0.0 || left > right));
}
#endif
