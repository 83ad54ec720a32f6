// One invocation ITEMS triangles: keys[i] is the Morton code of the centre of its box within the scene's bounds (and of
// the box's diagonal over the scene's, where the code has a size), UNHITTABLE_KEY where no ray can hit it; order[i] = i.
// Reads triangles, bounds; ORs the live bits into bounds.
// Keeps: exact on every device: only +, −, · that Vulkan rounds correctly, no division, and a root put right.
#include "lib/ordered.glsl"
#include "lib/triangle.glsl"
#include "lib/reciprocal.glsl"
#include "lib/code.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// ⌊√x⌋ for x below 2³⁰. A device's √ may be off by 5 ulp, which moves the floor by one at most.
uint whole_root(uint x) {
    uint r = uint(sqrt(float(x)));
    r -= uint(r * r > x);
    return r + uint((r + 1) * (r + 1) <= x);
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
    precise vec3 edges = extent * scale;
    precise float diagonal2 = edges.x * edges.x + edges.y * edges.y + edges.z * edges.z;
    float per_diagonal2 = scale > 0.0 ? reciprocal(diagonal2) : 0.0;
    uint ones = 0, zeros = 0, low_ones = 0, low_zeros = 0;
    FOR_ITEMS(i, args.count) {
        Corners t = LOAD_CORNERS(triangles, i);
        P(order).at[i] = i;
        if (!hittable(t)) {
            P(keys).at[i] = UNHITTABLE_KEY;
            if (args.code != CODE_30) P(low_keys).at[i] = 0;
            continue;
        }
        precise vec3 least = min(t.a, min(t.b, t.c)), greatest = max(t.a, max(t.b, t.c));
        precise vec3 centre =
            ((least * factor - lo * factor) + (greatest * factor - lo * factor)) * (0.5 * scale);
        // 21 bits an axis; the upper ten of each are the 30-bit code.
        precise vec3 cell = centre * 2097152.0;
        uvec3 q = min(uvec3(max(cell, vec3(0.0))), uvec3(2097151u));
        uint key = interleave3(q >> 11);
        if (args.code != CODE_30) {
            uvec2 words;
            if (args.code == CODE_63) {
                words = code_63(q);
            } else {
                precise vec3 e = (greatest * factor - least * factor) * scale;
                // (diagonal / scene's diagonal)² in 30 bits, so its root in 15.
                precise float share2 = (e.x * e.x + e.y * e.y + e.z * e.z) * per_diagonal2 * 1073741824.0;
                uint size = whole_root(min(uint(share2), 1073741823u));
                words = args.code == CODE_EXT4 ? code_ext4(q >> 5, size) : code_ext7(q >> 3, size >> 6);
            }
            key = words.x;
            P(low_keys).at[i] = words.y;
            low_ones |= words.y;
            low_zeros |= ~words.y;
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
        if (args.code != CODE_30) {
            atomicOr(P(bounds).at[0].low_ones, low_ones);
            atomicOr(P(bounds).at[0].low_zeros, low_zeros);
        }
    }
}
