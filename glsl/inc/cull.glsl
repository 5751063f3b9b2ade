// Arithmetic that decides membership: add, subtract, multiply, compare and integers only, so that every driver and the CPU twin
// (math/cull.rs) agree to the bit.

// 1 / x for x in [1e-37, 1e37]: a line through the exponent's bits, then three steps of Newton's iteration; within 4 ulp.
float reciprocal(float x) {
    precise float y = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(x));
    for (uint i = 0u; i < 3u; ++i) {
        precise float rest = 2.0 - x * y;
        y = y * rest;
    }
    return y;
}

// Nearest and farthest distance along the view axis of a position whose stored depth is `depth`, widened by what the two may differ by.
vec2 distance_range(TileGrid grid, float depth) {
    precise float low;
    precise float high;
    if (grid.perspective != 0u) {
        precise float y = reciprocal(min(max(depth + grid.depth_scale, 1e-37), 1e30));
        precise float d = grid.depth_offset * y;
        // 1 - e <= 1 / (1 + e), and 1 / (1 - e) <= 1 + 2 e up to a half.
        precise float e = grid.depth_slack * y;
        low = d - d * e;
        high = e < 0.5 ? d + d * (e + e) : FAR_LIMIT;
    } else {
        precise float d = grid.depth_offset - depth * grid.depth_scale;
        precise float e = (grid.depth_slack + DISTANCE_SLACK) * grid.depth_scale;
        low = d - e;
        high = d + e;
    }
    low -= abs(low) * DISTANCE_SLACK;
    high += abs(high) * DISTANCE_SLACK;
    return vec2(low, min(high, FAR_LIMIT));
}

// Slots a metre from `near` to `far`.
float slots_a_metre(float near, float far, uint slots) {
    precise float result = float(slots) * reciprocal(max(far - near, 1e-36));
    return result;
}

// The slot that holds distance `d`. It never descends as d grows, whatever is rounded, and that is all that a mask needs.
uint depth_slot(float near, float slots_a_metre, float d, uint slots) {
    precise float at = (d - near) * slots_a_metre;
    return uint(clamp(at, 0.0, float(slots - 1u)));
}

// Distances between which everything lies that depth_slot puts into slots first to last: its inverse, widened by more than it may round.
// Slots are a power of two, whose reciprocal is made of its exponent: a step is exact.
vec2 slot_distances(float near, float far, uint slots, uint first, uint last) {
    precise float step = (far - near) * uintBitsToFloat((127u - uint(findMSB(slots))) << 23);
    precise float a = float(first) * step;
    precise float b = float(last + 1u) * step;
    precise float begin = near + a;
    precise float end = near + b;
    precise float low = begin - (a * SLOT_SLACK + abs(begin) * DISTANCE_SLACK);
    precise float high = end + (b * SLOT_SLACK + abs(end) * DISTANCE_SLACK);
    // The last slot holds whatever is farther.
    return vec2(low, last + 1u < slots ? high : far);
}

// Bits first to last of a 64-bit mask. Shifts stay below 32: past it their result is undefined.
uvec2 slot_mask(uint first, uint last) {
    uint up = 0xffffffffu << (first & 31u);
    uint down = 0xffffffffu >> (31u - (last & 31u));
    uvec2 from = first < 32u ? uvec2(up, 0xffffffffu) : uvec2(0u, up);
    uvec2 until = last < 32u ? uvec2(down, 0u) : uvec2(0xffffffffu, down);
    return from & until;
}

// Signed distance of a point from the plane through the eye and an edge of the tile grid: (tangent, normal across, normal along z,
// offset), with the normal to growing columns or rows.
float edge_distance(vec4 edge, float across, float z) {
    precise float a = edge.y * across;
    precise float b = edge.z * z;
    precise float sum = a + b;
    precise float result = sum - edge.w;
    return result;
}

// Distance from a coordinate to an interval, 0 within.
float interval_distance(float low, float high, float x) {
    precise float below = low - x;
    precise float above = x - high;
    return max(max(below, above), 0.0);
}

// Squared distance from a point in view space to a box: low and high across, up, and along the view axis.
float box_distance2(vec2 across, vec2 up, vec2 distances, vec3 point) {
    precise float dx = interval_distance(across.x, across.y, point.x);
    precise float dy = interval_distance(up.x, up.y, point.y);
    precise float dz = interval_distance(distances.x, distances.y, -point.z);
    precise float dx2 = dx * dx;
    precise float dy2 = dy * dy;
    precise float dz2 = dz * dz;
    precise float sum = dx2 + dy2;
    precise float result = sum + dz2;
    return result;
}

// What lies between two edges from `near` to `far`.
vec2 edge_interval(TileGrid grid, float first, float last, float near, float far) {
    if (grid.perspective == 0u) {
        return vec2(min(first, last), max(first, last));
    }
    precise float a = first * near;
    precise float b = first * far;
    precise float c = last * near;
    precise float d = last * far;
    return vec2(min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
}
