// One invocation ITEMS raw nodes, which are packed nodes of two children as well: from each node of two triangles the
// costs of the cheapest cuts climb as far as it is the last child to arrive, by the lesser of two areas: of the axis-
// aligned box, and, dearer, of extremal points in the slot's frame. Writes cuts; costs, and hands them over there; at
// the root, root. Reads nodes, raw, parents, points, ranges, frames. Keeps: nobody waits, no barrier; the same cuts
// whatever the timing.
#include "lib/points.glsl"
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/cost.glsl"
#include "lib/reference.glsl"
#include "lib/climb.glsl"
#include "lib/raw.glsl"
#include "lib/merge.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

float fitted_area(uint slot, Aabb box) {
    float area = half_area(box);
    uvec2 words = words_of(P(frames).at[slot]);
    if (is_oriented(words)) {
        vec3 r = rodrigues_of(words);
        Frame f = frame_of(r);
        vec3 e[POINTS];
        LOAD_POINTS(e, slot)
        Aabb extent = NOWHERE;
        [[unroll]] for (uint k = 0; k < POINTS; ++k) take_in(extent, within(f, e[k]));
        precise float oriented = unstretched(half_area(extent), r) * args.dearer;
        area = least_of(oriented, area);
    }
    return area;
}

// The cluster of a node's first (0) or second (1) child. Of ranks only that of the second's first triangle matters, which
// numbers the node.
Cluster below(uint node, uint side, uint child, Aabb box) {
    uint slot = 4 * node + side;
    if (child >= LEAF_BIT) {
        precise float cost = args.triangle_cost * fitted_area(slot, box);
        return Cluster(child, node + side, 1, vec3(cost));
    }
    vec3 costs = vec3(P(costs).at[3 * child], P(costs).at[3 * child + 1], P(costs).at[3 * child + 2]);
    return Cluster(child, node + side, LOAD_Range(ranges, slot).count, costs);
}

void climb(uint node) {
    uvec4 children = LOAD_Node(nodes, node).children;
    if (inner_children(children) > 0) return;
    for (;;) {
        Aabb first = CHILD_BOX(node, 0), second = CHILD_BOX(node, 1);
        Cluster a = below(node, 0, children.x, first), b = below(node, 1, children.y, second);
        uint up = P(parents).at[node];
        Cluster cluster;
        RawNode same;
        merge(first, a, second, b, fitted_area(up, merged(first, second)), cluster, same);
        if (up / 4 == args.count) {
            P(root).at[0].node = root_reference(cluster);
            P(root).at[0].cost = cluster.cost.x;
            return;
        }
        for (int k = 0; k < 3; ++k) P(costs).at[3 * node + k] = cluster.cost[k];
        node = up / 4;
        children = LOAD_Node(nodes, node).children;
        // Hand-over: the other inner child's invocation, if there is one, leaves three costs; the last to arrive has read
        // its count, so that they are visible to it. The other stores and loads nothing here any more.
        if (arrive(node) + 1 < inner_children(children)) return;
    }
}

void main() {
    FOR_ITEMS(i, args.count) climb(i);
}
