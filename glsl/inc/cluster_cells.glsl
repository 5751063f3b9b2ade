// Where the texels of a cluster lie in the image of cells: range of its tile's list, or the tile's column and row where candidates come from
// the light hierarchy, and distances; then its box (low and high across, low and high up), or without one column and row of its tile.
ivec2 cell_at(uint cluster, uint texel) {
    return ivec2(cluster % CELLS_WIDE * CELL_TEXELS + texel, cluster / CELLS_WIDE);
}
