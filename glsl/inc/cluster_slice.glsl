// The slice of a stored depth, by integers alone for a perspective lens. CPU twin: reference/cluster_keys.rs.

// Clamped before anything becomes an integer: nothing nearer than the near plane has a slice ahead of the first, and the last slice is
// unbounded. It never descends as depth falls: each step is rounded one way.
uint cluster_slice(TileGrid grid, ClusterGrid clusters, float depth) {
    uint last = clusters.slices - 1u;
    if (grid.perspective != 0u) {
        // Reversed depth and its offset are far over near distance: its bits are a piecewise linear log2.
        precise float s = max(depth, 0.0) + grid.depth_scale;
        uint bits = min(floatBitsToUint(s), clusters.slice_top);
        return min((clusters.slice_top - bits) >> clusters.slice_shift, last);
    }
    precise float from_near = 1.0 - depth;
    precise float at = from_near * clusters.slice_scale;
    return uint(clamp(at, 0.0, float(last)));
}
