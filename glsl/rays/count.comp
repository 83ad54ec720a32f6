// One invocation ITEMS consecutive primaries: sums gains how many of them have a surface. Reads hits, rays, triangles.
#include "rays/surface.glsl"
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint run = invocation_index();
    uint begin = args.start + run * ITEMS;
    uint end = min(begin + ITEMS, args.end);
    if (begin >= end) return;
    uint sum = 0;
    Surface surface;
    for (uint i = begin; i < end; ++i) sum += uint(surface_of(i, surface));
    P(sums).at[run] = sum;
}
