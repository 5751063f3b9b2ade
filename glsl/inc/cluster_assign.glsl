// Which candidates touch a cluster, wherever they come from. Counting and filling are the same walk over the same predicate. CPU twin:
// reference/cluster_assign.rs.
#include "cull_lights.glsl"
#include "cull.glsl"
#include "cull_cone.glsl"
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
    // Of its normals.
    vec3 normal_low;
    vec3 normal_high;
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
    cell.normal_low = vec3(-1.0);
    cell.normal_high = vec3(1.0);
    if (BY_NORMAL) {
        cell.normal_low = uintBitsToFloat(texelFetch(cluster_cells, cell_at(id, 2u), 0).xyz);
        cell.normal_high = uintBitsToFloat(texelFetch(cluster_cells, cell_at(id, 3u), 0).xyz);
    }
    return cell;
}

// The most that the product of two numbers can be, each between its two bounds.
float largest_product(float a_low, float a_high, float b_low, float b_high) {
    precise float a = a_low * b_low;
    precise float b = a_low * b_high;
    precise float c = a_high * b_low;
    precise float d = a_high * b_high;
    return max(max(a, b), max(c, d));
}

// The most that normal and direction to the light can have in common, as far as both are known: of a light behind every sample less than
// nothing. Metres.
float most_facing(Cell cell, vec2 x, vec2 y, vec2 distances, vec3 light) {
    precise vec3 low = light - vec3(x.y, y.y, -distances.x);
    precise vec3 high = light - vec3(x.x, y.x, -distances.y);
    precise float across = largest_product(cell.normal_low.x, cell.normal_high.x, low.x, high.x);
    precise float up = largest_product(cell.normal_low.y, cell.normal_high.y, low.y, high.y);
    precise float along = largest_product(cell.normal_low.z, cell.normal_high.z, low.z, high.z);
    precise float sum = across + up;
    precise float result = sum + along;
    return result;
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
    bool inside = near <= far && box_distance2(x, y, vec2(near, far), sphere.xyz) <= sphere.w;
    if (CULL_CONES) {
        inside = inside && cone_reaches(grid.data.light_count, light, x, y, vec2(near, far));
    }
    if (BY_NORMAL) {
        inside = inside && most_facing(cell, x, y, vec2(near, far), sphere.xyz) >= -extent.w;
    }
    return inside;
}
