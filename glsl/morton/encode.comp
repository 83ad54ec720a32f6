// One invocation ITEMS triangles: keys[i] is the Morton code of the centre of its box within the scene's bounds,
// UNHITTABLE_KEY where no ray can hit it; order[i] = i. Reads triangles, bounds; ORs the live bits into bounds.
// Keeps: exact on every device: only +, −, · that Vulkan rounds correctly, no division.
#include "lib/ordered.glsl"
#include "lib/triangle.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// 1/x for x > 0 to about an ulp, from correctly rounded operations alone: the same bits everywhere.
float reciprocal(float x) {
    precise float r = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(x));
    for (int i = 0; i < 4; ++i) {
        precise float error = 1.0 - x * r;
        r = r + r * error;
    }
    return r;
}

// Bits 0..10 of x, moved to bits 0, 3, 6, …
uint spread(uint x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

// Powers of two by which coordinates are multiplied, lest differences overflow (a half), their reciprocals lose bits
// (2⁻⁶⁴), or differences be denormal, which some devices take for 0 (2⁶⁴). What is tiny has no extent along an axis on
// which it lies far out.
vec3 factors(vec3 lo, vec3 hi) {
    vec3 extent = hi * 0.5 - lo * 0.5;
    float longest = max(extent.x, max(extent.y, extent.z));
    if (longest > 1.152921504606847e18) return vec3(5.421010862427522e-20);
    if (longest > 9.094947017729282e-13) return vec3(0.5);
    return mix(vec3(18446744073709551616.0), vec3(0.0), greaterThan(max(abs(lo), abs(hi)), vec3(1.0)));
}

void main() {
    vec3 lo, hi;
    for (int k = 0; k < 3; ++k) {
        lo[k] = unordered(P(bounds).at[0].lo[k]);
        hi[k] = unordered(P(bounds).at[0].hi[k]);
    }
    vec3 factor = factors(lo, hi);
    precise vec3 extent = hi * factor - lo * factor;
    float longest = max(extent.x, max(extent.y, extent.z));
    float scale = longest > 0.0 ? reciprocal(longest) : 0.0;
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
        precise vec3 centre =
            ((least * factor - lo * factor) + (greatest * factor - lo * factor)) * (0.5 * scale);
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
