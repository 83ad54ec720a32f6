// What a ray's way through any tree is made of. Wants the buffer triangles.
#include "lib/ray.glsl"
#include "lib/node.glsl"
#include "lib/stack.glsl"
#include "lib/hit.glsl"
#include "lib/steps.glsl"

// The next child that is not beyond `limit`; INVALID where there is none.
uint pop_within(float limit) {
    while (top > 0) {
        uvec2 popped = words_of(stack[--top]);
        if (ANY != 0 || !(entered(int(popped.x)) > limit)) return popped.y;
    }
    return INVALID;
}

// Meets the triangles of a leaf; returns whether an any-hit query is answered.
bool meet_triangles(uint leaf, Setup s, inout Nearest nearest, inout Tests tests) {
    uint place = leaf_first(leaf);
    uint end = place + leaf_count(leaf);
    bool done = false;
    for (; place < end && !done; ++place) {
        if (COUNT != 0) tests.triangles += 1;
        if (STEPS != 0) count_triangle(true);
        PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
        done = meet_triangle(s, triangle, nearest);
    }
    return done;
}

// Likewise; returns what comes next.
uint meet_leaf(uint leaf, Setup s, inout Nearest nearest, inout Tests tests) {
    return meet_triangles(leaf, s, nearest, tests) ? INVALID : pop_within(nearest.limit);
}
