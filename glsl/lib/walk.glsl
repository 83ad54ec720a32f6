// A ray's way through the tree. Wants the buffers nodes, triangles.
#include "lib/ray.glsl"
#include "lib/node.glsl"
#include "lib/stack.glsl"
#include "lib/hit.glsl"

// The next child that is not beyond t; INVALID where there is none.
uint pop_within(float t) {
    while (top > 0) {
        uvec2 popped = words_of(stack[--top]);
        if (ANY != 0 || !(entered(int(popped.x)) > t)) return popped.y;
    }
    return INVALID;
}

// From a node to what comes next: its nearest child that is met, or what waited.
uint descend(uint node, inout Setup s, Nearest nearest, inout Tests tests) {
    Node n = LOAD_Node(nodes, node);
    // Apart from the rest: most nodes of most trees have none.
    if (in_frame(n)) turn(s, words_of(P(nodes).at[node].p[7]));
    if (COUNT != 0) count_boxes(tests, n);
    node = push_farther(n, sorted(meet_children(s, n, nearest.t)));
    return node == INVALID ? pop_within(nearest.t) : node;
}

// Meets the triangles of a leaf; returns whether an any-hit query is answered.
bool meet_triangles(uint leaf, Setup s, inout Nearest nearest, inout Tests tests) {
    uint place = leaf_first(leaf);
    uint end = place + leaf_count(leaf);
    bool done = false;
    for (; place < end && !done; ++place) {
        if (COUNT != 0) tests.triangles += 1;
        PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
        done = meet_triangle(s, triangle, nearest);
    }
    return done;
}

// Likewise; returns what comes next.
uint meet_leaf(uint leaf, Setup s, inout Nearest nearest, inout Tests tests) {
    return meet_triangles(leaf, s, nearest, tests) ? INVALID : pop_within(nearest.t);
}
