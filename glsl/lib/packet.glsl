// Loads that a subgroup shares: each invocation fetches one pair of words and all get all of them. Every invocation
// of the subgroup must be active. Subgroups of 4 fetch twice.
PAIR shared_pair(PAIR low, PAIR high, uint k) {
    uvec2 words = gl_SubgroupSize >= 8 || k < 4 ? words_of(low) : words_of(high);
    return pair_of(subgroupBroadcast(words, gl_SubgroupSize >= 8 ? k : k & 3u));
}

#define SHARED(b, i, last, low, high)                                                                                 \
    PAIR low = P(b).at[i].p[min(gl_SubgroupInvocationID & (gl_SubgroupSize >= 8 ? 7u : 3u), last)], high = low;         \
    if (gl_SubgroupSize < 8) high = P(b).at[i].p[min(4u + (gl_SubgroupInvocationID & 3u), last)];

Node shared_node(uint node) {
    SHARED(nodes, node, 7u, low, high)
    return Node_of(shared_pair(low, high, 0), shared_pair(low, high, 1), shared_pair(low, high, 2),
                   shared_pair(low, high, 3), shared_pair(low, high, 4), shared_pair(low, high, 5),
                   shared_pair(low, high, 6), shared_pair(low, high, 7));
}

PackedTriangle shared_triangle(uint place) {
    SHARED(triangles, place, 4u, low, high)
    return PackedTriangle_of(shared_pair(low, high, 0), shared_pair(low, high, 1), shared_pair(low, high, 2),
                             shared_pair(low, high, 3), shared_pair(low, high, 4));
}
