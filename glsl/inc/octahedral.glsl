// Unit vectors as two integers: the octahedron |x| + |y| + |z| = 1 unfolded to a square (Cigolle et al., "A Survey of Efficient
// Representations for Independent Unit Vectors", JCGT 3(2), 2014). Codes 0 to 2^bits - 2 stand for -1 to 1, so that 0 has one of its own
// and the six axes are exact. CPU twin: reference/octahedral.rs.

float octahedral_half(uint bits) {
    return float((1u << (bits - 1u)) - 1u);
}

// Turns the lower half of the octahedron outwards over the diagonals of the square, and back.
vec2 octahedral_fold(vec2 p) {
    precise vec2 folded = 1.0 - abs(p.yx);
    return vec2(p.x < 0.0 ? -folded.x : folded.x, p.y < 0.0 ? -folded.y : folded.y);
}

uvec2 encode_octahedral(vec3 n, uint bits) {
    precise vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    p = n.z < 0.0 ? octahedral_fold(p) : p;
    float most = octahedral_half(bits);
    precise vec2 steps = floor(p * most + 0.5);
    return uvec2(clamp(steps, -most, most) + most);
}

// Finite and of unit length for every code, the one that is never stored included.
vec3 decode_octahedral(uvec2 code, uint bits) {
    float most = octahedral_half(bits);
    precise vec2 p = min(vec2(code) - most, most) / most;
    precise float z = 1.0 - abs(p.x) - abs(p.y);
    precise vec3 n = vec3(z < 0.0 ? octahedral_fold(p) : p, z);
    // At least 1/3: the corners of the octahedron's faces are at distance 1, their middles at 1/sqrt(3).
    precise float length2 = dot(n, n);
    precise vec3 unit = n / sqrt(length2);
    return unit;
}
