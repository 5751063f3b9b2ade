#version 460
#extension GL_GOOGLE_include_directive : require
// Every sample of a surface flags its cluster: a thread a pixel.
#include "base.glsl"
#include "cluster_slice.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 20) const uint TILE = 16u;
layout(constant_id = 25) const uint SAMPLES = 4u;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 1, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 2) uniform sampler2DMS depth_samples;
layout(set = 0, binding = 3, scalar) writeonly buffer Flags { uint data[]; } cluster_flags;

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= grid.data.width || at.y >= grid.data.height) {
        return;
    }
    uvec2 tile = at / TILE;
    uint first = (tile.y * grid.data.columns + tile.x) * clusters.data.slices;
    for (uint index = 0u; index < SAMPLES; ++index) {
        float depth = texelFetch(depth_samples, ivec2(at), int(index)).x;
        if (depth > 0.0) {
            cluster_flags.data[first + cluster_slice(grid.data, clusters.data, depth)] = 1u;
        }
    }
}
