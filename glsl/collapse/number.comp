// One workgroup WG · ITEMS raw nodes, a row at a time: kept nodes are numbered in their order, which is that of the tree
// read left to right, and so are the triangles of their leaves. Reads sums; leaf_triangles turns from counts to firsts.
#include "lib/scan.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint begin = group_index() * WG * ITEMS;
    if (begin >= args.count) return;
    uint end = min(begin + WG * ITEMS, args.count);
    uint node = P(sums).at[group_index()];
    // Both halves of sums were scanned as one: the second counts on from the number of kept nodes.
    uint triangle = P(sums).at[args.groups + group_index()] - P(sums).at[args.groups];
    for (uint row = begin; row < end; row += WG) {
        uint i = row + lane();
        uint here = i < end ? P(leaf_triangles).at[i] : INVALID;
        bool kept = here != INVALID;
        uint all_kept, all_triangles;
        uint to = node + row_scan(kept, all_kept);
        uint first = triangle + row_scan(kept ? here : 0, all_triangles);
        if (kept) {
            P(packed).at[i] = to;
            P(kept).at[to] = i;
            P(leaf_triangles).at[i] = first;
        }
        node += all_kept;
        triangle += all_triangles;
    }
}
