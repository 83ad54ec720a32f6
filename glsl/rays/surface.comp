// One invocation ITEMS consecutive primaries: the surfaces under them, without gaps and in order, up to the limit.
// taken[0] is how many there are in all; taken[1] becomes the primary before which the limit was reached. Reads hits,
// rays, triangles, sums (scanned).
#include "rays/surface.glsl"
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint run = invocation_index();
    uint begin = args.start + run * ITEMS;
    uint end = min(begin + ITEMS, args.end);
    if (run == 0 && P(taken).at[0] <= args.limit) P(taken).at[1] = args.end;
    if (begin >= end) return;
    uint place = P(sums).at[run];
    Surface surface;
    for (uint i = begin; i < end && place <= args.limit; ++i) {
        if (!surface_of(i, surface)) continue;
        if (place < args.limit) STORE_Surface(surfaces, place, surface)
        else P(taken).at[1] = i;
        ++place;
    }
}
