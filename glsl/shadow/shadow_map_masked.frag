#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of surfaces with holes as a light sees it: alpha is read, nothing is stored.
#include "base.glsl"
#include "surface.glsl"

void main() {
    read_surface();
}
