// A pixel.
layout(constant_id = 25) const uint SAMPLES = 1u;

// Where a sample lies from the middle of its pixel, in pixels: the standard locations (math/samples.rs).
vec2 sample_offset(uint index) {
    const vec2 two[2] = vec2[2](vec2(12.0, 12.0), vec2(4.0, 4.0));
    const vec2 four[4] = vec2[4](vec2(6.0, 2.0), vec2(14.0, 6.0), vec2(2.0, 10.0), vec2(10.0, 14.0));
    const vec2 eight[8] = vec2[8](vec2(9.0, 5.0), vec2(7.0, 11.0), vec2(13.0, 9.0), vec2(5.0, 3.0), vec2(3.0, 13.0),
        vec2(1.0, 7.0), vec2(11.0, 15.0), vec2(15.0, 1.0));
    vec2 at = vec2(8.0);
    if (SAMPLES == 2u) {
        at = two[index];
    } else if (SAMPLES == 4u) {
        at = four[index];
    } else if (SAMPLES == 8u) {
        at = eight[index];
    }
    return at * 0.0625 - 0.5;
}
