// One workgroup WG · ITEMS raw nodes: how many are kept (sums), and the half areas of their boxes (areas). Reads raw, cuts.
#include "lib/box.glsl"
#include "lib/raw.glsl"
#include "lib/scan.glsl"
#include "lib/sum.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// areas gains those of the binary nodes that become the packed node of a raw node, and those of its leaves times their
// triangles.
void add_areas(uint node, inout vec2 areas) {
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
                areas.y += half_area(boxes[side]) * float(count);
            }
        }
        if (node == INVALID) {
            if (waiting == INVALID) return;
            node = waiting;
            waiting = INVALID;
        }
    }
}

void main() {
    uint kept = 0;
    vec2 areas = vec2(0);
    FOR_ITEMS(i, args.count) {
        if ((LOAD_RawCut(cuts, i).choices & KEPT_BIT) != 0) {
            add_areas(i, areas);
            ++kept;
        }
    }
    uint all_kept;
    row_scan(kept, all_kept);
    areas = workgroup_sum(areas);
    // A grid of two dimensions has workgroups beyond the last.
    if (gl_LocalInvocationID.x == 0 && group_index() * WG * ITEMS < args.count) {
        P(sums).at[group_index()] = all_kept;
        P(areas).at[group_index()] = areas;
    }
}
