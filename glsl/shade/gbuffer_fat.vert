#version 460
#extension GL_GOOGLE_include_directive : require
#include "base.glsl"
#include "surface_vertex.glsl"
