// Blocks of samples: a tile, or 16x16 parts of a larger one in the order of their tile. Making keys and looking them up walk alike.
#include "cluster_slice.glsl"
#include "cluster_thread.glsl"

// Samples whose normals point elsewhere have other keys. `cluster_normals` are codes of the G-buffer.
layout(constant_id = 26) const bool BY_NORMAL = false;

struct Block {
    uint tile;
    uvec2 begin;
    uvec2 end;
};

// Empty where it lies outside of the picture.
Block read_block(uint index) {
    uint parts = clusters.data.tile_parts;
    uint tile = index / (parts * parts);
    uint part = index - tile * parts * parts;
    uvec2 at = uvec2(tile % grid.data.columns, tile / grid.data.columns) * parts + uvec2(part % parts, part / parts);
    uvec2 size = uvec2(grid.data.width, grid.data.height);
    uvec2 begin = min(at * clusters.data.block, size);
    return Block(tile, begin, min(begin + clusters.data.block, size));
}

// Depth is reversed and never negative where something is: 0 is the sky.
bool shows_surface(float depth) {
    return floatBitsToUint(depth) - 1u < 0x7f800000u;
}

// Cells of the octahedron's square: integers alone, so that no driver's square root decides.
uint normal_direction(uvec2 code) {
    uvec2 cell = code >> clusters.data.direction_shift;
    return cell.y << (clusters.data.direction_bits >> 1) | cell.x;
}

// Tile, then slice, then direction, from the highest bits down.
uint cluster_key(uint tile, float depth, uvec2 at) {
    uint direction = BY_NORMAL ? normal_direction(texelFetch(cluster_normals, ivec2(at), 0).xy) : 0u;
    uint slice = cluster_slice(grid.data, clusters.data, depth);
    return tile << clusters.data.slice_bits | slice << clusters.data.direction_bits | direction;
}
