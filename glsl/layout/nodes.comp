// One invocation a kept node: its packed node, and the input indices of the triangles in the leaves directly below.
// Reads raw, kept, packed, leaf_triangles, order.
#include "lib/pack.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

uint pack_child(uint child, inout uint to) {
    bool inner = child < LEAF_BIT && (COUNT(child) & COLLAPSED_BIT) == 0;
    if (inner) return P(packed).at[child];
    uint count = pack_leaf(child, to);
    to += count;
    return leaf_reference(to - count, count);
}

void main() {
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, args.count);
    for (uint i = begin; i < end; ++i) {
        uint from = P(kept).at[i];
        RawNode node = LOAD_RawNode(raw, from);
        uint to = P(leaf_triangles).at[from];
        uint left = pack_child(node.left, to);
        uint right = pack_child(node.right, to);
        Node packed = Node(node.left_bounds, node.right_bounds, left, right, uvec2(0));
        STORE_Node(nodes, i, packed)
    }
}
