// One invocation ITEMS clusters: how many of them live on, summed over the invocations before it (before) and over
// the workgroup (sums). A cluster dies where it is the second of a pair that names each other. Reads nearest, state.
#include "lib/pair.glsl"
#include "lib/merge.glsl"
#include "lib/scan.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint begin = min(invocation_index() * ITEMS, count);
    uint end = min(begin + ITEMS, count);
    uint total;
    uint before = workgroup_scan(count_living(begin, end), total);
    P(before).at[invocation_index()] = before;
    if (gl_LocalInvocationID.x == 0) P(sums).at[group_index()] = total;
}
