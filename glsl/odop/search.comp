// One invocation ITEMS consecutive clusters: nearest[i] is the least key of the pairs of cluster i with those within
// RADIUS of it, by the half area of their common box in that basis where it is least. Bases come in any number of
// dispatches: later ones lower what earlier ones found. Reads slabs, slots, state.
// Keeps: at least one pair of clusters names each other, for the least key of all is that of one pair.
#include "lib/pair.glsl"
#include "lib/slab.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

#include "lib/bases.glsl"
#include "lib/window.glsl"

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = invocation_index() * ITEMS;
    if (begin >= count) return;
    for (uint k = 0; k < args.count; ++k) {
        take_basis(k);
        search_window(begin, min(begin + ITEMS, count), count);
    }
}
