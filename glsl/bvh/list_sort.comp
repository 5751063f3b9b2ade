#version 460
#extension GL_GOOGLE_include_directive : require
// Sorts a run of a list in place, ascending: a thread a list and run. Short runs by insertion, others on a heap (J. Williams,
// "Algorithm 232: Heapsort", CACM 7(6), 1964), which takes n log n steps whatever the order was.
#include "base.glsl"

layout(local_size_x = 64) in;

#include "list_sort.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Offsets { uint data[]; } list_offsets;
layout(set = 0, binding = 1, scalar) buffer Lists { uint data[]; } lists;

void insertion_sort(uint begin, uint count) {
    uint items[LIST_INSERTION];
    for (uint i = 0u; i < count; ++i) {
        uint item = lists.data[begin + i];
        uint at = i;
        for (; at > 0u; --at) {
            uint before = items[at - 1u];
            if (before <= item) {
                break;
            }
            items[at] = before;
        }
        items[at] = item;
    }
    for (uint i = 0u; i < count; ++i) {
        lists.data[begin + i] = items[i];
    }
}

// Lets the item at `at` sink until no child is larger.
void sink(uint begin, uint at, uint count) {
    uint item = lists.data[begin + at];
    for (uint child = 2u * at + 1u; child < count; child = 2u * at + 1u) {
        uint largest = lists.data[begin + child];
        if (child + 1u < count) {
            uint right = lists.data[begin + child + 1u];
            child += right > largest ? 1u : 0u;
            largest = max(right, largest);
        }
        if (largest <= item) {
            break;
        }
        lists.data[begin + at] = largest;
        at = child;
    }
    lists.data[begin + at] = item;
}

void heap_sort(uint begin, uint count) {
    for (uint at = count / 2u; at > 0u; --at) {
        sink(begin, at - 1u, count);
    }
    for (uint last = count - 1u; last > 0u; --last) {
        uint item = lists.data[begin + last];
        lists.data[begin + last] = lists.data[begin];
        lists.data[begin] = item;
        sink(begin, 0u, last);
    }
}

void main() {
    uint list = thread_index();
    if (list >= count_lists()) {
        return;
    }
    uint begin = list_offsets.data[list * push.data.stride] + gl_WorkGroupID.z * LIST_SORT_RUN;
    uint end = list_offsets.data[(list + 1u) * push.data.stride];
    if (begin >= end) {
        return;
    }
    uint count = min(end - begin, LIST_SORT_RUN);
    if (count <= LIST_INSERTION) {
        insertion_sort(begin, count);
    } else {
        heap_sort(begin, count);
    }
}
