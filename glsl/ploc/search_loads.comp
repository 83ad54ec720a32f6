// As ploc/search, for any RADIUS: one invocation ITEMS clusters, every neighbour loaded anew.
#include "lib/pair.glsl"
#include "lib/search.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, count);
    for (uint i = begin; i < end; ++i) P(nearest).at[i] = least_key(i, count, from);
}
