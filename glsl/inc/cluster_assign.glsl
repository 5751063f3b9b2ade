// Which candidates touch a cluster. Counting and filling are the same walk over the same predicate. CPU twin:
// reference/cluster_assign.rs.
#include "cull_lights.glsl"
#include "cull.glsl"
#include "cluster_cells.glsl"
#include "cluster_thread.glsl"

layout(constant_id = 21) const uint LIST_FETCH = WORDS_TEXEL;
layout(constant_id = 22) const bool EXPLICIT = true;
// Where candidates come from.
layout(constant_id = 23) const uint ASSIGN = ASSIGN_TILE;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 3, scalar) readonly buffer TileLights { uint data[]; } tile_lights_storage;
layout(set = 0, binding = 4) uniform usamplerBuffer tile_lights_texel;
layout(set = 0, binding = 5, scalar) uniform ClusterBlock { ClusterGrid data; } clusters;
layout(set = 0, binding = 6) uniform usamplerBuffer cluster_total;
layout(set = 0, binding = 7) uniform usampler2D cluster_cells;
// Columns and then rows, one more than there are tiles; the tangent comes first.
layout(set = 0, binding = 8) uniform samplerBuffer tile_edges;

struct Cell {
    // In the list of its tile; empty where candidates come from elsewhere.
    uint begin;
    uint end;
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
    cell.begin = ASSIGN == ASSIGN_TILE ? first.x : 0u;
    cell.end = ASSIGN == ASSIGN_TILE ? first.y : 0u;
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

// Id of a light in the list of a tile.
uint tile_light(uint at) {
    if (LIST_FETCH == WORDS_STORAGE) {
        return tile_lights_storage.data[at];
    }
    return texelFetch(tile_lights_texel, int(at)).x;
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
    precise float dx = interval_distance(x.x, x.y, sphere.x);
    precise float dy = interval_distance(y.x, y.y, sphere.y);
    precise float dz = interval_distance(near, far, -sphere.z);
    precise float dx2 = dx * dx;
    precise float dy2 = dy * dy;
    precise float dz2 = dz * dz;
    precise float sum = dx2 + dy2;
    precise float d2 = sum + dz2;
    return near <= far && d2 <= sphere.w;
}
