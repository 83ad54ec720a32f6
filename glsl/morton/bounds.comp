// One invocation ITEMS triangles: bounds.lo and hi take in every triangle that can be hit, hittable counts them.
// Reads triangles. Keeps: bounds only grow, so the order of invocations doesn't matter.
#include "lib/ordered.glsl"
#include "lib/triangle.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    vec3 lo = vec3(3.4e38), hi = vec3(-3.4e38);
    uint count = 0;
    FOR_ITEMS(i, args.count) {
        Corners t = LOAD_CORNERS(triangles, i);
        if (!hittable(t)) continue;
        lo = min(lo, min(t.a, min(t.b, t.c)));
        hi = max(hi, max(t.a, max(t.b, t.c)));
        ++count;
    }
    // One atomic a subgroup, not one an invocation.
    vec3 least = subgroupMin(lo), greatest = subgroupMax(hi);
    uint sum = subgroupAdd(count);
    if (subgroupElect() && sum > 0) {
        for (int k = 0; k < 3; ++k) {
            atomicMin(P(bounds).at[0].lo[k], ordered(least[k]));
            atomicMax(P(bounds).at[0].hi[k], ordered(greatest[k]));
        }
        atomicAdd(P(bounds).at[0].hittable, sum);
    }
}
