// One invocation ITEMS Morton ranks: the box of each triangle in unit space, and its cluster of one.
// Reads triangles, order.
#include "lib/box.glsl"
#include "lib/leaf.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    FOR_ITEMS(i, args.count) {
        Aabb box = leaf_box(P(order).at[i]);
        STORE_Aabb(bounds, i, box)
        STORE_Cluster(clusters, i, leaf_cluster(i, box))
    }
}
