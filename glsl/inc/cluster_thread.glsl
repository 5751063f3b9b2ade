// Threads in groups of 64 that lie in rows, because a row has at most 65,535 groups.
uint thread_index() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
}
