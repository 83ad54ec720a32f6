// One invocation ITEMS raw nodes: kept nodes are numbered in their order, which is that of the tree read left to
// right, and so are the triangles of their leaves. Reads before, sums; leaf_triangles turns from counts to firsts.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, args.count);
    if (begin >= end) return;
    uint node = P(sums).at[group_index()] + P(before).at[2 * invocation_index()];
    // Both halves of sums were scanned as one: the second counts on from the number of kept nodes.
    uint all_kept = P(sums).at[args.groups];
    uint triangle = P(sums).at[args.groups + group_index()] - all_kept + P(before).at[2 * invocation_index() + 1];
    for (uint i = begin; i < end; ++i) {
        uint here = P(leaf_triangles).at[i];
        bool is_kept = here != INVALID;
        if (is_kept) {
            P(packed).at[i] = node;
            P(kept).at[node] = i;
            P(leaf_triangles).at[i] = triangle;
            ++node;
            triangle += here;
        }
    }
}
