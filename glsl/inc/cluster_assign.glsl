// Which candidates touch a cluster, wherever they come from. Counting and filling are the same walk over the same predicate. CPU twin:
// reference/cluster_assign.rs.
#include "cull_lights.glsl"
#include "cull.glsl"
#include "cluster_cells.glsl"
#include "cluster_thread.glsl"

layout(constant_id = 22) const bool EXPLICIT = true;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 6) uniform usamplerBuffer cluster_total;
layout(set = 0, binding = 7) uniform usampler2D cluster_cells;
// Columns and then rows, one more than there are tiles; the tangent comes first.
layout(set = 0, binding = 8) uniform samplerBuffer tile_edges;

struct Cell {
    // First of the list of its tile and the one behind the last, or the tile's column and row.
    uvec2 source;
    float near;
    float far;
    // The box across and up, or without one the tangents of the tile's edges.
    vec2 across;
    vec2 up;
};

Cell read_cell(uint id) {
    uvec4 first = texelFetch(cluster_cells, cell_at(id, 0u), 0);
    uvec4 second = texelFetch(cluster_cells, cell_at(id, 1u), 0);
    Cell cell;
    cell.source = first.xy;
    cell.near = uintBitsToFloat(first.z);
    cell.far = uintBitsToFloat(first.w);
    vec4 around = uintBitsToFloat(second);
    if (!EXPLICIT) {
        int column = int(second.x);
        int row = int(grid.data.columns + 1u + second.y);
        around = vec4(texelFetch(tile_edges, column).x, texelFetch(tile_edges, column + 1).x,
            texelFetch(tile_edges, row).x, texelFetch(tile_edges, row + 1).x);
    }
    cell.across = around.xy;
    cell.up = around.zw;
    return cell;
}

// A culled light, by index.
bool touches(Cell cell, uint light) {
    vec4 sphere = cull_texel(light * CULL_TEXELS);
    vec4 extent = cull_texel(light * CULL_TEXELS + 1u);
    float near = max(cell.near, extent.x);
    float far = min(cell.far, extent.y);
    vec2 x = cell.across;
    vec2 y = cell.up;
    if (!EXPLICIT) {
        x = edge_interval(grid.data, x.x, x.y, near, far);
        y = edge_interval(grid.data, y.x, y.y, near, far);
    }
    return near <= far && box_distance2(x, y, vec2(near, far), sphere.xyz) <= sphere.w;
}
