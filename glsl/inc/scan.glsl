// What both passes of a scan are told.

// A buffer says how many things there are; else the push constants say how many items.
layout(constant_id = 1) const bool COUNTED = false;

layout(push_constant, scalar) uniform Push { ScanPush data; } push;
layout(set = 0, binding = 3, scalar) readonly buffer Total { uint data[]; } total;

// Items of the level, never more than there is room for.
uint count_items() {
    uint room = push.data.item_count;
    if (!COUNTED) {
        return room;
    }
    uint items = total.data[0] * push.data.each;
    return items == 0u ? 0u : min((items - 1u) / push.data.span + 1u, room);
}
