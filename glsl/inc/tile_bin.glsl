// Which lights touch a bin. Counting and filling are the same walk.
#include "cull_lights.glsl"

layout(set = 0, binding = 0, scalar) uniform GridBlock { TileGrid data; } grid;
