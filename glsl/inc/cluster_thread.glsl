// Threads in groups that lie in rows, because a row has at most MOST_GROUPS of them.
uint thread_index() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * ROW_THREADS + gl_LocalInvocationID.x;
}
