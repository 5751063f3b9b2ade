// Which lights touch a bin: integer rectangles against each other. Counting and filling are the same walk.
#include "cull_lights.glsl"

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;

// Touches any tile of the bin.
bool in_bin(uvec2 bin, uint light) {
    vec4 tiles = cull_texel(light * CULL_TEXELS + 2u);
    vec2 first = vec2(bin * BIN_TILES);
    vec2 last = first + float(BIN_TILES - 1u);
    return tiles.x <= last.x && tiles.y >= first.x && tiles.z <= last.y && tiles.w >= first.y && tiles.x <= tiles.y
        && tiles.z <= tiles.w;
}
