// One workgroup, each invocation one run of consecutive numbers: sums[i] becomes the sum of those before it, total
// the sum of all.
#include "lib/scan.glsl"

void main() {
    uint length = (args.count + WG - 1) / WG;
    uint begin = min(gl_LocalInvocationID.x * length, args.count);
    uint end = min(begin + length, args.count);
    uint sum = 0;
    for (uint i = begin; i < end; ++i) sum += P(sums).at[i];
    uint all;
    sum = workgroup_scan(sum, all);
    for (uint i = begin; i < end; ++i) {
        uint x = P(sums).at[i];
        P(sums).at[i] = sum;
        sum += x;
    }
    if (gl_LocalInvocationID.x == 0) P(total).at[0] = all;
}
