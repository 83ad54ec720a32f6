// Writing leaves of the packed tree. Wants args.scale and the buffers raw, source, order, triangles.
#include "lib/triangle.glsl"

// Count, with COLLAPSED_BIT, of a raw node; its children.
#define COUNT(node) words_of(P(raw).at[8u * (node) + 7u]).x
#define CHILDREN(node) words_of(P(raw).at[8u * (node) + 6u])

layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

const Aabb EMPTY = Aabb(vec3(3.4e38), vec3(-3.4e38));

uint leaf_reference(uint first, uint count) { return LEAF_BIT | (count - 1) << (31 - LEAF_BITS) | first; }

// The triangle of a Morton rank to place `to`.
void pack_triangle(uint rank, uint to) {
    uint t = P(order).at[rank];
    Corners corners = LOAD_CORNERS(source, t);
    PackedTriangle packed =
        PackedTriangle(corners.a * args.scale, corners.b * args.scale, corners.c * args.scale, t);
    STORE_PackedTriangle(triangles, to, packed)
}

// All triangles below child, from place `to` on, left to right. Returns how many.
uint pack_leaf(uint child, uint to) {
    uint first = to;
    // Nodes above the current one whose right side waits: a chain of MAX_LEAF triangles is the deepest.
    uint stack[MAX_LEAF];
    uint top = 0;
    for (;;) {
        while (child < LEAF_BIT) {
            uvec2 children = CHILDREN(child);
            stack[top++] = children.y;
            child = children.x;
        }
        pack_triangle(child & ~LEAF_BIT, to++);
        if (top == 0) return to - first;
        child = stack[--top];
    }
}
