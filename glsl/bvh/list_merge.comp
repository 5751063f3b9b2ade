#version 460
#extension GL_GOOGLE_include_directive : require
// Merges each two neighbouring sorted runs of a long list into one: a thread a list and pair of runs.
#include "base.glsl"

layout(local_size_x = 64) in;

#include "list_sort.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Offsets { uint data[]; } list_offsets;
layout(set = 0, binding = 1, scalar) readonly buffer Runs { uint data[]; } runs;
layout(set = 0, binding = 2, scalar) writeonly buffer Merged { uint data[]; } merged;

void main() {
    uint list = thread_index();
    if (list >= count_lists()) {
        return;
    }
    uint list_begin = list_offsets.data[list * push.data.stride];
    uint list_end = list_offsets.data[(list + 1u) * push.data.stride];
    uint begin = list_begin + gl_WorkGroupID.z * 2u * push.data.width;
    if (list_end - list_begin <= push.data.sorted || begin >= list_end) {
        return;
    }
    uint middle = min(begin + push.data.width, list_end);
    uint end = min(middle + push.data.width, list_end);
    uint left = begin;
    uint right = middle;
    for (uint at = begin; at < end; ++at) {
        bool from_left = right >= end || (left < middle && runs.data[left] <= runs.data[right]);
        merged.data[at] = runs.data[from_left ? left : right];
        left += from_left ? 1u : 0u;
        right += from_left ? 0u : 1u;
    }
}
