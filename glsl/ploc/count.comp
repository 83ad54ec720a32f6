// One workgroup WG · ITEMS clusters: how many of them live on (sums). A cluster dies where it is the second of a pair
// that names each other. Reads nearest, state.
#include "lib/pair.glsl"
#include "lib/round.glsl"
#include "lib/scan.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint living = 0;
    FOR_ITEMS(i, count) living += uint(!dies(i, P(nearest).at[i]));
    uint total;
    row_scan(living, total);
    // A grid of two dimensions has workgroups beyond the last: sums has no room for theirs.
    bool wanted = group_index() * WG * ITEMS < count;
    if (gl_LocalInvocationID.x == 0 && wanted) P(sums).at[group_index()] = total;
}
