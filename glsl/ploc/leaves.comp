// One invocation ITEMS Morton ranks: the box of each triangle in unit space, and its cluster of one.
// Reads triangles, order.
#include "lib/triangle.glsl"
#include "lib/pair.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, args.count);
    for (uint i = begin; i < end; ++i) {
        uint triangle = P(order).at[i];
        Corners t = LOAD_CORNERS(triangles, triangle);
        precise vec3 lo = min(t.a, min(t.b, t.c)) * args.scale - args.anchor;
        precise vec3 hi = max(t.a, max(t.b, t.c)) * args.scale - args.anchor;
        Aabb box = Aabb(lo, hi);
        precise float cost = args.triangle_cost * half_area(box);
        Cluster cluster = Cluster(LEAF_BIT | i, i, 1, cost);
        STORE_Aabb(bounds, i, box)
        STORE_Cluster(clusters, i, cluster)
    }
}
