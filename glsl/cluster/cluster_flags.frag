#version 460
#extension GL_GOOGLE_include_directive : require
// A blended fragment that no opaque surface hides flags its cluster.
#include "base.glsl"
#include "cluster_slice.glsl"

// Hidden fragments are not run.
layout(early_fragment_tests) in;

layout(constant_id = 20) const uint TILE = 16u;

layout(set = 0, binding = 2, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 3, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 4, scalar) writeonly buffer Flags { uint data[]; } cluster_flags;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy) / TILE;
    uint tile = at.y * grid.data.columns + at.x;
    cluster_flags.data[tile * clusters.data.slices + cluster_slice(grid.data, clusters.data, gl_FragCoord.z)] = 1u;
}
