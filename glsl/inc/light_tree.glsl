// A walk through the light hierarchy without a stack: depth and index say where it stands, and the digits of the index to base 8
// how far it climbs. One step visits one node and has no loop, so that lanes in lock step do not wait for each other's nodes:
//
//     TreeWalk walk = tree_begin(root, root + 1u);
//     uint light;
//     while (tree_step(walk, low, high, light)) {
//         if (light != TREE_NO_LIGHT && intersects(cell, light)) { ... }
//     }
//
// Boxes are in view space, where z is negative in front of the eye. CPU twin: reference/light_tree.rs.
layout(constant_id = 30) const uint TREE_FETCH = WORDS_TEXEL;

layout(set = 0, binding = 14, scalar) readonly buffer LightTreeStorage { vec4 texels[]; } light_tree_storage;
layout(set = 0, binding = 15) uniform samplerBuffer light_tree_texel;

struct TreeWalk {
    // Next of the lights that every walk tests, and where they end.
    uint everywhere;
    uint everywhere_end;
    // Next node; its entry is level_base + root_count * (nodes of a root above the depth) + index.
    bool more;
    uint depth;
    uint index;
    uint level_base;
    uint root_count;
    uint height;
    // Light behind the last below the roots of this walk.
    uint light_end;
};

vec4 tree_texel(uint index) {
    if (TREE_FETCH == WORDS_STORAGE) {
        return light_tree_storage.texels[index];
    }
    return texelFetch(light_tree_texel, int(index));
}

// A walk below roots first to end; the one that has root 0 also meets the lights outside the hierarchy.
TreeWalk tree_begin(uint first_root, uint end_root) {
    uvec4 shape = uvec4(tree_texel(0u));
    uint roots_end = min(end_root, shape.w);
    TreeWalk walk;
    walk.everywhere = 0u;
    walk.everywhere_end = first_root == 0u ? shape.x : 0u;
    walk.more = first_root < roots_end;
    walk.depth = 0u;
    walk.index = first_root;
    walk.level_base = shape.x;
    walk.root_count = shape.w;
    walk.height = shape.z;
    walk.light_end = min(shape.y, roots_end << (TREE_SHIFT * shape.z));
    return walk;
}

// Goes to the next node that does not lie below this one.
void tree_pass(inout TreeWalk walk) {
    uint level_end = ((walk.light_end - 1u) >> (TREE_SHIFT * (walk.height - walk.depth))) + 1u;
    walk.more = walk.index + 1u < level_end;
    // Each low digit 7 is a last child, whose parent is passed too.
    uint climb = min(uint(findLSB(~walk.index)) / TREE_SHIFT, walk.depth);
    walk.index = (walk.index >> (TREE_SHIFT * climb)) + 1u;
    walk.depth -= climb;
}

// Visits one node; false when there is none left. `light` is a light whose box touches the box from low to high, as an index among the
// culled lights, or TREE_NO_LIGHT. Each light comes at most once a walk; those whose sphere reaches into the box all come.
bool tree_step(inout TreeWalk walk, vec3 low, vec3 high, out uint light) {
    light = TREE_NO_LIGHT;
    bool everywhere = walk.everywhere < walk.everywhere_end;
    if (!everywhere && !walk.more) {
        return false;
    }
    uint above = walk.root_count * (TREE_ABOVE & ((1u << (TREE_SHIFT * walk.depth)) - 1u));
    uint entry = everywhere ? walk.everywhere : walk.level_base + above + walk.index;
    vec4 box_low = tree_texel(TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * entry);
    vec4 box_high = tree_texel(TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * entry + 1u);
    bool touches = all(lessThanEqual(box_low.xyz, high)) && all(lessThanEqual(low, box_high.xyz));
    bool single = everywhere || walk.depth == walk.height;
    if (touches && single) {
        light = uint(box_low.w);
    }
    if (everywhere) {
        ++walk.everywhere;
    } else if (touches && !single) {
        ++walk.depth;
        walk.index *= TREE_WIDTH;
    } else {
        tree_pass(walk);
    }
    return true;
}
