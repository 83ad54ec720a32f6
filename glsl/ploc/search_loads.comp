// As ploc/search, for any RADIUS: one invocation ITEMS clusters, every neighbour loaded anew.
#include "lib/pair.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

uint from;
Aabb box_of(uint i) { return LOAD_Aabb(bounds, from + i); }

#include "lib/search.glsl"

void main() {
    uint count = P(state).at[args.round].clusters;
    from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, count);
    for (uint i = begin; i < end; ++i) P(nearest).at[i] = least_key(i, count);
}
