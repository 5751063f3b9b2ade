// What every shader starts with.
#extension GL_EXT_scalar_block_layout : require
#include "shared.glsl"

const float PI = 3.14159265358979;
