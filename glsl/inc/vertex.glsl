// Vertex transform of every geometry pass. Depth pre-pass and shading must agree bit for bit, so it exists once.
layout(set = 0, binding = 0, scalar) uniform FrameBlock { Frame data; } frame;
layout(set = 0, binding = 1, scalar) readonly buffer InstanceBlock { InstanceData data[]; } instances;

#ifdef MAP_PUSH
// The picture is that of a light.
layout(push_constant, scalar) uniform Push { MapPush data; } push;
#endif

layout(location = 0) in vec3 in_position;

invariant gl_Position;

vec3 vertex_position_vs(InstanceData instance, vec3 position) {
    precise vec3 p = instance.object_to_view_x * position.x + instance.object_to_view_y * position.y
        + instance.object_to_view_z * position.z + instance.object_to_view_w;
    return p;
}

vec4 vertex_position_cs(vec3 position_vs) {
#ifdef MAP_PUSH
    precise vec4 p = push.data.view_to_map * vec4(position_vs, 1.0);
#else
    precise vec4 p = frame.data.view_to_clip * vec4(position_vs, 1.0);
#endif
    return p;
}
