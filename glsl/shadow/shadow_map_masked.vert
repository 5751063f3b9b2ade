#version 460
#extension GL_GOOGLE_include_directive : require
#include "base.glsl"
#define MAP_PUSH
#include "surface_vertex.glsl"
