// One invocation ITEMS triangles: keys[i] is the Morton code of the centre of its box within the scene's bounds,
// UNHITTABLE_KEY where no ray can hit it; order[i] = i. Reads triangles, bounds; ORs the live bits into bounds.
// Keeps: exact on every device: only +, −, · that Vulkan rounds correctly, no division.
#include "lib/ordered.glsl"
#include "lib/reciprocal.glsl"
#include "lib/triangle.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Bits 0..10 of x, moved to bits 0, 3, 6, …
uint spread(uint x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

void main() {
    vec3 lo, extent;
    for (int k = 0; k < 3; ++k) {
        lo[k] = unordered(P(bounds).at[0].lo[k]);
        extent[k] = unordered(P(bounds).at[0].hi[k]) * 0.5 - lo[k] * 0.5;  // half, lest it overflow
    }
    float longest = max(extent.x, max(extent.y, extent.z));
    // Out of the range where the reciprocal is a normal number: one point, or nothing a float can tell apart.
    float scale = longest > 1e-37 && longest < 1e37 ? reciprocal(longest) : 0.0;
    uint ones = 0, zeros = 0, low_ones = 0, low_zeros = 0;
    FOR_ITEMS(i, args.count) {
        Corners t = LOAD_CORNERS(triangles, i);
        P(order).at[i] = i;
        if (!hittable(t)) {
            P(keys).at[i] = UNHITTABLE_KEY;
            if (args.wide != 0) P(low_keys).at[i] = 0;
            continue;
        }
        precise vec3 least = min(t.a, min(t.b, t.c)), greatest = max(t.a, max(t.b, t.c));
        precise vec3 centre = ((least * 0.5 - lo * 0.5) + (greatest * 0.5 - lo * 0.5)) * (0.5 * scale);
        // 21 bits an axis; the upper ten of each are the 30-bit code.
        precise vec3 cell = centre * 2097152.0;
        uvec3 q = min(uvec3(max(cell, vec3(0.0))), uvec3(2097151u));
        uvec3 high = q >> 11;
        uint key = spread(high.x) | spread(high.y) << 1 | spread(high.z) << 2;
        if (args.wide != 0) {
            // 63 bits: 30 above, then 33 of which the first goes to the high word.
            uvec3 low = q & 2047u;
            uvec3 top = low >> 10, rest = low & 1023u;
            uint middle = top.x | top.y << 1 | top.z << 2;
            uint bottom = spread(rest.x) | spread(rest.y) << 1 | spread(rest.z) << 2;
            key = key << 1 | middle >> 2;
            uint low_key = (middle & 3u) << 30 | bottom;
            P(low_keys).at[i] = low_key;
            low_ones |= low_key;
            low_zeros |= ~low_key;
        }
        P(keys).at[i] = key;
        ones |= key;
        zeros |= ~key;
    }
    ones = subgroupOr(ones);
    zeros = subgroupOr(zeros);
    low_ones = subgroupOr(low_ones);
    low_zeros = subgroupOr(low_zeros);
    if (subgroupElect()) {
        atomicOr(P(bounds).at[0].ones, ones);
        atomicOr(P(bounds).at[0].zeros, zeros);
        if (args.wide != 0) {
            atomicOr(P(bounds).at[0].low_ones, low_ones);
            atomicOr(P(bounds).at[0].low_zeros, low_zeros);
        }
    }
}
