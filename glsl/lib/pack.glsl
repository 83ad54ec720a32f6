// Writing leaves of the packed tree. Wants lib/raw.glsl and the buffers raw, order, sequence.
layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

uint leaf_reference(uint first, uint count) { return LEAF_BIT | (count - 1) << (31 - LEAF_BITS) | first; }

// Input indices of all triangles below child, from place `to` on, left to right. Returns how many.
uint pack_leaf(uint child, uint to) {
    uint first = to;
    // Nodes above the current one whose right side waits: a chain of MAX_LEAF triangles is the deepest.
    uint stack[MAX_LEAF];
    uint top = 0;
    for (;;) {
        while (child < LEAF_BIT) {
            uvec2 children = CHILDREN(child & RAW_MASK);
            stack[top++] = children.y;
            child = children.x;
        }
        P(sequence).at[to++] = P(order).at[child & ~LEAF_BIT];
        if (top == 0) return to - first;
        child = stack[--top];
    }
}
