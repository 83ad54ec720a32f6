// Writing leaves of the packed tree. Wants args.scale and the buffers raw, source, order, triangles.
#include "lib/triangle.glsl"

layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

const Aabb EMPTY = Aabb(vec3(3.4e38), vec3(-3.4e38));

uint leaf_reference(uint first, uint count) { return LEAF_BIT | (count - 1) << (31 - LEAF_BITS) | first; }

// The triangle of a Morton rank to place `to`.
void pack_triangle(uint rank, uint to) {
    uint t = P(order).at[rank];
    for (uint k = 0; k < 9; ++k) {
        P(triangles).at[TRIANGLE_WORDS * to + k] = floatBitsToUint(P(source).at[9 * t + k] * args.scale);
    }
    P(triangles).at[TRIANGLE_WORDS * to + 9] = t;
}

// All triangles below child, from place `to` on, left to right. Returns how many.
uint pack_leaf(uint child, uint to) {
    uint first = to;
    // Nodes above the current one whose right side waits: a chain of MAX_LEAF triangles is the deepest.
    uint stack[MAX_LEAF];
    uint top = 0;
    for (;;) {
        while (child < LEAF_BIT) {
            stack[top++] = P(raw).at[child].right;
            child = P(raw).at[child].left;
        }
        pack_triangle(child & ~LEAF_BIT, to++);
        if (top == 0) return to - first;
        child = stack[--top];
    }
}
