// One invocation ITEMS rays: bounds takes in the origins of those that have a key. Reads rays.
// Keeps: bounds only grow, so the order of invocations doesn't matter.
#include "lib/ordered.glsl"
#include "raysort/orderable.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    vec3 lo = vec3(3.4028235e38), hi = vec3(-3.4028235e38);
    bool some = false;
    FOR_ITEMS(i, args.count) {
        Ray ray = LOAD_Ray(rays, i);
        if (!orderable(ray)) continue;
        vec3 origin = settled(ray.origin);
        lo = min(lo, origin);
        hi = max(hi, origin);
        some = true;
    }
    // One atomic a subgroup, not one an invocation.
    vec3 least = subgroupMin(lo), greatest = subgroupMax(hi);
    some = subgroupAny(some);
    if (subgroupElect() && some) {
        for (int k = 0; k < 3; ++k) {
            atomicMin(P(bounds).at[0].lo[k], ordered(least[k]));
            atomicMax(P(bounds).at[0].hi[k], ordered(greatest[k]));
        }
    }
}
