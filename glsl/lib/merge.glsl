// Merging clusters, whatever builder chose them. Wants args.{node_cost, triangle_cost, max_leaf} and the buffer cuts.

// The cheapest cut of a subtree into children of packed nodes, by dynamic programming from below [YLITIE17]: what the
// cheapest cuts of both sides cost is all that their parent needs. Of equal costs a leaf, then the more children. Differs:
// a packed node costs the same whatever its number of children, for its boxes are tested together. The half area is
// the caller's, for not all builders go by that of the common box.
void merge(Aabb box_a, Cluster a, Aabb box_b, Cluster b, float area, out Cluster cluster, out RawNode node) {
    // The second cluster's rank dies once and for ever, so it numbers the node: a bijection onto 0..n−2 whatever the
    // timing.
    cluster.node = b.rank - 1;
    cluster.rank = a.rank;
    cluster.count = a.count + b.count;
    // Two, three and four children, dealt out to both sides; the first side's share is in the name.
    precise float two = a.cost.x + b.cost.x;
    precise float three_1 = a.cost.x + b.cost.y, three_2 = a.cost.y + b.cost.x;
    precise float four_1 = a.cost.x + b.cost.z, four_2 = a.cost.y + b.cost.y, four_3 = a.cost.z + b.cost.x;
    uint first_of_three = three_1 <= three_2 ? 1 : 2;
    uint first_of_four = four_2 <= four_1 && four_2 <= four_3 ? 2 : four_1 <= four_3 ? 1 : 3;
    float three = first_of_three == 1 ? three_1 : three_2;
    float four = first_of_four == 2 ? four_2 : first_of_four == 1 ? four_1 : four_3;

    precise float inner = args.node_cost * area + four;
    precise float leaf = (args.triangle_cost * area) * float(cluster.count);
    bool collapsed = cluster.count <= args.max_leaf && leaf < inner;
    cluster.cost.x = collapsed ? leaf : inner;
    bool as_two = two < cluster.cost.x || !collapsed && two == cluster.cost.x;
    cluster.cost.y = as_two ? two : cluster.cost.x;
    bool as_three = three < cluster.cost.y || (as_two || !collapsed) && three == cluster.cost.y;
    cluster.cost.z = as_three ? three : cluster.cost.y;

    uint choices = (collapsed ? 0 : first_of_four) | uint(as_two) << 2 | (as_three ? first_of_three : 0) << 4;
    STORE_RawCut(cuts, cluster.node, RawCut(cluster.count, choices))
    node = RawNode(box_a, box_b, a.node, b.node);
}

// The reference to the root: a raw node, collapsed or not, or the only triangle.
uint root_reference(Cluster root) {
    bool collapsed = root.node < LEAF_BIT && (LOAD_RawCut(cuts, root.node).choices & 3) == 0;
    return collapsed ? root.node | COLLAPSED_BIT : root.node;
}
