// One invocation ITEMS consecutive clusters: nearest[i] is the least key of the pairs of cluster i with those within
// RADIUS of it. Reads bounds, state. Keeps: at least one pair of clusters names each other (see lib/pair.glsl).
#include "lib/pair.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

uint from;
Aabb box_of(uint i) { return LOAD_Aabb(bounds, from + i); }
void found(uint i, uint key) { P(nearest).at[i] = key; }

#include "lib/window.glsl"

void main() {
    uint count = P(state).at[args.round].clusters;
    from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    uint begin = invocation_index() * ITEMS;
    if (begin < count) search_window(begin, min(begin + ITEMS, count), count);
}
