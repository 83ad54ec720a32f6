// As odop/search, for any RADIUS: one invocation ITEMS clusters, every neighbour loaded anew.
#include "lib/pair.glsl"
#include "lib/slab.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

#include "lib/bases.glsl"
#include "lib/search.glsl"

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, count);
    for (uint k = 0; k < args.count; ++k) {
        take_basis(k);
        for (uint i = begin; i < end; ++i) found(i, least_key(i, count));
    }
}
