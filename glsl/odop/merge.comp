// As ploc/merge, by the area in the pair's key; slots go along with the clusters, and pairs tells those of the merged.
// Reads nearest, sums, state. Keeps: cluster ranks rise; pairs are in the order of their second clusters.
#define MERGE
#define AREA(box, key) area_of(box, key)
#include "lib/pair.glsl"
#include "lib/scan.glsl"

// That of the axis-aligned box where it is the key's as far as the colour leaves it: with no other basis this is PLOC.
float area_of(Aabb box, uint key) {
    float aligned = half_area(box);
    uint area = key & ~COLOUR_MASK;
    return (floatBitsToUint(aligned) & ~COLOUR_MASK) == area ? aligned : uintBitsToFloat(area);
}

#include "lib/round.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = group_index() * WG * ITEMS;
    if (begin >= count) return;
    uint end = min(begin + WG * ITEMS, count);
    uint from = (P(state).at[args.round].rounds & 1u) * args.capacity, to = args.capacity - from;
    uint place = P(sums).at[group_index()];
    for (uint row = begin; row < end; row += WG) {
        Moved moved = merge_row(row, end, from, to, place);
        if (moved.i < end) {
            uint slot = P(slots).at[from + moved.i];
            if (moved.partner < moved.i) {
                // Dead: so many have died before it.
                uint died = moved.i - moved.place;
                P(pairs).at[died] = pair_of(uvec2(P(slots).at[from + moved.partner], slot));
            } else {
                P(slots).at[to + moved.place] = slot;
            }
        }
    }
}
