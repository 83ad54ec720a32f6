// One workgroup its share of the pairs that merged: the second one's triangles follow the first's. Reads pairs, clusters,
// state. Keeps: a cluster's triangles are a list from its rank, in no rising order.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

#include "lib/share.glsl"

uint rank_of(uint i) { return words_of(P(clusters).at[i].p[0]).y; }

// The last triangle of the cluster whose first is rank.
uint last_of(uint rank) {
    uint tail = P(tails).at[rank];
    return tail == INVALID ? rank : tail;
}

void main() {
    uint from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    uvec2 share = share_of_pairs();
    for (uint i = share.x; i < share.y; i += WG) {
        uvec2 places = words_of(P(pairs).at[i]);
        uint a = rank_of(from + places.x), b = rank_of(from + places.y);
        P(next).at[last_of(a)] = b;
        P(tails).at[a] = last_of(b);
    }
}
