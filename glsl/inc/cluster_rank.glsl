// Where the rank of a slice of a tile lies.
ivec2 rank_at(uint id) {
    return ivec2(id % CELLS_WIDE, id / CELLS_WIDE);
}
