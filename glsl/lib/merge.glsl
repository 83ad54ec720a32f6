// Merging clusters. Wants lib/pair.glsl, args.{traversal_cost, triangle_cost, max_leaf} and the buffers nearest,
// bounds, clusters, nodes.

// Clusters begin..end that live on, of those in a half.
uint count_living(uint begin, uint end) {
    uint living = end - begin;
    for (uint i = begin; i < end; ++i) {
        uint key = P(nearest).at[i];
        uint j = partner_of(i, key);
        if (j < i && P(nearest).at[j] == key) --living;
    }
    return living;
}

#ifdef MERGE
void merge(Aabb box_a, Cluster a, Aabb box_b, Cluster b, out Aabb box, out Cluster cluster, out RawNode node) {
    box = merged(box_a, box_b);
    // The second cluster's rank dies once and for ever, so it numbers the node: a bijection onto 0..n−2 whatever the
    // timing.
    cluster.node = b.rank - 1;
    cluster.rank = a.rank;
    uint count = (a.count & ~COLLAPSED_BIT) + (b.count & ~COLLAPSED_BIT);
    // [GOLDSMITH87], [WALD07]: as an inner node, or as one leaf where that costs less.
    precise float area = half_area(box);
    precise float inner = args.traversal_cost * area + (a.cost + b.cost);
    precise float leaf = (args.triangle_cost * area) * float(count);
    bool collapsed = count <= args.max_leaf && leaf < inner;
    cluster.count = count | (collapsed ? COLLAPSED_BIT : 0u);
    cluster.cost = collapsed ? leaf : inner;
    node.left_bounds = box_a;
    node.right_bounds = box_b;
    node.left = a.node;
    node.right = b.node;
    node.count = cluster.count;
    node.parent = INVALID;
}

// Clusters begin..end of the half that starts at from, to the half that starts at to, the first at place.
void merge_clusters(uint begin, uint end, uint from, uint to, uint place) {
    for (uint i = begin; i < end; ++i) {
        uint key = P(nearest).at[i];
        uint j = partner_of(i, key);
        bool mutual = P(nearest).at[j] == key;
        if (mutual && j < i) continue;
        Aabb box = LOAD_Aabb(bounds, from + i);
        Cluster cluster = LOAD_Cluster(clusters, from + i);
        if (mutual) {
            Aabb box_a = box;
            Cluster a = cluster, b = LOAD_Cluster(clusters, from + j);
            RawNode node;
            merge(box_a, a, LOAD_Aabb(bounds, from + j), b, box, cluster, node);
            STORE_RawNode(nodes, cluster.node, node)
            // The last pair of a node is its count and its parent.
            if (a.node < LEAF_BIT) P(nodes).at[8 * a.node + 7] = pair_of(uvec2(a.count, cluster.node));
            if (b.node < LEAF_BIT) P(nodes).at[8 * b.node + 7] = pair_of(uvec2(b.count, cluster.node));
        }
        STORE_Aabb(bounds, to + place, box)
        STORE_Cluster(clusters, to + place, cluster)
        ++place;
    }
}
#endif
