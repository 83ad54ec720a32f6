// One invocation ITEMS raw nodes: which are kept, and how many triangles the leaves directly below each have; sums of
// both over the invocations before (before, two a invocation) and over the workgroup (sums). Reads nodes.
#include "lib/scan.glsl"
#include "lib/collapsed.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Triangles of child where it is a leaf of the packed tree, else 0.
uint leaf_count(uint child) {
    if (child >= LEAF_BIT) return 1;
    uint count = COUNT_PARENT(nodes, child).x;
    return (count & COLLAPSED_BIT) != 0 ? count & ~COLLAPSED_BIT : 0;
}

void main() {
    uint begin = min(invocation_index() * ITEMS, args.count);
    uint end = min(begin + ITEMS, args.count);
    uint kept = 0, triangles = 0;
    for (uint i = begin; i < end; ++i) {
        uint here = INVALID;
        if (is_kept(i)) {
            uvec2 children = CHILDREN(nodes, i);
            here = leaf_count(children.x) + leaf_count(children.y);
            triangles += here;
            ++kept;
        }
        P(leaf_triangles).at[i] = here;
    }
    uint all_kept, all_triangles;
    P(before).at[2 * invocation_index()] = workgroup_scan(kept, all_kept);
    P(before).at[2 * invocation_index() + 1] = workgroup_scan(triangles, all_triangles);
    if (gl_LocalInvocationID.x == 0 && group_index() < args.groups) {
        P(sums).at[group_index()] = all_kept;
        P(sums).at[args.groups + group_index()] = all_triangles;
    }
}
