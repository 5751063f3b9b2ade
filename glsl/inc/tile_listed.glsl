// Whether the lists of a tile hold every light that reaches a position. Comes after cull.glsl and SAMPLES. With one sample a pixel they do: the
// position is that sample's. Between several samples it may lie where none does.
layout(constant_id = 27) const uint DEPTH_BOUNDS = BOUNDS_OFF;
layout(constant_id = 28) const uint DEPTH_SLOTS = 32u;

// Nearest and farthest distance as bits, and the mask of slots.
layout(set = 0, binding = 15) uniform usampler2D tile_bounds;

bool is_listed(uvec2 tile, float d) {
    if (SAMPLES == 1u || DEPTH_BOUNDS == BOUNDS_OFF) {
        return true;
    }
    uvec4 bounds = texelFetch(tile_bounds, ivec2(tile), 0);
    float near = uintBitsToFloat(bounds.x);
    float far = uintBitsToFloat(bounds.y);
    uint slot = depth_slot(near, slots_a_metre(near, far, DEPTH_SLOTS), d, DEPTH_SLOTS);
    uvec2 held = slot_mask(slot, slot) & bounds.zw;
    return near <= d && d <= far && (held.x | held.y) != 0u;
}
