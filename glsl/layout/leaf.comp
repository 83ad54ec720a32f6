// One invocation: the packed tree of a scene that is a single leaf. Reads raw, root, order.
#include "lib/pack.glsl"

void main() {
    if (invocation_index() != 0) return;
    uint count = pack_leaf(P(root).at[0].node, 0);
    Node node = Node(P(root).at[0].bounds, EMPTY, leaf_reference(0, count), leaf_reference(0, 1), uvec2(0));
    STORE_Node(nodes, 0, node)
}
