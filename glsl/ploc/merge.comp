// One workgroup WG · ITEMS clusters, a row at a time: pairs that name each other become one, written with the rest to
// the other half of bounds and clusters, in order, and a node. Reads nearest, sums, state. Keeps: cluster ranks rise.
#define MERGE
#define AREA(box, key) half_area(box)
#include "lib/pair.glsl"
#include "lib/scan.glsl"
#include "lib/round.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = group_index() * WG * ITEMS;
    if (begin >= count) return;
    uint end = min(begin + WG * ITEMS, count);
    uint odd = P(state).at[args.round].rounds & 1u;
    uint place = P(sums).at[group_index()];
    for (uint row = begin; row < end; row += WG) {
        merge_row(row, end, odd * args.capacity, (1 - odd) * args.capacity, place);
    }
}
