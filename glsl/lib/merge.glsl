// Merging clusters, whatever builder chose them. Wants lib/box.glsl, args.{traversal_cost, triangle_cost, max_leaf} and
// the buffer links.

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
