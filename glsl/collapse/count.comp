// One workgroup WG · ITEMS raw nodes: how many triangles the leaves among the children of the packed node of each that is
// kept have (leaf_triangles); over the workgroup, sums of both (sums) and of half areas (areas). Reads raw, cuts.
#include "lib/box.glsl"
#include "lib/raw.glsl"
#include "lib/scan.glsl"
#include "lib/sum.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Triangles of the leaves among the children of the packed node of a raw node. areas gains its binary nodes' and theirs.
uint leaf_triangles_of(uint node, inout vec2 areas) {
    uint triangles = 0;
    uint waiting = INVALID;  // a packed node has room for two absorbed ones: one of them can wait
    for (;;) {
        uvec2 children = CHILDREN(node);
        Aabb boxes[2] = {CHILD_BOX(node, 0), CHILD_BOX(node, 1)};
        areas.x += half_area(merged(boxes[0], boxes[1]));
        node = INVALID;
        [[unroll]] for (int side = 0; side < 2; ++side) {
            uint child = children[side];
            if (is_absorbed(child)) {
                if (node != INVALID) waiting = node;
                node = child & RAW_MASK;
            } else if (is_leaf(child)) {
                uint count = child >= LEAF_BIT ? 1 : LOAD_RawCut(cuts, child & RAW_MASK).count;
                triangles += count;
                areas.y += half_area(boxes[side]) * float(count);
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
    vec2 areas = vec2(0);
    FOR_ITEMS(i, args.count) {
        uint here = INVALID;
        if ((LOAD_RawCut(cuts, i).choices & KEPT_BIT) != 0) {
            here = leaf_triangles_of(i, areas);
            triangles += here;
            ++kept;
        }
        P(leaf_triangles).at[i] = here;
    }
    uint all_kept, all_triangles;
    row_scan(kept, all_kept);
    row_scan(triangles, all_triangles);
    areas = workgroup_sum(areas);
    if (gl_LocalInvocationID.x == 0 && group_index() < args.groups) {
        P(sums).at[group_index()] = all_kept;
        P(sums).at[args.groups + group_index()] = all_triangles;
        P(areas).at[group_index()] = areas;
    }
}
