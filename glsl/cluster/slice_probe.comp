#version 460
#extension GL_GOOGLE_include_directive : require
// The slices of depths that a check asks for: 256 ulp and fewer on either side of each boundary, and numbers of every size and sign.
// CPU twin: `probe_depth` of reference/cluster_keys.rs.
#include "base.glsl"

layout(local_size_x = 64) in;

// Of reversed depth between the boundaries of linear slices.
layout(constant_id = 0) const float SLICE_STEP = 0.0;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2, scalar) writeonly buffer Slices { uint data[]; } slices;

#include "cluster_slice.glsl"

float probe_depth(uint index) {
    uint slice = index / PROBE_DEPTHS;
    uint place = index - slice * PROBE_DEPTHS;
    if (slice == clusters.data.slices) {
        return uintBitsToFloat((place >> 1) * 0x7f8000u | (place & 1u) << 31);
    }
    precise float boundary = 1.0 - float(slice) * SLICE_STEP;
    if (grid.data.perspective != 0u) {
        float s = uintBitsToFloat(clusters.data.slice_top - (slice << clusters.data.slice_shift));
        boundary = s - grid.data.depth_scale;
    }
    uint bits = floatBitsToUint(max(boundary, 0.0)) + place;
    return uintBitsToFloat(bits - min(bits, PROBE_DEPTHS / 2u));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < (clusters.data.slices + 1u) * PROBE_DEPTHS) {
        slices.data[index] = cluster_slice(grid.data, clusters.data, probe_depth(index));
    }
}
