// What both passes that sort lists are told.
#include "cluster_thread.glsl"

// A buffer says how many lists there are; else the push constants do.
layout(constant_id = 0) const bool COUNTED = false;

layout(push_constant, scalar) uniform Push { ListSortPush data; } push;
layout(set = 0, binding = 3, scalar) readonly buffer Total { uint data[]; } total;

// Never more than there is room for.
uint count_lists() {
    return COUNTED ? min(total.data[0], push.data.list_count) : push.data.list_count;
}
