// Where the texels of a cluster lie in the image of cells: range of its tile's list, or the tile's column and row where candidates come
// from the light hierarchy, and distances; then its box (low and high across, low and high up), or without one column and row of its
// tile; where clusters tell directions, the least and the greatest of each coordinate of their normals.
layout(constant_id = 26) const bool BY_NORMAL = false;

ivec2 cell_at(uint cluster, uint texel) {
    uint wide = BY_NORMAL ? NORMAL_CELLS_WIDE : CELLS_WIDE;
    uint texels = BY_NORMAL ? NORMAL_CELL_TEXELS : CELL_TEXELS;
    return ivec2(cluster % wide * texels + texel, cluster / wide);
}
