#version 460
#extension GL_GOOGLE_include_directive : require
// The light's colour, whatever its intensity.
layout(location = 0) flat in vec3 in_color;
layout(location = 0) out vec4 out_radiance;

void main() {
    out_radiance = vec4(in_color, 1.0);
}
