// One invocation ITEMS clusters: pairs that name each other become one, written with the rest to the other half of
// bounds and clusters, in order, and a node. Reads nearest, before, sums, state. Keeps: cluster ranks rise.
#define MERGE
#include "lib/pair.glsl"
#include "lib/merge.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = invocation_index() * ITEMS;
    if (begin >= count) return;
    uint odd = P(state).at[args.round].rounds & 1u;
    merge_clusters(begin, min(begin + ITEMS, count), odd * args.capacity, (1 - odd) * args.capacity,
                   P(sums).at[group_index()] + P(before).at[invocation_index()]);
}
