// A ray's way through the packed tree. Wants the buffers nodes, triangles.
#include "lib/visit.glsl"

// From a node to what comes next: its nearest child that is met, or what waited.
uint descend(uint node, inout Setup s, Nearest nearest, inout Tests tests) {
    Node n = LOAD_Node(nodes, node);
    if (STEPS != 0) count_node(true);
    // Apart from the rest: most nodes of most trees have none.
    if (in_frame(n)) turn(s, words_of(P(nodes).at[node].p[7]));
    if (COUNT != 0) count_boxes(tests, n);
    node = push_farther(n, sorted(meet_children(s, n, nearest.limit)));
    return node == INVALID ? pop_within(nearest.limit) : node;
}
