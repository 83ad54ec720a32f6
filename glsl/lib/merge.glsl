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
    cluster.count = a.count + b.count;
    // [Goldsmith87], [Wald07]: as an inner node, or as one leaf where that costs less.
    precise float area = half_area(box);
    precise float inner = args.traversal_cost * area + (a.cost + b.cost);
    precise float leaf = (args.triangle_cost * area) * float(cluster.count);
    bool collapsed = cluster.count <= args.max_leaf && leaf < inner;
    cluster.cost = collapsed ? leaf : inner;
    node.left_bounds = box_a;
    node.right_bounds = box_b;
    node.left = a.node;
    node.right = b.node;
    node.count = cluster.count | (collapsed ? COLLAPSED_BIT : 0u);
    node.parent = INVALID;
}

// Clusters begin..end of the half that starts at from, to the half that starts at to, the first at place.
void merge_clusters(uint begin, uint end, uint from, uint to, uint place) {
    for (uint i = begin; i < end; ++i) {
        uint key = P(nearest).at[i];
        uint j = partner_of(i, key);
        bool mutual = P(nearest).at[j] == key;
        if (mutual && j < i) continue;
        Aabb box = P(bounds).at[from + i];
        Cluster cluster = P(clusters).at[from + i];
        if (mutual) {
            Aabb box_a = box;
            Cluster a = cluster, b = P(clusters).at[from + j];
            RawNode node;
            merge(box_a, a, P(bounds).at[from + j], b, box, cluster, node);
            P(nodes).at[cluster.node] = node;
            if (a.node < LEAF_BIT) P(nodes).at[a.node].parent = cluster.node;
            if (b.node < LEAF_BIT) P(nodes).at[b.node].parent = cluster.node;
        }
        P(bounds).at[to + place] = box;
        P(clusters).at[to + place] = cluster;
        ++place;
    }
}
#endif
