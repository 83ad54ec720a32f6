// One workgroup: sums[i] becomes the sum of those before it; state[round + 1] is how the next round is dispatched,
// with no workgroups where args.last clusters or fewer are left. Reads state, sums.
#include "lib/dispatch.glsl"
#include "lib/scan.glsl"

void main() {
    PlocState now = P(state).at[args.round];
    uint groups = now.clusters > args.last ? (now.clusters + args.tile - 1) / args.tile : 0;
    uint length = (groups + WG - 1) / WG;
    uint begin = min(gl_LocalInvocationID.x * length, groups);
    uint end = min(begin + length, groups);
    uint sum = 0;
    for (uint i = begin; i < end; ++i) sum += P(sums).at[i];
    uint all;
    sum = workgroup_scan(sum, all);
    for (uint i = begin; i < end; ++i) {
        uint x = P(sums).at[i];
        P(sums).at[i] = sum;
        sum += x;
    }
    if (gl_LocalInvocationID.x == 0) {
        PlocState next = now;
        if (groups > 0) {
            next.clusters = all;
            next.rounds = now.rounds + 1;
        }
        next.groups = dispatch_over(next.clusters > args.last ? next.clusters : 0, args.tile);
        P(state).at[args.round + 1] = next;
    }
}
