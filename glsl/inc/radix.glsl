// Blocks and digits of the radix sort: counting and moving are the same walk.
layout(constant_id = 0) const bool SOURCE_PAIRS = false;

layout(push_constant, scalar) uniform Push { RadixPush data; } push;

// First key of a block and the one behind its last, of `count` keys in all.
uvec2 radix_block(uint block, uint count) {
    uint first = min(block * RADIX_BLOCK, count);
    return uvec2(first, first + min(RADIX_BLOCK, count - first));
}

uint radix_digit(uint key) {
    return (key >> push.data.shift) & push.data.mask;
}

// Where a block's number of keys with a digit stands: by digit first, so that the scan gives each block its place among keys
// with the same digit.
uint radix_place(uint digit, uint block) {
    return digit * push.data.block_count + block;
}
