// One invocation ITEMS rays: keys[i] is the Morton code of its origin within bounds and its direction, 6-D [AILA09];
// UNORDERED_KEY where it has none; order[i] = i. Reads rays, bounds. Keeps: exact on every device: only +, −, · that
// Vulkan rounds correctly. Differs: a direction is scaled to a largest component of 1, not to unit length.
#include "lib/ordered.glsl"
#include "lib/reciprocal.glsl"
#include "raysort/orderable.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Bits 0..4 of x, moved to bits 0, 6, 12, 18 and 24: five copies side by side, of which the k-th keeps bit k.
uint spread(uint x) { return (x * 0x108421u) & 0x01041041u; }

// Cell of each coordinate of p, 0 to 1: six bits.
uvec3 cells(vec3 p) {
    precise vec3 at = p * 64.0;
    return min(uvec3(max(at, vec3(0.0))), uvec3(63u));
}

// Six bits of the origin's x and y, five of the rest, origin above direction.
uint key_of(uvec3 origin, uvec3 direction) {
    uvec3 o = origin >> 1, d = direction >> 1;
    uint upper = spread(o.x) << 5 | spread(o.y) << 4 | spread(o.z) << 3 | spread(d.x) << 2 | spread(d.y) << 1
                 | spread(d.z);
    return upper << 2 | (origin.x & 1u) << 1 | (origin.y & 1u);
}

void main() {
    precise vec3 lo, extent;
    for (int k = 0; k < 3; ++k) {
        lo[k] = unordered(P(bounds).at[0].lo[k]) * 0.5;  // half, lest the extent overflow
        extent[k] = unordered(P(bounds).at[0].hi[k]) * 0.5 - lo[k];
    }
    float longest = largest(extent);
    // Out of this range the origins are one point, or their differences may be denormal, or the reciprocal is.
    float scale = longest > 1e-30 && longest < 1e37 ? reciprocal(longest) : 0.0;
    FOR_ITEMS(i, args.count) {
        P(order).at[i] = i;
        Ray ray = LOAD_Ray(rays, i);
        if (!orderable(ray)) {
            P(keys).at[i] = UNORDERED_KEY;
            continue;
        }
        precise vec3 origin = (ray.origin * 0.5 - lo) * scale;
        vec3 level = levelled(ray.direction);
        precise vec3 direction = level * reciprocal(largest(level)) * 0.5 + 0.5;
        P(keys).at[i] = key_of(cells(origin), cells(direction));
    }
}
