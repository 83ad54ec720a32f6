// One workgroup a tile of WG · ITEMS keys, one invocation ITEMS consecutive ones: counts[digit · tiles + tile].
// Reads keys. Counters are an invocation's own, in shared memory: no atomics, any subgroup size.
#include "lib/digit.glsl"

void main() {
    uint me = gl_LocalInvocationID.x;
    uint tile = group_index();
    count_digits(tile);
    barrier();
    for (uint digit = me; digit < RADIX; digit += WG) {
        uint sum = 0;
        for (uint i = 0; i < WG; ++i) sum += counters[digit * WG + i];
        if (tile < args.tiles) P(counts).at[digit * args.tiles + tile] = sum;
    }
}
