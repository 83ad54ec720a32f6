// One workgroup WG · ITEMS raw nodes: which are kept, and how many triangles the leaves among the children of each packed
// node have (leaf_triangles); sums of both over the workgroup (sums). Reads raw, links.
#include "lib/scan.glsl"
#include "lib/raw.glsl"
#include "lib/collapsed.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Triangles of the leaves among the children of the packed node of a raw node.
uint leaf_triangles_of(uint node) {
    uint triangles = 0;
    uint waiting = INVALID;  // a packed node has room for two absorbed ones: one of them can wait
    for (;;) {
        uvec2 children = CHILDREN(node);
        node = INVALID;
        for (int side = 0; side < 2; ++side) {
            uint child = children[side];
            if (is_absorbed(child)) {
                waiting = node;
                node = child & RAW_MASK;
            } else if (is_leaf(child)) {
                triangles += child >= LEAF_BIT ? 1 : LOAD_RawLink(links, child & RAW_MASK).count & RAW_MASK;
            }
        }
        if (node == INVALID) {
            if (waiting == INVALID) return triangles;
            node = waiting;
            waiting = INVALID;
        }
    }
}

void main() {
    uint kept = 0, triangles = 0;
    FOR_ITEMS(i, args.count) {
        uint here = INVALID;
        if (is_kept(i)) {
            here = leaf_triangles_of(i);
            triangles += here;
            ++kept;
        }
        P(leaf_triangles).at[i] = here;
    }
    uint all_kept, all_triangles;
    row_scan(kept, all_kept);
    row_scan(triangles, all_triangles);
    if (gl_LocalInvocationID.x == 0 && group_index() < args.groups) {
        P(sums).at[group_index()] = all_kept;
        P(sums).at[args.groups + group_index()] = all_triangles;
    }
}
