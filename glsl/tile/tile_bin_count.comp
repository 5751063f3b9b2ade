#version 460
#extension GL_GOOGLE_include_directive : require
// Lights of one run that touch a bin: a thread a bin and run.
#include "base.glsl"
#include "tile_bin.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 3, scalar) writeonly buffer Counts { uint data[]; } bin_counts;

void main() {
    uint bin = gl_GlobalInvocationID.x;
    uint chunk = gl_GlobalInvocationID.y;
    if (bin >= grid.data.bin_columns * grid.data.bin_rows) {
        return;
    }
    uvec2 at = uvec2(bin % grid.data.bin_columns, bin / grid.data.bin_columns);
    uint end = min((chunk + 1u) * LIGHT_CHUNK, grid.data.light_count);
    uint count = 0u;
    for (uint light = chunk * LIGHT_CHUNK; light < end; ++light) {
        count += in_bin(at, light) ? 1u : 0u;
    }
    bin_counts.data[bin * grid.data.light_chunks + chunk] = count;
}
