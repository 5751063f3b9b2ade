#version 460
#extension GL_GOOGLE_include_directive : require
// Workgroups for as many things as a buffer says there are, as arguments of dispatches: one thread. At least one group, whose threads then
// find that there is nothing to do.
#include "base.glsl"

layout(local_size_x = 1) in;

// Threads a thing; their groups lie along z.
layout(constant_id = 0) const uint LAYERS = 1u;
// Things that there is room for.
layout(constant_id = 1) const uint CAPACITY = 0u;
// Items of a group of scans.
layout(constant_id = 2) const uint SCAN_ITEMS = 2048u;

layout(set = 0, binding = 0, scalar) readonly buffer Total { uint data[]; } total;
layout(set = 0, binding = 1, scalar) writeonly buffer Groups { uint data[]; } groups;
layout(set = 0, binding = 2, scalar) writeonly buffer ScanGroups { uint data[]; } scan_groups;

uint divide_up(uint count, uint by) {
    return count / by + (count % by == 0u ? 0u : 1u);
}

void main() {
    uint count = min(total.data[0], CAPACITY);
    uint rows = max(divide_up(count, ROW_THREADS), 1u);
    groups.data[0] = min(rows, MOST_GROUPS);
    groups.data[1] = divide_up(rows, MOST_GROUPS);
    groups.data[2] = LAYERS;
    scan_groups.data[0] = clamp(divide_up(count * LAYERS, SCAN_ITEMS), 1u, MOST_GROUPS);
    scan_groups.data[1] = 1u;
    scan_groups.data[2] = 1u;
}
