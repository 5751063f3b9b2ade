#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the lights that tile_bin_count counted where the scan says, in id order, and the range of each bin.
#include "base.glsl"
#include "tile_bin.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 3, scalar) readonly buffer Offsets { uint data[]; } bin_offsets;
layout(set = 0, binding = 4, scalar) writeonly buffer Lights { uint data[]; } bin_lights;
layout(set = 0, binding = 5, scalar) writeonly buffer Ranges { uint data[]; } bin_ranges;

void main() {
    uint bin = gl_GlobalInvocationID.x;
    uint chunk = gl_GlobalInvocationID.y;
    uint bins = grid.data.bin_columns * grid.data.bin_rows;
    if (bin >= bins) {
        return;
    }
    uvec2 at = uvec2(bin % grid.data.bin_columns, bin / grid.data.bin_columns);
    uint end = min((chunk + 1u) * LIGHT_CHUNK, grid.data.light_count);
    uint next = bin_offsets.data[bin * grid.data.light_chunks + chunk];
    if (chunk == 0u) {
        bin_ranges.data[bin] = next;
        if (bin == bins - 1u) {
            bin_ranges.data[bins] = bin_offsets.data[bins * grid.data.light_chunks];
        }
    }
    for (uint light = chunk * LIGHT_CHUNK; light < end; ++light) {
        if (in_bin(at, light)) {
            bin_lights.data[next] = light;
            ++next;
        }
    }
}
