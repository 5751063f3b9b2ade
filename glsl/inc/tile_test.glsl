// Whether a light reaches a tile. Comes after cull_lights.glsl, cull.glsl and the declarations of CULL, `grid` and `tile_edges`: columns
// and then rows, one more than there are tiles, (tangent, normal across, normal along z, offset). CPU twin: reference/tile_cull.rs.

#include "cull_cone.glsl"

struct TileEdges {
    vec4 left;
    vec4 right;
    vec4 top;
    vec4 bottom;
};

TileEdges read_edges(uvec2 at) {
    int column = int(at.x);
    int row = int(grid.data.columns + 1u + at.y);
    return TileEdges(texelFetch(tile_edges, column), texelFetch(tile_edges, column + 1), texelFetch(tile_edges, row),
        texelFetch(tile_edges, row + 1));
}

// `distances` are those that tile and light have in common.
bool reaches_tile(TileEdges edges, uvec2 tile, uint light, vec4 sphere, float radius, vec2 distances) {
    if (CULL == CULL_RECTANGLE) {
        vec4 tiles = cull_texel(light * CULL_TEXELS + 2u);
        vec2 at = vec2(tile);
        return tiles.x <= at.x && at.x <= tiles.y && tiles.z <= at.y && at.y <= tiles.w;
    }
    bool inside = edge_distance(edges.left, sphere.x, sphere.z) >= -radius
        && edge_distance(edges.right, sphere.x, sphere.z) <= radius
        && edge_distance(edges.top, sphere.y, sphere.z) >= -radius
        && edge_distance(edges.bottom, sphere.y, sphere.z) <= radius;
    if (CULL == CULL_PLANES_BOX) {
        vec2 x = edge_interval(grid.data, edges.left.x, edges.right.x, distances.x, distances.y);
        vec2 y = edge_interval(grid.data, edges.top.x, edges.bottom.x, distances.x, distances.y);
        inside = inside && box_distance2(x, y, distances, sphere.xyz) <= sphere.w;
        if (CULL_CONES) {
            inside = inside && cone_reaches(grid.data.light_count, light, x, y, distances);
        }
    }
    return inside;
}
