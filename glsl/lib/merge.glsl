// Merging clusters. Wants lib/pair.glsl, args.{traversal_cost, triangle_cost, max_leaf} and the buffers nearest,
// bounds, clusters, nodes, links.

// Whether cluster i, whose least pair is key, is the second of a pair that names each other.
bool dies(uint i, uint key) {
    uint j = partner_of(i, key);
    return j < i && P(nearest).at[j] == key;
}

#ifdef MERGE
uint triangles_of(Cluster c) { return c.count & RAW_MASK; }
// Children that the packed node of a cluster has; 1: it is a leaf.
uint slots_of(Cluster c) { return (c.count >> SLOTS_SHIFT) + 1; }

// Which of two children's packed nodes go up into their parent's, which has room for WIDTH children: both, or the
// one a ray is likelier to meet, or none. Decided from below, so that no pass over the finished tree is needed.
bvec2 absorbed_of(uint slots_a, uint slots_b, float area_a, float area_b) {
    bool a = slots_a > 1 && slots_a < WIDTH, b = slots_b > 1 && slots_b < WIDTH;
    if (a && b && slots_a + slots_b > WIDTH) {
        a = area_a >= area_b;
        b = !a;
    }
    return bvec2(a, b);
}

// What the parent holds of a cluster: the bits beside its node, or its count.
uint bits_of(Cluster c, bool absorbed) {
    return c.node >= LEAF_BIT ? 0u : slots_of(c) == 1 ? COLLAPSED_BIT : absorbed ? ABSORBED_BIT : 0u;
}

void merge(Aabb box_a, Cluster a, Aabb box_b, Cluster b, out Aabb box, out Cluster cluster, out RawNode node) {
    box = merged(box_a, box_b);
    // The second cluster's rank dies once and for ever, so it numbers the node: a bijection onto 0..n−2 whatever the
    // timing.
    cluster.node = b.rank - 1;
    cluster.rank = a.rank;
    uint count = triangles_of(a) + triangles_of(b);
    // [GOLDSMITH87], [WALD07]: as an inner node, or as one leaf where that costs less.
    precise float area = half_area(box);
    precise float inner = args.traversal_cost * area + (a.cost + b.cost);
    precise float leaf = (args.triangle_cost * area) * float(count);
    bool collapsed = count <= args.max_leaf && leaf < inner;
    cluster.cost = collapsed ? leaf : inner;
    uint slots_a = slots_of(a), slots_b = slots_of(b);
    bvec2 absorbed = absorbed_of(slots_a, slots_b, half_area(box_a), half_area(box_b));
    uint slots = (absorbed.x ? slots_a : 1) + (absorbed.y ? slots_b : 1);
    cluster.count = count | (collapsed ? 0 : slots - 1) << SLOTS_SHIFT;
    uint bits_a = bits_of(a, absorbed.x), bits_b = bits_of(b, absorbed.y);
    node = RawNode(box_a, box_b, a.node | bits_a, b.node | bits_b);
    if (a.node < LEAF_BIT) {
        STORE_RawLink(links, a.node, RawLink(triangles_of(a) | bits_a, cluster.node))
    }
    if (b.node < LEAF_BIT) {
        STORE_RawLink(links, b.node, RawLink(triangles_of(b) | bits_b, cluster.node))
    }
}

// Clusters row..row + WG, below count, of the half that starts at from, to the half that starts at to; place is that of
// the first and becomes that of the next row's. All invocations must call it.
void merge_row(uint row, uint count, uint from, uint to, inout uint place) {
    uint i = row + lane();
    uint key = 0, j = 0;
    bool mutual = false;
    if (i < count) {
        key = P(nearest).at[i];
        j = partner_of(i, key);
        mutual = P(nearest).at[j] == key;
    }
    bool alive = i < count && !(mutual && j < i);
    uint total;
    uint at = place + row_scan(alive, total);
    place += total;
    if (!alive) return;
    Aabb box = LOAD_Aabb(bounds, from + i);
    Cluster cluster = LOAD_Cluster(clusters, from + i);
    if (mutual) {
        Aabb box_a = box;
        Cluster a = cluster, b = LOAD_Cluster(clusters, from + j);
        RawNode node;
        merge(box_a, a, LOAD_Aabb(bounds, from + j), b, box, cluster, node);
        STORE_RawNode(nodes, cluster.node, node)
    }
    STORE_Aabb(bounds, to + at, box)
    STORE_Cluster(clusters, to + at, cluster)
}
#endif
