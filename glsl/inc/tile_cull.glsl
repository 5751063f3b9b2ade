// Which lights of its bin touch a tile. Counting and filling are the same walk over the same predicate. CPU twin:
// reference/tile_cull.rs.
#include "cull_lights.glsl"
#include "cull.glsl"

layout(constant_id = 21) const uint LIST_FETCH = WORDS_TEXEL;
layout(constant_id = 22) const uint CULL = CULL_PLANES_BOX;
layout(constant_id = 23) const uint DEPTH_BOUNDS = BOUNDS_MASK;
layout(constant_id = 24) const uint DEPTH_SLOTS = 32u;

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
layout(set = 0, binding = 3, scalar) readonly buffer BinLights { uint data[]; } bin_lights_storage;
layout(set = 0, binding = 4) uniform usamplerBuffer bin_lights_texel;
layout(set = 0, binding = 5) uniform usamplerBuffer bin_ranges;
layout(set = 0, binding = 6) uniform samplerBuffer tile_edges;
// Nearest and farthest distance as bits, and the mask of slots.
layout(set = 0, binding = 7) uniform usampler2D tile_bounds;

#include "tile_test.glsl"

struct Tile {
    uvec2 at;
    float near;
    float far;
    float slots_a_metre;
    uvec2 mask;
    TileEdges edges;
};

Tile read_tile(uvec2 at) {
    Tile tile;
    tile.at = at;
    tile.near = grid.data.near;
    tile.far = grid.data.far;
    tile.slots_a_metre = 0.0;
    tile.mask = uvec2(0xffffffffu);
    if (DEPTH_BOUNDS != BOUNDS_OFF) {
        uvec4 bounds = texelFetch(tile_bounds, ivec2(at), 0);
        tile.near = uintBitsToFloat(bounds.x);
        tile.far = uintBitsToFloat(bounds.y);
        tile.mask = bounds.zw;
        tile.slots_a_metre = slots_a_metre(tile.near, tile.far, DEPTH_SLOTS);
    }
    tile.edges = read_edges(at);
    return tile;
}

uint bin_light(uint at) {
    if (LIST_FETCH == WORDS_STORAGE) {
        return bin_lights_storage.data[at];
    }
    return texelFetch(bin_lights_texel, int(at)).x;
}

bool intersects(Tile tile, uint light) {
    vec4 sphere = cull_texel(light * CULL_TEXELS);
    vec4 extent = cull_texel(light * CULL_TEXELS + 1u);
    float near = max(tile.near, extent.x);
    float far = min(tile.far, extent.y);
    bool inside = near <= far;
    if (DEPTH_BOUNDS == BOUNDS_MASK) {
        uint first = depth_slot(tile.near, tile.slots_a_metre, near, DEPTH_SLOTS);
        uint last = depth_slot(tile.near, tile.slots_a_metre, far, DEPTH_SLOTS);
        uvec2 shared_slots = slot_mask(first, last) & tile.mask;
        inside = inside && (shared_slots.x | shared_slots.y) != 0u;
        // Nothing lies in the slots before the first that is shared and after the last.
        first = shared_slots.x != 0u ? uint(findLSB(shared_slots.x)) : 32u + uint(max(findLSB(shared_slots.y), 0));
        last = shared_slots.y != 0u ? 32u + uint(findMSB(shared_slots.y)) : uint(max(findMSB(shared_slots.x), 0));
        vec2 held = slot_distances(tile.near, tile.far, DEPTH_SLOTS, first, last);
        near = max(near, held.x);
        far = min(far, held.y);
    }
    return inside && reaches_tile(tile.edges, tile.at, light, sphere, extent.z, vec2(near, far));
}

// The tile of this thread: a workgroup is a bin, and a run of its list by y.
bool tile_of_thread(out uvec2 at, out uint begin, out uint end) {
    uint bin = gl_WorkGroupID.x;
    uvec2 bin_at = uvec2(bin % grid.data.bin_columns, bin / grid.data.bin_columns);
    at = bin_at * BIN_TILES + gl_LocalInvocationID.xy;
    begin = texelFetch(bin_ranges, int(bin)).x + gl_WorkGroupID.y * LIST_CHUNK;
    end = min(texelFetch(bin_ranges, int(bin) + 1).x, begin + LIST_CHUNK);
    return at.x < grid.data.columns && at.y < grid.data.rows;
}
