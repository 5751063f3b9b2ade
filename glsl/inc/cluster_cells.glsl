// Where the texels of a cluster lie in the image of cells: range of its tile's list and distances; then its box (low and high across, low
// and high up), or without one the columns and rows of its tile.
ivec2 cell_at(uint cluster, uint texel) {
    return ivec2(cluster % CELLS_WIDE * CELL_TEXELS + texel, cluster / CELLS_WIDE);
}
